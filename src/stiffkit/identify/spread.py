"""How the nodes of a field lie: in a point, on a line, in a plane, or in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffkit.errors import FieldError
from stiffkit.spatial.rotation import Array

POINT_TOLERANCE = 1e-9
"""A field this small, over the size of its coordinates, is one point."""
FLAT_TOLERANCE = 1e-6
"""An extent this small, over the largest one, counts as none."""


@dataclass(frozen=True, eq=False)
class Spread:
    """The weighted mean and spread of points."""

    centre: Array
    """(3,), m, the weighted mean of the points."""
    axes: Array
    """(3, 3), columns are the principal axes, longest first, right-handed."""
    extents: Array
    """(3,), m, root-mean-square distance from the centre along each principal axis."""
    dimension: int
    """0 one point, 1 a line, 2 a plane, 3 a volume."""

    @staticmethod
    def of(points: Array, relative_weights: Array) -> Spread:
        """Return the spread of points (n, 3) in m with weights (n,) of mean 1."""
        count = len(points)
        centre = relative_weights @ points / count
        local = points - centre
        # The mean of what is left corrects the rounding of a field far from the origin.
        correction = relative_weights @ local / count
        local -= correction
        covariance = local.T @ (relative_weights[:, None] * local) / count
        values, vectors = np.linalg.eigh(covariance)
        axes = vectors[:, ::-1].copy()
        if np.linalg.det(axes) < 0.0:
            axes[:, 2] = -axes[:, 2]
        extents = np.sqrt(np.maximum(values[::-1], 0.0))
        size = float(np.abs(points).max())
        if extents[0] <= POINT_TOLERANCE * size:
            dimension = 0
        else:
            dimension = int((extents > FLAT_TOLERANCE * extents[0]).sum())
        return Spread(centre + correction, axes, extents, dimension)

    @property
    def radius(self) -> float:
        """Root-mean-square distance of the points from their centre, m."""
        return float(np.linalg.norm(self.extents))


def require_rotations_seen(spread: Spread) -> None:
    """Raise `FieldError` if points with this spread do not show all three rotations."""
    if spread.dimension == 0:
        raise FieldError(
            f"all nodes lie in one point, {_triple(spread.centre)} m: "
            "a rotation about x, y or z cannot be seen",
            mend="select at least 3 nodes around the reference point that are not on one line",
        )
    if spread.dimension == 1:
        raise FieldError(
            f"all nodes lie on one line through {_triple(spread.centre)} m: a rotation about "
            f"that line, along {direction_words(spread.axes[:, 0])}, cannot be seen",
            mend="add nodes beside this line",
        )


def direction_words(direction: Array) -> str:
    """Return a unit vector (3,), whose sense does not count, as x, y, z or its components."""
    rounded = np.round(direction, 3) + 0.0
    if rounded[np.flatnonzero(rounded)[0]] < 0.0:
        rounded = -rounded + 0.0
    for name, axis in zip("xyz", np.eye(3), strict=True):
        if np.array_equal(rounded, axis):
            return name
    return "({:g}, {:g}, {:g})".format(*rounded)


def _triple(values: Array) -> str:
    return "({:.6g}, {:.6g}, {:.6g})".format(*values)
