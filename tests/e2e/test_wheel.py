"""The wheel: what is in it, and that it works where nothing but its requirements is installed."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from email.message import Message
from email.parser import BytesParser
from importlib.metadata import Distribution, distribution
from pathlib import Path
from zipfile import ZipFile

import pytest
from packaging.requirements import Requirement

from .commandline import ENDS_WITHIN, SMALL_ROBOT, output_of

SOURCE = Path(__file__).parents[2]

EVOLUTION = """\
design: Arms
robot: five-bar
vary: {proximal: {from: 180 mm, to: 220 mm}}
objectives: {weakest: {maximise: {min: stiffness_translation_min}}}
method: {evolution: {population: 8, generations: 2}}
"""

STUDY = """\
study: Arms
robot: five-bar
vary: {proximal: [200 mm]}
postures: 10
"""

FIELDS = """\
identify: Arm
units: {length: m}
fields: arm.vtu
reference: [0, 0, 0]
loads: {a: {force: [1 N, 0, 0]}}
"""

WITHOUT_EXTRA = {
    ("link", "part.step", "--faces"): ("NGSolve", "fea"),
    ("map", "orthoglide-cad", "--points", "9"): ("NGSolve", "fea"),
    ("verify", "orthoglide-cad"): ("NGSolve", "fea"),
    ("identify", "fields.yaml"): ("meshio", "fields"),
    ("study", "run", "study.yaml", "--cluster", "tcp://127.0.0.1:1"): ("distributed", "cluster"),
    ("design", "evolution.yaml"): ("pymoo", "design"),
    ("studio", "five-bar", "--no-open"): ("viser", "studio"),
}
"""Commands, with the library that each asks for and the extra that has it."""


ASK = """\
import contextlib, io, json, sys
from stiffkit.cli import main

answers = []
for command in json.load(sys.stdin):
    sys.argv = ["stiffkit", *command]
    said, status = io.StringIO(), 0
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            main()
        except SystemExit as end:
            status = end.code
    answers.append((status, said.getvalue()))
json.dump(answers, sys.stdout)
"""
"""Runs commands one after the other in one process, and tells how each ends and what it says."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel, built from the source."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=SOURCE, check=True, capture_output=True)
    [built] = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def stiffkit(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return the command of the wheel, installed with its requirements and nothing else.

    Nothing is fetched: what is required is linked from here. What is not required, not even by
    what is required, does not exist there.
    """
    environment = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    [packages] = environment.glob("lib/python*/site-packages")
    for path in required(metadata_of(wheel).get_all("Requires-Dist", [])):
        (packages / path.name).symlink_to(path)
    pip = [sys.executable, "-m", "pip", "--python", str(environment / "bin" / "python")]
    options = ["--quiet", "--disable-pip-version-check", "--no-index", "--no-compile"]
    subprocess.run([*pip, "install", *options, str(wheel)], check=True)
    return str(environment / "bin" / "stiffkit")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a directory with files for the commands, far from the source."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("PYTHONPATH", raising=False)
    for name, text in {
        "two-arms.yaml": SMALL_ROBOT,
        "part.step": "ISO-10303-21;\n",
        "evolution.yaml": EVOLUTION,
        "study.yaml": STUDY,
        "fields.yaml": FIELDS,
        "arm.vtu": "<VTKFile/>\n",
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def metadata_of(wheel: Path) -> Message:
    """Return the wheel's metadata."""
    with ZipFile(wheel) as archive:
        [name] = [n for n in archive.namelist() if n.endswith(".dist-info/METADATA")]
        return BytesParser().parsebytes(archive.read(name))


def required(requirements: list[str]) -> set[Path]:
    """Return the files and folders of all that is required, and of what that requires."""
    paths: set[Path] = set()
    waiting = list(needed_here(requirements, {""}))
    seen: set[str] = set()
    while waiting:
        requirement = waiting.pop()
        if str(requirement) in seen:
            continue
        seen.add(str(requirement))
        package = distribution(requirement.name)
        paths |= parts_of(package)
        waiting += needed_here(package.requires or [], {"", *requirement.extras})
    return paths


def needed_here(requirements: list[str], extras: set[str]) -> Iterator[Requirement]:
    """Yield the requirements that hold on this computer."""
    for requirement in map(Requirement, requirements):
        marker = requirement.marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in extras):
            yield requirement


def parts_of(package: Distribution) -> set[Path]:
    """Return the files and folders of an installed package at the top of ``site-packages``."""
    tops = {file.parts[0] for file in package.files or [] if file.parts[0] != ".."}
    return {Path(str(package.locate_file(top))) for top in tops - {"__pycache__"}}


def test_everything_is_in_it_and_nothing_else(wheel: Path) -> None:
    names = set(ZipFile(wheel).namelist())
    package = SOURCE / "src"
    ours = {
        path.relative_to(package).as_posix()
        for path in (package / "stiffkit").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    described = {name for name in names if ".dist-info/" in name}
    assert names - described == ours
    assert "stiffkit/py.typed" in names
    assert "stiffkit/robot/catalogue/five-bar.yaml" in names
    for room in ("robot", "link", "fea", "identify", "study", "design", "design/uncertainty"):
        assert f"stiffkit/{room}/schema.json" in names
    assert {"LICENSE", "METADATA", "entry_points.txt"} <= {Path(n).name for n in described}


def test_the_metadata_tell_what_it_is(wheel: Path) -> None:
    metadata = metadata_of(wheel)
    assert metadata["License-Expression"] == "Apache-2.0"
    assert metadata["Requires-Python"] == ">=3.11"
    assert metadata["Description-Content-Type"] == "text/markdown"
    description = metadata.get_payload()
    assert isinstance(description, str)
    assert description.startswith("# stiffkit\n")
    # The index shows it alone: no picture or page lies beside it.
    assert re.findall(r"\]\((?!https:|#)[^)]*\)", description) == []
    extras = set(metadata.get_all("Provides-Extra", []))
    assert {extra for _, extra in WITHOUT_EXTRA.values()} <= extras


def test_it_works_without_any_extra(stiffkit: str, here: Path) -> None:
    assert "stiffkit map biglide" in output_of("--help", cwd=here, program=stiffkit)
    assert "refined" in output_of("pose", "five-bar", cwd=here, program=stiffkit)
    told = output_of(
        "map", "two-arms.yaml", "--points", "9", "-o", "map", cwd=here, program=stiffkit
    )
    assert "open map/report.html" in told
    assert (here / "map" / "map.nc").exists()


def test_what_needs_an_extra_names_it(stiffkit: str, here: Path) -> None:
    python = str(Path(stiffkit).with_name("python"))
    asked = subprocess.run(
        [python, "-c", ASK],
        cwd=here,
        input=json.dumps(list(WITHOUT_EXTRA)),
        capture_output=True,
        text=True,
        check=True,
        timeout=ENDS_WITHIN,
    )
    answers = zip(WITHOUT_EXTRA.items(), json.loads(asked.stdout), strict=True)
    for (command, (library, extra)), (status, said) in answers:
        assert status == 2, (command, said)
        assert said.startswith("error: "), (command, said)
        assert f"{library} is needed for" in said.replace("'", ""), (command, said)
        assert f"pip install 'stiffkit[{extra}]'" in said, (command, said)
        assert said.count("error: ") == 1, (command, said)
        assert len(said.splitlines()) == 2, (command, said)
