"""How far sliding joints go, for guides of the right length."""

from __future__ import annotations

import numpy as np

from stiffkit.kinematics import Locator
from stiffkit.robot import Joint
from stiffkit.spatial.rotation import Array

_SLIDING = ("prismatic", "cylindrical")

_TRIED = 8
"""Postures at which joints that close a loop are looked at."""

Stroke = tuple[float, float]
"""Lowest and highest coordinate along a joint's axis, m."""


def strokes(locator: Locator, q: Array) -> dict[str, Stroke]:
    """Return how far each sliding joint goes in postures (n, P) of the tree, P > 0.

    Of joints that close a loop a few postures tell, as their coordinates are not among the tree's.
    """
    tree = locator.tree
    found = {
        t.joint.name: (float(q[t.coordinates.start].min()), float(q[t.coordinates.start].max()))
        for t in tree.joints
        if t.joint.kind in _SLIDING
    }
    chords = [joint for joint in tree.chords if joint.kind in _SLIDING]
    if chords:
        which = np.unique(np.linspace(0, q.shape[1] - 1, _TRIED).astype(np.intp))
        places = [locator.at(column) for column in q[:, which].T]
        for joint in chords:
            values = [
                _slid(joint, at.from_side(joint).inverse.point(at.to_side(joint).position))
                for at in places
            ]
            found[joint.name] = (min(values), max(values))
    return found


def _slid(joint: Joint, position: Array) -> float:
    """Return the coordinate along a joint's axis of a position (3,) in the ``from`` frame."""
    return float(position["xyz".index(joint.axes[0])])
