"""Frames as files give them: a place, turns, or a point to look at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.files.entry import Entry
from stiffkit.spatial import Frame, axis_rotation, exp_rotation
from stiffkit.units import ANGLE, LENGTH

Array = NDArray[np.float64]


def read_frame(
    entry: Entry, *, at: str = "at", rotate: str = "rotate", towards: str | None = None
) -> Frame:
    """Return the frame that the keys ``at``, ``rotate`` and ``towards`` of a mapping give.

    Each may be absent. Raises FileError where they contradict each other.
    """
    position = np.zeros(3)
    if (at_entry := entry.get(at)) is not None:
        position = at_entry.vector(LENGTH)
    rotate_entry = entry.get(rotate)
    if towards is not None and (towards_entry := entry.get(towards)) is not None:
        if rotate_entry is not None:
            raise towards_entry.error(
                f"'{towards}' and '{rotate}' cannot stand together", "remove one of the two"
            )
        return Frame(_rotation_towards(towards_entry, position), position)
    return Frame(np.eye(3) if rotate_entry is None else _rotation(rotate_entry), position)


def _rotation(entry: Entry) -> Array:
    """Return the rotation (3x3) of a turn, or of a list of turns about the turned axes."""
    turns = entry.elements() if isinstance(entry.node.value, list) else [entry]
    R = np.eye(3)
    for turn in turns:
        for axis, angle in turn.items():
            R = R @ axis_rotation(axis, angle.quantity(ANGLE))
    return R


def _rotation_towards(entry: Entry, origin: Array) -> Array:
    """Return the smallest rotation (3x3) that makes x point from the origin at a point (3,)."""
    distance = entry.vector(LENGTH) - origin
    length = float(np.linalg.norm(distance))
    if length <= 1e-12 * max(1.0, float(np.linalg.norm(origin))):
        raise entry.error(
            "the point is the joint's own origin, it gives no direction", "move it, or use 'rotate'"
        )
    direction = distance / length
    across = np.cross([1.0, 0.0, 0.0], direction)
    sine = float(np.linalg.norm(across))
    if sine == 0.0:
        return axis_rotation("z", 0.0 if direction[0] > 0.0 else np.pi)
    return exp_rotation(across / sine * np.arctan2(sine, direction[0]))
