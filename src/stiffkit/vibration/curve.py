"""Lines through points: bent centre lines of elastic links, outlines of rigid ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_POINTS = 25
"""On the centre line of an elastic link."""


def bent_line(stations: Array, twists: Array, along: Array) -> tuple[Array, Array]:
    """Return points on a line, as shares (m,) of its length, and their displacements (n, m, 3).

    See `bent_twists`.
    """
    shares = np.linspace(0.0, 1.0, _POINTS)
    moved = bent_twists(stations, twists, along, shares)[:, :3]
    return shares, moved.transpose(2, 0, 1)


def bent_twists(stations: Array, twists: Array, along: Array, shares: Array) -> Array:
    """Return the twists (m, 6, n) of a line's sections at ``shares`` (m,) of its length.

    The twists (s, 6, n) at stations (s,), m along the unit vector ``along`` (3,), are joined by
    cubics that have the twists' slopes across the line, and straight along it. Sections stay square
    to the line, and turn about it evenly between stations. A rigid motion comes out as it is.
    """
    at = shares * stations[-1]
    piece = np.clip(np.searchsorted(stations, at, side="right") - 1, 0, stations.size - 2)
    h = np.diff(stations)[piece]
    r = ((at - stations[piece]) / h)[:, None, None]
    h = h[:, None, None]
    translation, rotation = np.split(twists.transpose(0, 2, 1), 2, axis=2)
    slope = np.cross(rotation, along)
    a, b = translation[piece], translation[piece + 1]
    # A turn of the section tilts the line across; stretch is what the ends' difference says.
    stretch = ((b - a) @ along)[..., None] * along / h
    slope_a, slope_b = slope[piece] + stretch, slope[piece + 1] + stretch
    moved = (
        (1 - 3 * r**2 + 2 * r**3) * a
        + (3 * r**2 - 2 * r**3) * b
        + h * (r - 2 * r**2 + r**3) * slope_a
        + h * (r**3 - r**2) * slope_b
    )
    tilt = (
        6 * (r**2 - r) * (a - b) / h
        + (1 - 4 * r + 3 * r**2) * slope_a
        + (3 * r**2 - 2 * r) * slope_b
    )
    spin = (rotation @ along)[..., None] * along
    turned = np.cross(along, tilt) + (1 - r) * spin[piece] + r * spin[piece + 1]
    return np.asarray(np.concatenate([moved, turned], axis=2).transpose(0, 2, 1))


def outline(points: list[Array], tolerance: float) -> list[Array]:
    """Return the lines (m, 3) that stand for a rigid body with joints at some points (3,).

    Two points are joined; more of them by a closed line around their centre, in the plane that fits
    them best, or one after the other where they lie on a line. A body with fewer has no lines.
    Points nearer than ``tolerance`` (m) are one.
    """
    distinct: list[Array] = []
    for p in points:
        if all(np.linalg.norm(p - other) > tolerance for other in distinct):
            distinct.append(p)
    if len(distinct) < 2:
        return []
    corners = np.array(distinct)
    centred = corners - corners.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred)
    if sizes[1] <= tolerance:
        return [corners[np.argsort(centred @ axes[0])]]
    x, y = centred @ axes[0], centred @ axes[1]
    around = corners[np.argsort(np.arctan2(y, x))]
    return [np.concatenate([around, around[:1]])]
