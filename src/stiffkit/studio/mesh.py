"""Triangle meshes of simple bodies, closed and with their faces' normals outwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiffkit.link import Outline
from stiffkit.spatial import Frame

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles; seen from outside, the corners of each run anticlockwise."""

    vertices: Array
    """(V, 3), m."""
    faces: Indices
    """(F, 3), indices of vertices."""

    @property
    def volume(self) -> float:
        """m^3, of a closed mesh; negative where its faces look inwards."""
        a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @property
    def is_closed(self) -> bool:
        """Whether each edge belongs to two faces, which run along it in opposite directions."""
        edges = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        forward, back = (np.sort(e @ [len(self.vertices), 1]) for e in (edges, edges[:, ::-1]))
        return bool(np.array_equal(forward, back) and np.all(np.diff(forward) > 0))

    def placed(self, frame: Frame) -> Mesh:
        """Return the mesh where ``frame`` puts it."""
        return Mesh(self.vertices @ frame.rotation.T + frame.position, self.faces)


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of several."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def sweep(outline: Outline, stations: Array) -> Mesh:
    """Return a bar along x with sections at ``stations`` (s,), m, ascending.

    The vertices are those of the outer edge, station by station, then those of the hole.
    """
    edge, hole = outline.edge(), outline.hole()
    n, last = len(edge), stations.size - 1
    walls = [_wall(n, stations.size)]
    vertices = [_rings(edge, stations)]
    around = np.arange(n)
    after = np.roll(around, -1)
    if len(hole):
        vertices.append(_rings(hole, stations))
        first = n * stations.size
        walls.append(first + _wall(n, stations.size)[:, ::-1])
        quads = np.stack([around, after, first + after, first + around], axis=1)
        end = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    else:
        end = np.stack([np.zeros(n - 2, dtype=np.intp), around[1:-1], around[2:]], axis=1)
    faces = [*walls, end[:, ::-1], end + n * last]
    return Mesh(np.concatenate(vertices), np.concatenate(faces).astype(np.intp))


def _rings(corners: Array, stations: Array) -> Array:
    """Return the vertices (s n, 3) of corners (n, 2) at each of the stations (s,)."""
    x = np.repeat(stations, len(corners))
    return np.column_stack([x, np.tile(corners, (stations.size, 1))])


def _wall(n: int, n_stations: int) -> Indices:
    """Return the faces between rings of ``n`` vertices, as seen from outside."""
    around = np.arange(n)
    after = np.roll(around, -1)
    quads = np.stack([around, after, n + after, n + around], axis=1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    steps = n * np.arange(n_stations - 1)
    return np.asarray((faces + steps[:, None, None]).reshape(-1, 3))


def frame_along(origin: ArrayLike, direction: ArrayLike) -> Frame:
    """Return a frame at a point (3,) whose x axis has a direction (3,), the others any."""
    x = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    y = np.cross(np.eye(3)[int(np.argmin(np.abs(x)))], x)
    y /= np.linalg.norm(y)
    return Frame(np.stack([x, y, np.cross(x, y)], axis=1), np.asarray(origin, dtype=float))


def bar(outline: Outline, length: float, frame: Frame) -> Mesh:
    """Return a straight bar whose middle is at the frame's origin, along its x axis."""
    return sweep(outline, np.array([-0.5, 0.5]) * length).placed(frame)


def cylinder(radius: float, length: float, frame: Frame) -> Mesh:
    """Return a cylinder around the x axis of a frame, with its middle at the origin."""
    return bar(Outline("ellipse", 2.0 * radius, 2.0 * radius), length, frame)


def block(sizes: ArrayLike, frame: Frame) -> Mesh:
    """Return a box with sizes (3,), m, along the axes of a frame, with its middle at the origin."""
    x, y, z = np.asarray(sizes, dtype=float).tolist()
    return bar(Outline("rectangle", y, z), x, frame)


@cache
def unit_ball(n_divisions: int) -> Mesh:
    """Return a ball of radius 1 m: an icosahedron whose faces are divided into four, n times."""
    g = (1.0 + np.sqrt(5.0)) / 2.0
    corners = [(s, t * g) for t in (1, -1) for s in (1, -1)]
    points = np.array([np.roll([0.0, a, b], shift) for shift in range(3) for a, b in corners])
    mesh = hull(points / np.linalg.norm(points[0]))
    for _ in range(n_divisions):
        mesh = _divided(mesh)
    return mesh


def _divided(mesh: Mesh) -> Mesh:
    """Return a ball with each face cut into four."""
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, which = np.unique(edges, axis=0, return_inverse=True)
    middles = mesh.vertices[unique].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    a, b, c = mesh.faces.T
    ab, bc, ca = (len(mesh.vertices) + which.reshape(-1, 3)).T
    corners = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    faces = np.concatenate([np.stack(three, axis=1) for three in corners])
    return Mesh(np.concatenate([mesh.vertices, middles]), faces.astype(np.intp))


def ball(radius: float, centre: ArrayLike) -> Mesh:
    """Return a ball of a radius (m) around a point (3,)."""
    unit = unit_ball(2)
    return Mesh(radius * unit.vertices + np.asarray(centre, dtype=float), unit.faces)


def hull(points: Array) -> Mesh:
    """Return the convex hull of points (P, 3) that do not lie in one plane."""
    # It takes long to import, and is needed only where something is drawn.
    from scipy.spatial import ConvexHull

    found = ConvexHull(points)
    faces = found.simplices.astype(np.intp)
    a, b, c = np.moveaxis(points[faces], 1, 0)
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    used, renumbered = np.unique(faces, return_inverse=True)
    return Mesh(points[used], renumbered.reshape(faces.shape).astype(np.intp))


def rounded_hull(points: Array, radii: ArrayLike, axes: Array | None = None) -> Mesh:
    """Return the convex hull of balls around points (P, 3), P > 0: a rod, a plate or a body.

    The balls are ellipsoids with ``radii`` (3,), m, along the columns of ``axes`` (3, 3).
    """
    turn = np.eye(3) if axes is None else axes
    around = (unit_ball(1).vertices * np.asarray(radii, dtype=float)) @ turn.T
    return hull((points[:, None] + around).reshape(-1, 3))
