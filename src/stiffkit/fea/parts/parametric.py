"""What a parametric part is: dimensions with defaults, named faces, and a way to build it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from stiffkit.errors import CadError
from stiffkit.fea.geometry import MM
from stiffkit.files.names import suggest
from stiffkit.units import LENGTH, Dimension

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

    def dimension(self, name: str) -> PartDimension:
        """Return the dimension of a name. Raises `CadError` if there is none."""
        known = {dimension.name: dimension for dimension in self.dimensions}
        if name not in known:
            raise CadError(f"{self.name} has no dimension '{name}'", mend=suggest(name, known))
        return known[name]

    def complete(self, given: Mapping[str, float]) -> dict[str, float]:
        """Return all dimensions, SI, with defaults for those that are not given.

        Raises `CadError` if one is unknown or not positive, or they do not fit together.
        """
        for name, value in given.items():
            self.dimension(name)
            if not (math.isfinite(value) and value > 0.0):
                raise CadError(f"{self.name}: {name} is {value:g} and must be positive")
        complete = {one.name: float(given.get(one.name, one.default)) for one in self.dimensions}
        self.check(complete)
        return complete


def require(holds: bool, what: str, mend: str) -> None:
    """Raise `CadError` with ``what`` and ``mend`` unless something holds."""
    if not holds:
        raise CadError(what, mend=mend)


def require_ring(d: Dimensions) -> None:
    """Raise `CadError` unless the dimension "bore" leaves 2 mm of "ring" all round."""
    require(
        d["bore"] + 4e-3 <= d["ring"],
        f"a bore of {millimetres(d['bore'])} leaves less than 2 mm of a ring of"
        f" {millimetres(d['ring'])}",
        "make the bore smaller, or the ring larger",
    )


def bored(body: Any, pin: Any, name: str) -> Any:
    """Return a shape without a pin, with ``name`` for the faces of the hole that it leaves."""
    for face in pin.faces:
        face.name = name
    return body - pin


def millimetres(value: float) -> str:
    """Return a length in m as text in mm."""
    return f"{value / MM:.6g} mm"
