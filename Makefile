# Every target sets up what it needs; nothing has to be installed by hand but Python 3.11, git and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.ready
DEMO := out/biglide
DOCS := out/docs

.PHONY: demo docs test lint format bench bench-fea bench-peers lock clean

demo: $(STAMP)
	$(BIN)/stiffkit map biglide -o $(DEMO)

# Notebooks are run, warnings are errors, and every link must lead somewhere. Nothing is fetched.
docs: $(STAMP)
	rm -rf $(DOCS)
	$(BIN)/python -m sphinx -q -W --keep-going -E -d $(DOCS)/.doctrees docs $(DOCS)
	$(BIN)/python docs/_ext/check_site.py $(DOCS)
	@echo "open $(DOCS)/index.html"

test: lint
	requirements/need-browser.sh
	requirements/need-calculix.sh
	requirements/need-fortran.sh
	$(BIN)/pytest -n auto --dist worksteal

lint: $(STAMP)
	$(BIN)/ruff format --check src tests benchmarks docs
	$(BIN)/ruff check src tests benchmarks docs
	$(BIN)/mypy

format: $(STAMP)
	$(BIN)/ruff format src tests benchmarks docs
	$(BIN)/ruff check --fix src tests benchmarks docs

bench: $(STAMP)
	requirements/need-browser.sh
	$(BIN)/python -m benchmarks

bench-fea: $(STAMP)
	requirements/need-calculix.sh
	$(BIN)/python -m benchmarks.fea --json out/bench-fea.json

bench-peers: $(STAMP) out/peers/.ready
	$(BIN)/python -m benchmarks.peers --python out/peers/bin/python

out/peers/.ready: requirements/peers.txt requirements/make-peers.sh
	requirements/make-peers.sh $(PYTHON) out/peers
	touch $@

$(STAMP): requirements/dev.lock pyproject.toml requirements/make-venv.sh
	requirements/make-venv.sh $(PYTHON) $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/dev.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

# Needs uv; run it after the dependencies in pyproject.toml change.
lock:
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	  --no-annotate --no-header --extra dev -q -o requirements/dev.lock pyproject.toml

clean:
	rm -rf $(VENV) out .pytest_cache .mypy_cache .ruff_cache .hypothesis
