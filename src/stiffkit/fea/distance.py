"""Distances of a point from triangles."""

from __future__ import annotations

import numpy as np

from stiffkit.spatial.rotation import Array


def distances_to_triangles(point: Array, triangles: Array) -> Array:
    """Return the distances (t,) of a point (3,) from triangles (t, 3, 3).

    The nearest point is inside a triangle if its foot is; otherwise it is on one of the sides.
    """
    corner, u, v = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    u, v, w = u - corner, v - corner, point - corner
    uu, uv, vv = _dot(u, u), _dot(u, v), _dot(v, v)
    wu, wv = _dot(w, u), _dot(w, v)
    twice = uu * vv - uv * uv
    safe = np.where(twice > 0.0, twice, 1.0)
    s, t = (vv * wu - uv * wv) / safe, (uu * wv - uv * wu) / safe
    inside = (twice > 0.0) & (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
    foot = corner + s[:, None] * u + t[:, None] * v
    distances = np.where(inside, np.linalg.norm(point - foot, axis=1), np.inf)
    for i in range(3):
        side = _to_segments(point, triangles[:, i], triangles[:, (i + 1) % 3])
        distances = np.minimum(distances, side)
    return distances


def _to_segments(point: Array, start: Array, end: Array) -> Array:
    along = end - start
    square = _dot(along, along)
    share = np.clip(_dot(point - start, along) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    return np.asarray(np.linalg.norm(point - start - share[:, None] * along, axis=1))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ti,ti->t", a, b))
