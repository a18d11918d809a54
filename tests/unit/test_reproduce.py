"""What is printed beside what is computed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from stiffkit.cli.commands import main
from stiffkit.reproduce import Entry, Verdict, study_noise
from stiffkit.reproduce.pashkevich_2009 import AMPLITUDES, SIGMA


@pytest.mark.parametrize(
    ("printed", "ours", "verdict"),
    [
        ("0.48", 0.4849, Verdict.AGREES),
        ("0.48", 0.4851, Verdict.DIFFERS),
        ("2e-6", 1.51e-6, Verdict.AGREES),
        ("2e-6", 1.49e-6, Verdict.DIFFERS),
        ("1.36e-6", 1.3551e-6, Verdict.AGREES),
        ("1.36e-6", 1.354e-6, Verdict.DIFFERS),
    ],
)
def test_verdicts_go_by_the_printed_digits(printed: str, ours: float, verdict: Verdict) -> None:
    assert Entry("x", printed, ours, "mm").verdict is verdict


def test_an_error_of_rounding_is_a_bound() -> None:
    assert Entry("x", "1e-16", 0.0, "mm", is_bound=True).verdict is Verdict.BELOW
    assert Entry("x", "1e-16", 2e-16, "mm", is_bound=True).verdict is Verdict.DIFFERS


def test_the_noise_of_few_fields_is_that_of_equation_20() -> None:
    study = study_noise(2000)
    assert study.translation_std == pytest.approx(SIGMA / np.sqrt(1331), rel=1e-12)
    spread = study.errors.std(axis=0, ddof=1)
    expected = np.array([study.translation_std] * 3 + [study.rotation_std] * 3)
    np.testing.assert_allclose(spread, expected, rtol=4.0 / np.sqrt(2 * 2000))
    small = AMPLITUDES < 0.3
    half = np.degrees(np.radians(AMPLITUDES[small]) ** 2 / 2.0)
    np.testing.assert_allclose(study.linearisation[small], half, rtol=0.01)
    assert (study.total >= study.linearisation).all()


def test_the_command(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["reproduce", "pashkevich-2009", "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert done.output.count("differs") == 3
    assert "SVD+ at 5 deg" in done.output
    content = json.loads((tmp_path / "out" / "reproduction.json").read_text("utf-8"))
    differing = [e["where"] for e in content["entries"] if e["verdict"] == "differs"]
    assert differing == [
        "Table 3, SVD+ at 5 deg",
        "Section 3.5, s.t.d. of translation",
        "Section 3.5, linearisation",
    ]
    assert all(entry["why"] for entry in content["entries"] if entry["verdict"] == "differs")
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"reproduction.json"} | {
        f"figure-{n}.{k}" for n in "12" for k in ("svg", "png")
    }
