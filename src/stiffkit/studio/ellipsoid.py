"""Stiffness at a point as an ellipsoid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffkit.spatial.rotation import Array
from stiffkit.stiffness import PrincipalAxes
from stiffkit.studio.mesh import Mesh, unit_ball

LONGEST = 50.0
"""The longest axis that is drawn, over the shortest."""


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid around the origin, world axes."""

    mesh: Mesh
    half_axes: Array
    """(3,), m, as drawn, weakest first."""
    is_cut: bool
    """Whether an axis is drawn shorter than it is, as it would be `LONGEST` times another."""


def ellipsoid(axes: PrincipalAxes, reference: float, size: float) -> Ellipsoid:
    """Return the ellipsoid of the stiffnesses of one block, translation or rotation.

    Half an axis is as long as the stiffness along it: ``size`` (m) for the stiffness ``reference``
    (N/m or N m/rad). A sphere of that size stands for what yields in no direction, and counts as
    cut.
    """
    stiffness = np.asarray(axes.stiffness, dtype=float)
    weakest = float(stiffness.min())
    yields = bool(np.isfinite(weakest))
    drawn = np.minimum(stiffness, LONGEST * weakest) if yields else np.full(3, reference)
    half = size * drawn / reference
    is_cut = bool(np.any(drawn < stiffness))
    return Ellipsoid(_stretched(half, axes.directions), half, is_cut)


def _stretched(half: Array, directions: Array) -> Mesh:
    """Return a ball stretched to half axes (3,) along the columns of ``directions`` (3, 3)."""
    # A left-handed set of axes would turn the ball inside out.
    turn = directions * np.array([1.0, 1.0, np.sign(np.linalg.det(directions))])
    unit = unit_ball(3)
    return Mesh((unit.vertices * half) @ turn.T, unit.faces)
