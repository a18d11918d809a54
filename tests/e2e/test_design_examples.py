"""The studies in examples/ end at designs that are better than the published machines."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from stiffkit.compiled import heyoka_available

from .commandline import run

EXAMPLES = Path(__file__).parents[2] / "examples"

pytestmark = pytest.mark.skipif(not heyoka_available(), reason="takes long without a compiler")


def designed(name: str, here: Path) -> dict[str, Any]:
    """Return what a study ends at."""
    shutil.copy(EXAMPLES / name, here)
    ended = run("design", name, "-o", "out", "--no-report", "--json", cwd=here, timeout=600)
    assert ended.returncode == 0, ended.stderr
    found: dict[str, Any] = json.loads(ended.stdout)
    return found


def test_a_stiffer_orthoglide_of_the_same_workspace_and_mass(tmp_path: Path) -> None:
    found = designed("orthoglide-design.yaml", tmp_path)
    start, best = found["start"], found["best"]["refined"]
    assert best["weakest"]["refined"] > 3.5 * start["weakest"]["refined"]
    assert best["twist"]["refined"] > start["twist"]["refined"]
    assert best["light"]["refined"] <= start["light"]["refined"] * (1.0 + 1e-6)
    assert best["reached"]["refined"] == 1.0
    # Evolution alone needs 1000 geometries for a design that is less stiff.
    assert found["evaluations"]["gradient"]["geometries"] < 200


def test_the_models_disagree_on_the_best_biglide(tmp_path: Path) -> None:
    """The conclusion of Briot et al. 2009, section 2.3."""
    found = designed("biglide-design.yaml", tmp_path)
    start, best = found["start"], found["best"]
    refined, simplified = best["refined"], best["simplified"]
    assert refined["weakest"]["refined"] > 1.4 * start["weakest"]["refined"]
    assert refined["light"]["refined"] < start["light"]["refined"]
    assert refined["fast"]["refined"] > start["fast"]["refined"]
    assert simplified["weakest"]["simplified"] > start["weakest"]["simplified"]
    # Its legs are longer, and by the refined model it is softer than the machine.
    assert simplified["L1"] + simplified["L2"] > start["L1"] + start["L2"]
    assert refined["L1"] + refined["L2"] < start["L1"] + start["L2"]
    assert simplified["weakest"]["refined"] < start["weakest"]["refined"]
