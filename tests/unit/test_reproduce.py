"""What is printed beside what is computed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from stiffkit.cli.commands import main
from stiffkit.reproduce import AMPLITUDES, Entry, Verdict, pashkevich_2009, study_noise
from stiffkit.reproduce import pashkevich_2009_cantilever as cantilever
from stiffkit.reproduce import pashkevich_2009_orthoglide as orthoglide
from stiffkit.reproduce.pashkevich_2009 import SIGMA
from stiffkit.reproduce.pashkevich_2009_cantilever import MESHINGS


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


def test_a_deviation_is_relative_to_the_printed_number() -> None:
    entry = Entry("x", "0.10", 0.15, "%", converged=0.05)
    assert entry.deviation == pytest.approx(0.5)
    assert entry.as_json()["converged"] == 0.05


DIFFERING = [
    "Table 3, SVD+ at 5 deg",
    "Section 3.5, s.t.d. of translation",
    "Section 3.5, linearisation",
]


def run(target: Path) -> tuple[str, dict[str, Any], set[str]]:
    """Run the command and return what it prints, what it writes as JSON, and names of files."""
    done = CliRunner().invoke(main, ["reproduce", "pashkevich-2009", "-o", str(target)])
    assert done.exit_code == 0, done.output
    content = json.loads((target / "reproduction.json").read_text("utf-8"))
    return done.output, content, {path.name for path in target.iterdir()}


def figures(count: int) -> set[str]:
    return {
        f"pashkevich-2009-figure-{n}.{kind}" for n in range(1, count + 1) for kind in ("svg", "png")
    }


def test_the_command_without_finite_elements(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for section in (pashkevich_2009, orthoglide):
        monkeypatch.setattr(section, "is_installed", lambda: False)
    printed, content, names = run(tmp_path / "out")
    assert "pip install 'stiffkit[fea]'" in printed
    assert [e["where"] for e in content["entries"] if e["verdict"] == "differs"] == DIFFERING
    assert all(entry["why"] for entry in content["entries"] if entry["verdict"] == "differs")
    assert names == {"reproduction.json", "reproduction.html"} | figures(2)


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("netgen.occ")
    coarsest = next(m for m in MESHINGS if m.name == "parabolic 5 mm")
    monkeypatch.setattr(orthoglide, "is_installed", lambda: False)
    monkeypatch.setattr(pashkevich_2009, "USUAL", (coarsest,))
    monkeypatch.setattr(cantilever, "REFERENCE", (5.0, 3))
    printed, content, names = run(tmp_path / "out")
    assert "Table 5, parabolic 5 mm" in printed
    assert "Table 5, linear 1 mm: left out" in printed
    assert len(content["cantilever"]["meshes"]) == 1
    assert len(content["cantilever"]["left_out"]) == len(MESHINGS) - 1
    differing = [entry for entry in content["entries"] if entry["verdict"] == "differs"]
    assert [entry["where"] for entry in differing][:3] == DIFFERING
    assert all(entry["why"] for entry in differing)
    assert names == {"reproduction.json", "reproduction.html"} | figures(3)


def test_meshes_too_large_for_the_memory_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("netgen.occ")
    monkeypatch.setattr(cantilever, "free_bytes", lambda: 0.6e9)
    monkeypatch.setattr(cantilever, "REFERENCE", (20.0, 2))
    found = cantilever.study_cantilever([m for m in MESHINGS if m.name == "parabolic 2 mm"])
    assert found.levels == ()
    reasons = {meshing.name: why for meshing, why in found.left_out}
    assert "2.5 GB" in reasons["parabolic 2 mm"]
    assert found.finest is None
