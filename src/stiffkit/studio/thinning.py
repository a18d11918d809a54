"""Surfaces with fewer triangles, for drawing."""

from __future__ import annotations

import numpy as np

from stiffkit.studio.mesh import Indices, Mesh

MOST = 20_000
"""Triangles that one part is drawn with."""

_COARSER = 1.2
"""Size of the cells over that before, where there were too many triangles left."""


def thinned(mesh: Mesh, most: int = MOST) -> tuple[Mesh, Indices]:
    """Return a mesh with at most ``most`` triangles, and which vertices (V,) were kept.

    Of the vertices in each cell of a grid the one nearest to their mean is kept (J. Rossignac,
    P. Borrel, "Multi-resolution 3D approximations for rendering complex scenes", in Modeling in
    Computer Graphics, 1993). Triangles that are left with two corners, or with a twin, are dropped,
    so the surface may have gaps.
    """
    if len(mesh.faces) <= most:
        return mesh, np.arange(len(mesh.vertices))
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0
    # A surface passes at least one cell for each of their squares, with two triangles in each.
    cell = np.sqrt(2.0 * area / most)
    while True:
        found, kept = _clustered(mesh, cell)
        if len(found.faces) <= most:
            return found, kept
        cell *= _COARSER


def _clustered(mesh: Mesh, cell: float) -> tuple[Mesh, Indices]:
    """Return a mesh with one vertex in each cell (m), and which vertices these are."""
    places = np.floor((mesh.vertices - mesh.vertices.min(axis=0)) / cell).astype(np.int64)
    _, which, counts = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    means = np.stack([np.bincount(which, x) for x in mesh.vertices.T], axis=1) / counts[:, None]
    away = np.linalg.norm(mesh.vertices - means[which], axis=1)
    order = np.lexsort([away, which])
    kept = order[np.searchsorted(which[order], np.arange(counts.size))]
    faces = which[mesh.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Mesh(mesh.vertices[kept], faces[np.sort(first)].astype(np.intp)), kept.astype(np.intp)
