"""The kind of a face's surface, told from the kernel's own text form of it (BREP)."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from stiffkit.spatial.rotation import Array

_PLANE, _CYLINDER = "1", "2"

_NEAR = 1e-4
"""Points lie on a surface when this near, over the size of the face (they are single precision)."""


def surface_kind(brep: str, points: Array) -> dict[str, Any]:
    """Return ``kind`` (plane, cylinder, other) and, of a cylinder, ``radius`` and ``axis``.

    ``brep`` is the text of a single face (Open CASCADE, "BRep Format", section 5: surface records
    are a type, an origin, an axis, two more axes, and a radius), ``points`` (n, 3) lie on it. The
    text may hold the face moved; a surface that does not hold the points is therefore tried with
    each of the text's motions, and called "other" if none fits.
    """
    record = _surface_record(brep)
    if record is None or record[0] not in (_PLANE, _CYLINDER):
        return {"kind": "other"}
    kind, values = record
    size = float(np.ptp(points, axis=0).max())
    for rotation, shift in [(np.eye(3), np.zeros(3)), *_motions(brep)]:
        origin = rotation @ values[:3] + shift
        axis = rotation @ values[3:6]
        height = (points - origin) @ axis
        if kind == _PLANE:
            if np.abs(height).max() <= _NEAR * size:
                return {"kind": "plane"}
            continue
        radius = float(values[12])
        across = np.linalg.norm(points - origin - np.outer(height, axis), axis=1)
        if np.abs(across - radius).max() <= _NEAR * max(size, radius):
            middle = origin + 0.5 * (height.min() + height.max()) * axis
            return {
                "kind": "cylinder",
                "radius": radius,
                "axis": axis.tolist(),
                "axis_point": middle.tolist(),
            }
    return {"kind": "other"}


def _surface_record(brep: str) -> tuple[str, Array] | None:
    """Return type and numbers of the face's surface; those of its neighbours come after it."""
    found = re.search(r"^Surfaces \d+\n(\d+) ([^\n]*)$", brep, flags=re.MULTILINE)
    if found is None or found[1] not in (_PLANE, _CYLINDER):
        return None
    return found[1], np.array(found[2].split(), dtype=float)


def _motions(brep: str) -> list[tuple[Array, Array]]:
    """Return rotation (3, 3) and shift (3,) of the elementary locations in the text."""
    found = re.search(r"^Locations (\d+)\n(.*?)^Curve2ds", brep, flags=re.MULTILINE | re.DOTALL)
    if found is None:
        return []
    motions = []
    lines = found[2].splitlines()
    for i, line in enumerate(lines):
        if line.strip() == "1" and i + 3 < len(lines):
            rows = np.array([lines[i + k].split() for k in (1, 2, 3)], dtype=float)
            motions.append((rows[:, :3], rows[:, 3]))
    return motions
