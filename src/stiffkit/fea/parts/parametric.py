"""What a parametric part is: dimensions with defaults, named faces, and a way to build it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from stiffkit.errors import CadError
from stiffkit.files.names import suggest
from stiffkit.units import LENGTH, Dimension

MM = 1e3
"""Millimetres in a metre: the CAD kernel's tolerances are made for millimetres."""

Dimensions = Mapping[str, float]
"""Every dimension of a part, SI."""


@dataclass(frozen=True)
class PartDimension:
    """A dimension of a part."""

    name: str
    default: float
    """SI."""
    means: str
    source: str
    """Where the default comes from: printed and where, inferred and from what, or chosen."""
    unit: Dimension = LENGTH


@dataclass(frozen=True, eq=False)
class ParametricPart:
    """A part that a function of this package builds with OpenCASCADE from numbers alone."""

    name: str
    title: str
    description: str
    """Shape, axes and origin, in words."""
    edition: int
    """Raised when the same dimensions give another shape, so that older solutions are not taken."""
    dimensions: tuple[PartDimension, ...]
    faces: Mapping[str, str]
    """Names of faces, and what each is."""
    check: Callable[[Dimensions], None]
    """Raises `CadError` where the dimensions do not fit together; needs no CAD kernel."""
    build: Callable[[Dimensions], Any]
    """Returns the shape, mm; runs in the child process only."""

    def complete(self, given: Mapping[str, float]) -> dict[str, float]:
        """Return all dimensions, SI, with defaults for those that are not given.

        Raises `CadError` if one is unknown or not positive, or they do not fit together.
        """
        known = [dimension.name for dimension in self.dimensions]
        for name, value in given.items():
            if name not in known:
                raise CadError(f"{self.name} has no dimension '{name}'", mend=suggest(name, known))
            if not (math.isfinite(value) and value > 0.0):
                raise CadError(f"{self.name}: {name} is {value:g} and must be positive")
        complete = {one.name: float(given.get(one.name, one.default)) for one in self.dimensions}
        self.check(complete)
        return complete


def require(holds: bool, what: str, mend: str) -> None:
    """Raise `CadError` with ``what`` and ``mend`` unless something holds."""
    if not holds:
        raise CadError(what, mend=mend)


def millimetres(value: float) -> str:
    """Return a length in m as text in mm."""
    return f"{MM * value:.6g} mm"
