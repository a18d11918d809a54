"""Smaller elements where they are wanted, by bisection; the shape of the mesh stays as it is.

Elements are quadratic images of straight ones, and so is each half of one: the functions on a
refined mesh contain those on the mesh before, and a compliance can only come nearer to the exact
one from below.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiffkit.fea.arrays import MeshArrays
from stiffkit.fea.tets import TET_EDGES, TRIANGLE_EDGES, Indices
from stiffkit.spatial.rotation import Array

Mask = NDArray[np.bool_]
Edges = tuple[tuple[int, int], ...]

_MUCH_SHORTER = 0.6
"""Over the longest edge of the element."""


class Refined(NamedTuple):
    """A refined mesh."""

    mesh: MeshArrays
    parents: NDArray[np.intp]
    """(e,), the elements of the mesh before that the elements are parts of."""


def bisect(mesh: MeshArrays, chosen: Mask) -> Refined:
    """Return a mesh in which the longest edges of the ``chosen`` elements (e,) are cut in half.

    Where an edge is cut that is much shorter than the longest edge of an element at it, that one is
    cut too, so that elements do not become ever flatter (M.-C. Rivara, "Algorithms for refining
    triangular grids suitable for adaptive and multigrid techniques", Int. J. Numer. Meth. Eng. 20,
    1984, who does so always). An element is cut at its longest edge first, and two elements at a
    face therefore in the same way.
    """
    lengths = _edge_lengths(mesh)
    cut = _cut_edges(mesh.tets[:, 4:], chosen, lengths)
    rank = np.empty(len(lengths), dtype=np.intp)
    rank[np.argsort(lengths, kind="stable")] = np.arange(len(lengths))
    nodes = _Nodes(mesh.points)
    tets, parents = _split(mesh.tets, TET_EDGES, rank, cut, nodes)
    triangles, behind = _split(mesh.triangles, TRIANGLE_EDGES, rank, cut, nodes)
    solids, faces = mesh.tet_solid[parents], mesh.triangle_face[behind]
    # Solid by solid, as meshes are numbered.
    order = np.argsort(solids, kind="stable")
    points, tets, triangles = _corners_first(nodes.points, tets[order], triangles)
    return Refined(MeshArrays(points, tets, solids[order], triangles, faces), parents[order])


def _corners_first(
    points: Array, tets: Indices, triangles: Indices
) -> tuple[Array, Indices, Indices]:
    """Number points as meshes do: what follows the last corner is the middle of an edge."""
    is_corner = np.zeros(len(points), dtype=np.bool_)
    is_corner[tets[:, :4]] = True
    order = np.argsort(~is_corner, kind="stable")
    number = np.empty(len(points), dtype=np.int32)
    number[order] = np.arange(len(points))
    return points[order], number[tets], number[triangles]


def _edge_lengths(mesh: MeshArrays) -> Array:
    """Return the lengths (n,), m, of the straightened edges, by their middle nodes."""
    lengths = np.zeros(len(mesh.points))
    for k, (i, j) in enumerate(TET_EDGES):
        ends = mesh.points[mesh.tets[:, [i, j]]]
        lengths[mesh.tets[:, 4 + k]] = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    return lengths


def _cut_edges(middles: Indices, chosen: Mask, lengths: Array) -> Mask:
    """Return which edges (n,), by their middle nodes, are cut when ``chosen`` elements (e,) are.

    ``middles`` (e, 6) of the elements' edges.
    """
    cut = np.zeros(len(lengths), dtype=np.bool_)
    longest = middles[np.arange(len(middles)), np.argmax(lengths[middles], axis=1)]
    much_shorter = lengths[middles] < _MUCH_SHORTER * lengths[longest][:, None]
    wanted = longest[chosen]
    while not cut[wanted].all():
        cut[wanted] = True
        wanted = longest[np.any(cut[middles] & much_shorter, axis=1)]
    return cut


class _Nodes:
    """Points, and the middle nodes of edges that are made once and then found again."""

    def __init__(self, points: Array) -> None:
        self.points = points
        self._keys: NDArray[np.int64] = np.empty(0, dtype=np.int64)
        self._numbers: NDArray[np.int64] = np.empty(0, dtype=np.int64)

    def middles(self, one: Indices, other: Indices, positions: Array) -> Indices:
        """Return the middle nodes (e,) of edges from one corner to another, at ``positions``."""
        keys = (np.minimum(one, other).astype(np.int64) << 32) + np.maximum(one, other)
        unique, first, back = np.unique(keys, return_index=True, return_inverse=True)
        known = np.isin(unique, self._keys)
        new = np.arange(np.count_nonzero(~known)) + len(self.points)
        self.points = np.concatenate([self.points, positions[first[~known]]])
        keys, numbers = np.append(self._keys, unique[~known]), np.append(self._numbers, new)
        order = np.argsort(keys)
        self._keys, self._numbers = keys[order], numbers[order]
        return self._numbers[np.searchsorted(self._keys, unique)][back].astype(np.int32)


def _split(
    elements: Indices, edges: Edges, rank: NDArray[np.intp], cut: Mask, nodes: _Nodes
) -> tuple[Indices, NDArray[np.intp]]:
    """Return the parts of elements that are cut at all edges to be cut, the longest first.

    And which element each is a part of. ``elements``: corners, and the middles of ``edges``.
    """
    n = elements.shape[1] - len(edges)
    parents = np.arange(len(elements))
    ranked = np.where(cut, rank, -1)
    while True:
        # Edges that cutting makes are not cut again.
        ranked = np.append(ranked, np.full(len(nodes.points) - len(ranked), -1))
        at = np.argmax(ranked[elements[:, n:]], axis=1)
        split = ranked[elements[np.arange(len(elements)), n + at]] >= 0
        if not split.any():
            return elements, parents
        parts, origins = [elements[~split]], [parents[~split]]
        for k, edge in enumerate(edges):
            own = split & (at == k)
            for keep, lost in (edge, edge[::-1]):
                parts.append(_half(elements[own], edges, keep, lost, nodes))
                origins.append(parents[own])
        elements, parents = np.concatenate(parts), np.concatenate(origins)


def _half(elements: Indices, edges: Edges, keep: int, lost: int, nodes: _Nodes) -> Indices:
    """Return the halves of elements at the corner ``keep`` of their edge from it to ``lost``."""
    n = elements.shape[1] - len(edges)
    middle_of = {corners: n + k for k, edge in enumerate(edges) for corners in (edge, edge[::-1])}
    middle = elements[:, middle_of[keep, lost]]
    a, b, m = (nodes.points[i] for i in (elements[:, keep], elements[:, lost], middle))
    out = elements.copy()
    out[:, lost] = middle
    out[:, middle_of[keep, lost]] = nodes.middles(
        elements[:, keep], middle, 0.375 * a + 0.75 * m - 0.125 * b
    )
    for corner in range(n):
        if corner in (keep, lost):
            continue
        near, far = middle_of[keep, corner], middle_of[lost, corner]
        ends = nodes.points[elements[:, near]] + nodes.points[elements[:, far]]
        # The quadratic image of the point between the corner and the middle of the edge.
        position = 0.5 * ends + 0.25 * m - 0.125 * (a + b)
        out[:, far] = nodes.middles(elements[:, corner], middle, position)
    return out
