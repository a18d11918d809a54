"""Which nodes a deflection is read from: regions, and what several of them have in common.

Points are in metres here, as everywhere inside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.errors import FieldError
from stiffkit.identify.elements import Array, Integers
from stiffkit.identify.field import Field
from stiffkit.identify.readers.content import FieldFile, named_nodes

Point = tuple[float, float, float]

ROUNDING = 1e-6
"""Share of the body's size by which a node may miss a region: text files keep six digits."""


class Region(Protocol):
    """A part of the body, given by place or by name."""

    @property
    def words(self) -> str:
        """What the region is, to follow "nodes": ``in the set 'tip'``."""
        ...

    def distance(self, file: FieldFile) -> Array:
        """Return how far each node (n,) is from the region: zero inside, infinite if unknown."""
        ...


@dataclass(frozen=True)
class InSet:
    """The nodes of a named set or face."""

    name: str

    @property
    def words(self) -> str:
        """The set's name."""
        return f"in the set '{self.name}'"

    def distance(self, file: FieldFile) -> Array:
        """Return zero in the set and infinity elsewhere."""
        if self.name not in file.sets:
            raise FieldError(
                f"{file.path} has no node set '{self.name}'", mend=_known_sets(self.name, file)
            )
        return _by_number(file, file.sets[self.name], f"the set '{self.name}'")


@dataclass(frozen=True)
class Listed:
    """Single nodes by their numbers."""

    ids: tuple[int, ...]

    @property
    def words(self) -> str:
        """How many, and the first few."""
        return f"in the list of {named_nodes(self.ids)}"

    def distance(self, file: FieldFile) -> Array:
        """Return zero for listed nodes and infinity for others."""
        return _by_number(file, np.array(self.ids, dtype=np.int64), "the list")


@dataclass(frozen=True)
class Box:
    """A box along the axes between two opposite corners."""

    low: Point
    high: Point

    def __post_init__(self) -> None:
        """Refuse a box whose corners are not in order."""
        if not all(a <= b for a, b in zip(self.low, self.high, strict=True)):
            raise FieldError(
                f"the box from {_point(self.low)} to {_point(self.high)} holds no point",
                mend="give the smaller coordinates first",
            )

    @property
    def words(self) -> str:
        """The two corners."""
        return f"in the box from {_point(self.low)} to {_point(self.high)}"

    def distance(self, file: FieldFile) -> Array:
        """Return the distance to the box."""
        outside = np.maximum(self.low - file.points, file.points - self.high)
        return np.asarray(np.linalg.norm(np.maximum(outside, 0.0), axis=1))


@dataclass(frozen=True)
class Sphere:
    """All points within a radius of a centre."""

    centre: Point
    radius: float

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive."""
        _check_positive("the radius of a sphere", self.radius)

    @property
    def words(self) -> str:
        """Radius and centre."""
        return f"in the sphere of radius {_length(self.radius)} around {_point(self.centre)}"

    def distance(self, file: FieldFile) -> Array:
        """Return the distance to the ball."""
        return _beyond(file, self.centre, self.radius)


@dataclass(frozen=True)
class Near:
    """All points within a distance of the reference point."""

    reference: Point
    reach: float

    def __post_init__(self) -> None:
        """Refuse a distance that is not positive."""
        _check_positive("the distance to the reference point", self.reach)

    @property
    def words(self) -> str:
        """The distance and the reference point."""
        return f"within {_length(self.reach)} of the reference point {_point(self.reference)}"

    def distance(self, file: FieldFile) -> Array:
        """Return by how much the distance to the reference point is too large."""
        return _beyond(file, self.reference, self.reach)


@dataclass(frozen=True)
class Layer:
    """A plane with a thickness, half of it on either side; the normal may have any length."""

    point: Point
    normal: Point
    thickness: float

    def __post_init__(self) -> None:
        """Refuse a normal without direction and a negative thickness."""
        if not np.linalg.norm(self.normal) > 0.0:
            raise FieldError("the normal of a layer is zero", mend="give it a direction: [1, 0, 0]")
        if not self.thickness >= 0.0:
            raise FieldError(
                f"the thickness of a layer is {_length(self.thickness)}",
                mend="give zero for the nodes on the plane, or a positive thickness",
            )

    @property
    def words(self) -> str:
        """Thickness, point and normal."""
        normal = "(" + ", ".join(f"{x:.6g}" for x in self.normal) + ")"
        return (
            f"in the layer {_length(self.thickness)} thick through {_point(self.point)}, "
            f"normal {normal}"
        )

    def distance(self, file: FieldFile) -> Array:
        """Return the distance to the layer."""
        normal = np.asarray(self.normal) / np.linalg.norm(self.normal)
        height = np.abs((file.points - self.point) @ normal)
        return np.asarray(np.maximum(height - self.thickness / 2.0, 0.0))


@dataclass(frozen=True, eq=False)
class Selection:
    """Chosen nodes: ``rows`` (k,) of the field, their ``ids`` (k,), and the choice in words."""

    rows: Integers
    ids: Integers
    words: str


def select(file: FieldFile, *regions: Region) -> Selection:
    """Return the nodes that lie in all regions; all nodes where no region is given.

    Raises ``FieldError`` where there are none, saying how far the nearest node is, or where a set
    is unknown or has nodes without displacement.
    """
    tolerance = ROUNDING * float(np.linalg.norm(np.ptp(file.points, axis=0)))
    distances = [region.distance(file) for region in regions]
    inside = np.ones(len(file.ids), dtype=bool)
    for distance in distances:
        inside &= distance <= tolerance
    rows = np.flatnonzero(inside)
    if rows.size == 0:
        raise _nothing(file, regions, distances, tolerance)
    where = " and ".join(region.words for region in regions) or "of the whole field"
    noun = "node" if rows.size == 1 else "nodes"
    return Selection(rows, file.ids[rows], f"{rows.size} {noun} {where}")


def field_of(
    file: FieldFile,
    selection: Selection,
    cases: Sequence[str] | None = None,
    weights: ArrayLike | None = None,
) -> Field:
    """Return the field of the selected nodes in some load cases, or in all the file has.

    ``weights`` (k,) are in the order of the selection. Raises ``FieldError`` for load cases that
    the file does not have.
    """
    names = tuple(file.cases) if cases is None else tuple(cases)
    unknown = [name for name in names if name not in file.cases]
    if unknown:
        raise FieldError(
            f"{file.path} has no load case '{unknown[0]}'", mend=f"it has {', '.join(file.cases)}"
        )
    displacements = np.stack([file.cases[name][selection.rows] for name in names])
    points = file.points[selection.rows]
    return Field(points, displacements, weights, names, selection.ids)


def nearest(file: FieldFile, point: ArrayLike) -> tuple[int, float]:
    """Return the number of the node that is nearest to a point (3,), and its distance."""
    away = np.linalg.norm(file.points - np.asarray(point, dtype=float), axis=1)
    row = int(np.argmin(away))
    return int(file.ids[row]), float(away[row])


def _nothing(
    file: FieldFile, regions: Sequence[Region], distances: Sequence[Array], tolerance: float
) -> FieldError:
    """Return the error of an empty selection."""
    said = []
    for region, distance in zip(regions, distances, strict=True):
        count = int(np.count_nonzero(distance <= tolerance))
        row = int(np.argmin(distance))
        far = f", the nearest is node {file.ids[row]}, {_length(distance[row])} away"
        told = count == 0 and bool(np.isfinite(distance[row]))
        said.append(f"{count} nodes are {region.words}{far if told else ''}")
    if all(np.count_nonzero(distance <= tolerance) for distance in distances):
        said.append("none is in all of these")
    low, high = file.points.min(axis=0), file.points.max(axis=0)
    return FieldError(
        f"{file.path}: no node is selected: {'; '.join(said)}",
        mend=f"the nodes lie between {_point(low)} and {_point(high)}: "
        "check the place and its unit, or enlarge the region",
    )


def _by_number(file: FieldFile, ids: Integers, what: str) -> Array:
    """Return zero for the nodes with these numbers and infinity for others."""
    rows = file.rows(ids)
    if (rows < 0).any():
        raise FieldError(
            f"{file.path}: {what} names {named_nodes(ids[rows < 0])}, which the file does not have",
            mend="export the displacements of all nodes of the set, or leave these out of it",
        )
    distance = np.full(len(file.ids), np.inf)
    distance[rows] = 0.0
    return distance


def _known_sets(name: str, file: FieldFile) -> str:
    """Return what to do about an unknown set."""
    if not file.sets:
        return "the file holds no sets: add a file that does, or select nodes by their place"
    folded: dict[str, str] = {known.casefold(): known for known in file.sets}
    close = [folded[match] for match in get_close_matches(name.casefold(), list(folded), n=1)]
    listed = ", ".join(sorted(file.sets))
    return f"did you mean '{close[0]}'? It has {listed}" if close else f"it has {listed}"


def _beyond(file: FieldFile, centre: Point, radius: float) -> Array:
    """Return the distance of the nodes to a ball."""
    away = np.linalg.norm(file.points - np.asarray(centre), axis=1)
    return np.asarray(np.maximum(away - radius, 0.0))


def _check_positive(what: str, value: float) -> None:
    if not value > 0.0:
        raise FieldError(f"{what} is {_length(value)}", mend="give a positive length")


def _length(metres: float) -> str:
    """Return a length in words."""
    return f"{1e3 * metres:.6g} mm"


def _point(point: ArrayLike) -> str:
    """Return a place in words."""
    return "(" + ", ".join(f"{1e3 * x:.6g}" for x in np.asarray(point, dtype=float)) + ") mm"
