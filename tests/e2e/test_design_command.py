"""Design studies from the command line: from a file to better dimensions, killed and resumed."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from stiffkit.compiled import heyoka_available

from .commandline import ENDS_WITHIN, STIFFKIT, output_of, refusal_of, run

STUDY = """\
design: Arms of the five-bar
robot: five-bar
vary:
  proximal: {from: 180 mm, to: 230 mm}
  distal: {from: 365 mm, to: 400 mm}
postures: 20
models: [refined, simplified]
objectives:
  weakest: {maximise: {min: stiffness_translation_min}}
  weight: {minimise: mass}
constraints:
  light: {of: mass, below: start}
method: {gradient: {starts: 1, points: 1}, evolution: {population: 6, generations: 4}, seed: 1}
"""

pytestmark = pytest.mark.skipif(not heyoka_available(), reason="takes long without a compiler")


@pytest.fixture
def here(tmp_path: Path) -> Path:
    (tmp_path / "arms.yaml").write_text(STUDY, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return where the study was run, by a command that nobody disturbed."""
    here = tmp_path_factory.mktemp("undisturbed")
    (here / "arms.yaml").write_text(STUDY, encoding="utf-8")
    told = output_of("design", "arms.yaml", "-o", "out", cwd=here)
    for words in ("start, refined", "best, simplified", "light", "kg", "designs evaluated", "N/m"):
        assert words in told
    return here


def designs_in(here: Path) -> xr.Dataset:
    return xr.load_dataset(here / "out" / "designs.nc", engine="h5netcdf")


def test_both_models_get_better_designs(undisturbed: Path) -> None:
    told = json.loads(
        output_of("design", "arms.yaml", "-o", "out", "--no-report", "--json", cwd=undisturbed)
    )
    start, best = told["start"], told["best"]
    for model in ("refined", "simplified"):
        assert best[model]["weakest"][model] > 1.1 * start["weakest"][model]
        assert best[model]["light"][model] <= start["light"][model] * (1.0 + 1e-6)
        assert best[model]["reached"][model] == 1.0
    # Each model's best is the better one by that model.
    assert best["refined"]["weakest"]["refined"] >= best["simplified"]["weakest"]["refined"]
    assert told["evaluations"]["gradient"]["geometries"] > 0
    assert told["message"] == ""


def test_files_are_there_and_true(undisturbed: Path) -> None:
    out = undisturbed / "out"
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Arms of the five-bar" in page
    assert list((out / "figures").glob("*.svg"))
    designs = designs_in(undisturbed)
    number = json.loads(designs.attrs["chosen"])["refined"]
    summary = json.loads(output_of("pose", "out/best-refined.yaml", "--json", cwd=undisturbed))
    assert summary["status"] == "ok"
    text = (out / "best-refined.yaml").read_text(encoding="utf-8")
    assert f"{1e3 * float(designs.distal[number]):.6g}"[:6] in text


def test_a_robot_file_for_any_design(undisturbed: Path) -> None:
    output_of("design", "arms.yaml", "-o", "out", "--no-report", "--robot", "2", cwd=undisturbed)
    output_of("check", "out/design-2.yaml", cwd=undisturbed)
    message = refusal_of(
        "design", "arms.yaml", "-o", "out", "--no-report", "--robot", "99999", cwd=undisturbed
    )
    assert "there is no design 99999" in message


def test_interrupted_killed_and_resumed_it_ends_the_same(here: Path, undisturbed: Path) -> None:
    steps = here / "out" / "steps"
    message = stopped(here, steps, 2, signal.SIGINT)
    assert "the same command goes on" in message
    assert "Traceback" not in message
    stopped(here, steps, 6, signal.SIGKILL)
    before = {p.name: p.stat().st_mtime_ns for p in steps.glob("*.npz")}
    output_of("design", "arms.yaml", "-o", "out", "--no-report", cwd=here)
    after = {p.name: p.stat().st_mtime_ns for p in steps.glob("*.npz")}
    assert before.items() <= after.items(), "a finished step was computed again"
    resumed, whole = designs_in(here), designs_in(undisturbed)
    for name in whole.variables:
        if name not in ("created",):
            np.testing.assert_array_equal(resumed[name].values, whole[name].values, err_msg=name)
    assert resumed.attrs["chosen"] == whole.attrs["chosen"]


def stopped(here: Path, steps: Path, count: int, how: signal.Signals) -> str:
    """Run the study, stop it when so many steps are finished, and return what it said."""
    process = start(here)
    try:
        wait_for(process, steps, count)
        process.send_signal(how)
        _, message = process.communicate(timeout=ENDS_WITHIN)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == (130 if how is signal.SIGINT else -how)
    return message


def start(here: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [STIFFKIT, "design", "arms.yaml", "-o", "out", "--no-report"],
        cwd=here,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def wait_for(process: subprocess.Popen[str], steps: Path, count: int) -> None:
    """Wait until so many steps are finished."""
    deadline = time.monotonic() + ENDS_WITHIN
    while len(list(steps.glob("*.npz"))) < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline, "nothing happened"
        time.sleep(0.005)


def test_what_clashes_is_named(here: Path) -> None:
    text = STUDY.replace("below: start}", "below: 4.2 kg}\n  large: {of: size, above: 560 mm}")
    text = text.replace("365 mm", "330 mm")
    text = text.replace("[refined, simplified]", "[refined]")
    text = text[: text.index("method:")] + "method: {gradient: {starts: 1}}\n"
    (here / "arms.yaml").write_text(text, encoding="utf-8")
    ended = run("design", "arms.yaml", "-o", "out", cwd=here)
    assert ended.returncode == 0, ended.stderr
    assert "infeasible: refined model: 'light'" in ended.stdout
    assert "cannot be met together" in ended.stdout
    assert "best" not in ended.stdout
    assert (here / "out" / "report.html").exists()


def test_what_is_wrong_is_told_at_once(here: Path) -> None:
    (here / "wrong.yaml").write_text(STUDY.replace("proximal", "proximl"), encoding="utf-8")
    message = refusal_of("design", "wrong.yaml", "-o", "out", cwd=here)
    assert "wrong.yaml:4: vary.proximl: five-bar has no parameter 'proximl'" in message
    assert not (here / "out").exists()
    (here / "out").mkdir()
    (here / "out" / "letter.txt").write_text("dear")
    message = refusal_of("design", "arms.yaml", "-o", "out", cwd=here)
    assert "holds no design study" in message
    assert "there is no such file" in refusal_of("design", "nothing.yaml", cwd=here)


def test_the_schema_is_printed(here: Path) -> None:
    schema = json.loads(output_of("schema", "design", cwd=here))
    assert "objectives" in schema["required"]
