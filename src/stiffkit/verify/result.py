"""What a verification found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiffkit.robot import DIRECTIONS
from stiffkit.spatial.rotation import Array

SIGNIFICANT = 1e-3
"""Elements kij of a compliance above this share of sqrt(kii kjj) are compared."""


@dataclass(frozen=True)
class Compared:
    """A number by three ways."""

    name: str
    """Such as "x,ry" for an element of the compliance, or "mode 1"."""
    reduced: float
    """As the robot's links are."""
    same_meshes: float
    """With links that were reduced on the meshes of the whole."""
    whole: float

    @property
    def difference(self) -> float:
        """The reduced model's relative difference from the whole."""
        return self.reduced / self.whole - 1.0

    @property
    def modelling(self) -> float:
        """The part of it that is not the meshes': that of reduction and assembly."""
        return self.same_meshes / self.whole - 1.0

    @property
    def discretisation(self) -> float:
        """The part of it that is the meshes'."""
        return self.difference - self.modelling

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            **vars(self),
            "difference": self.difference,
            "modelling": self.modelling,
            "discretisation": self.discretisation,
        }


@dataclass(frozen=True)
class VerifiedPart:
    """One distinct part of the whole."""

    links: tuple[str, ...]
    """The links that it is."""
    part: str
    """The CAD file, or the name of the parametric part."""
    elements: int
    order: int
    """The highest one."""
    unknowns: int
    """Of one of these parts."""
    estimate: float | None
    """Estimated relative error of the link's own compliance; None where there is none."""
    own_mesh: bool
    """Whether the link was reduced on this very mesh and order."""


@dataclass(frozen=True, eq=False)
class VerifiedPosture:
    """A posture by the reduced model and by finite elements of the whole robot; SI, world axes."""

    tool: Array
    """(6,), tool pose, m and rad."""
    reduced: Array
    """(6, 6), the compliance as `stiffkit pose` has it."""
    same_meshes: Array
    """(6, 6), with links that were reduced on the meshes of the whole."""
    whole: Array
    """(6, 6), of the whole."""
    frequencies: tuple[Compared, ...]
    """Hz, lowest first."""
    residual: float
    """Largest relative residual of the whole's solutions."""
    seconds: float
    """That the whole's solution took, without meshes and matrices of the parts."""
    notes: tuple[str, ...] = ()

    @property
    def elements(self) -> tuple[Compared, ...]:
        """The significant elements of the compliance, on and above the diagonal."""
        return tuple(self._elements())

    def _elements(self) -> Iterator[Compared]:
        size = np.sqrt(np.diag(self.whole))
        for i in range(6):
            for j in range(i, 6):
                if abs(self.whole[i, j]) <= SIGNIFICANT * size[i] * size[j]:
                    continue
                values = (k[i, j].item() for k in (self.reduced, self.same_meshes, self.whole))
                yield Compared(f"{DIRECTIONS[i]},{DIRECTIONS[j]}", *values)

    @property
    def largest(self) -> Mapping[str, float]:
        """Largest relative differences, by what they are of: compliance and frequencies."""
        return {
            "compliance": max(abs(one.difference) for one in self.elements),
            "compliance_modelling": max(abs(one.modelling) for one in self.elements),
            "frequencies": max((abs(one.difference) for one in self.frequencies), default=0.0),
            "frequencies_modelling": max(
                (abs(one.modelling) for one in self.frequencies), default=0.0
            ),
        }

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "tool": dict(zip(DIRECTIONS, self.tool.tolist(), strict=True)),
            "largest_differences": dict(self.largest),
            "compliance": {
                "reduced": self.reduced.tolist(),
                "same_meshes": self.same_meshes.tolist(),
                "whole": self.whole.tolist(),
            },
            "elements": [one.as_json() for one in self.elements],
            "frequencies": [one.as_json() for one in self.frequencies],
            "residual": self.residual,
            "seconds": self.seconds,
            "notes": list(self.notes),
        }


@dataclass(frozen=True, eq=False)
class Verification:
    """A robot's reduced model beside finite elements of the whole, at one posture or several."""

    robot: str
    title: str
    postures: tuple[VerifiedPosture, ...]
    parts: tuple[VerifiedPart, ...]
    rigid: tuple[str, ...]
    """Links that are rigid."""
    n_unknowns: int
    """Of the whole."""
    seconds: float
    """Of all of it."""
    peak_memory: float
    """bytes, of the process until the end."""

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "robot": self.robot,
            "title": self.title,
            "significant": SIGNIFICANT,
            "postures": [one.as_json() for one in self.postures],
            "parts": [{**vars(part), "links": list(part.links)} for part in self.parts],
            "rigid": list(self.rigid),
            "unknowns": self.n_unknowns,
            "seconds": self.seconds,
            "peak_memory": self.peak_memory,
            "units": {
                "compliance": "m/N, 1/N, rad/(N m)",
                "frequencies": "Hz",
                "tool": "m, rad",
                "peak_memory": "bytes",
            },
        }
