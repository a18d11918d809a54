"""The parts that both programs compute."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffkit.fea import FacePick, Interface, Part, Port, build_part, find_ports
from stiffkit.fea.square_bar import square_bar
from stiffkit.link import Material
from stiffkit.spatial.rotation import Array

STEEL = Material("steel", E=2e11, nu=0.266, density=7800.0)

REFERENCES = Path(__file__).with_name("references.json")
"""Converged compliances, which ``python -m benchmarks.fea.references`` computes again."""

_SHAPES = Path(__file__).parents[2] / "tests" / "unit" / "fea_shapes.py"


@dataclass(frozen=True)
class Case:
    """A part with its two interfaces, and the meshes that it is compared on."""

    name: str
    build: Callable[[], Part]
    base: str
    """The face that is clamped."""
    tip: str
    """The face that is loaded and read."""
    size: float
    """m, of elements, for the comparison at equal unknowns."""
    finer: tuple[float, ...]
    """m, sizes of meshes for CalculiX's convergence, with ``size`` among them."""
    tolerances: tuple[float, ...]
    """Relative errors to be reached."""

    def ports(self, part: Part, kind: str = "average") -> tuple[Port, ...]:
        """Return the clamped port and the loaded one, which is of a kind."""
        return find_ports(
            part,
            [
                Interface("base", FacePick(names=(self.base,)), "clamped"),
                Interface("tip", FacePick(names=(self.tip,)), kind),
            ],
        )

    def reference(self) -> Array:
        """Return the stored compliance (6, 6) of the average tip, converged."""
        stored = json.loads(REFERENCES.read_text("utf-8"))
        return np.array(stored[self.name]["compliance"])


CASES = {
    case.name: case
    for case in (
        Case(
            "cantilever",
            lambda: square_bar(1.0, 0.01),
            "base",
            "tip",
            0.0035,
            (0.005, 0.004, 0.0035, 0.0028, 0.0025),
            (1e-3,),
        ),
        Case(
            "foot",
            lambda: build_part(_SHAPES, "foot"),
            "ground",
            "bore",
            0.0036,
            (0.006, 0.0045, 0.0036, 0.003),
            (1e-2, 1e-3),
        ),
    )
}
"""The cantilever of A. Pashkevich, A. Klimchik, D. Chablat, 42nd CIRP Conference on Manufacturing
Systems, 2009, and a curved foot with fillets and bolt holes."""
