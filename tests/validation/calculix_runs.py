"""CalculiX (Debian's calculix-ccx), as validation runs it: pieces of its input, and its run."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

needs_calculix = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX is not installed: apt-get install calculix-ccx"
)


def clamped_solid(elements: str, E: float, nu: float) -> list[str]:
    """Return what a set of elements is made of, and that the nodes of the set BASE are held."""
    material = ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{E}, {nu}"]
    return [
        *material,
        f"*SOLID SECTION, ELSET={elements}, MATERIAL=STEEL",
        "*BOUNDARY",
        "BASE, 1, 3",
    ]


def static_step(forces: NDArray[np.float64]) -> list[str]:
    """Return a step with forces (n, 3) on all nodes, whose displacements are written."""
    lines = ["*STEP", "*STATIC", "*CLOAD, OP=NEW"]
    for node, axis in np.argwhere(forces).tolist():
        lines.append(f"{node + 1}, {axis + 1}, {forces[node, axis]:.12e}")
    return [*lines, "*NODE FILE", "U", "*END STEP"]


def run_calculix(folder: Path, name: str, deck: list[str]) -> None:
    """Write NAME.inp into a folder and solve it; results are in NAME.frd."""
    (folder / f"{name}.inp").write_text("\n".join([*deck, ""]), encoding="ascii")
    done = subprocess.run(
        ["ccx", "-i", name], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
