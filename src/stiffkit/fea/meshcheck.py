"""Is a mesh whole? Netgen can return one after giving up on a face, of plausible volume."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from stiffkit.errors import CadError
from stiffkit.fea.arrays import MeshArrays
from stiffkit.fea.geometry import Part
from stiffkit.fea.tets import Indices, jacobian_bounds
from stiffkit.spatial.rotation import Array

VOLUME_ERROR = 0.02
"""The relative error of a solid's volume that a mesh may have."""

AREA_ERROR = 0.05
"""The relative error of the surface that a mesh may have."""

_FACE_ERROR = 0.5
"""The relative error that a face may have unless it is tiny."""

_TINY = 1e-3
"""A face is tiny below this share of the part's surface."""

_A, _B = (6.0 - 15.0**0.5) / 21.0, (6.0 + 15.0**0.5) / 21.0
_TRIANGLE_RULE = (
    np.array([[1 / 3] * 3, *(np.roll([1 - 2 * s, s, s], k) for s in (_A, _B) for k in range(3))]),
    np.array([0.225] + [(155 - 15**0.5) / 1200] * 3 + [(155 + 15**0.5) / 1200] * 3),
)
"""Barycentric coordinates (7, 3) and weights (7,), exact for order 5. A. H. Stroud, "Approximate
calculation of multiple integrals", 1971, T2: 5-1."""

_SIDES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


@dataclass(frozen=True)
class MeshCheck:
    """What was measured on a mesh that is whole."""

    n_tets: int
    volume_error: float
    """Of the mesh against the CAD kernel's volume, relative, signed."""
    area_error: float
    """Of the mesh against the CAD kernel's surface, relative, signed."""
    flattest: float
    """The least ratio of smallest to mean Jacobian of the elements."""
    straightened: int
    """How many nodes were put back to the middle of their edge."""


def check_mesh(part: Part, arrays: MeshArrays, straightened: int = 0) -> MeshCheck:
    """Check a mesh against its part.

    Raises `CadError` if the boundary is not closed, faces are missing, elements are turned over,
    or volumes or areas are off.
    """
    tets, triangles = arrays.tets, arrays.triangles
    if len(tets) == 0 or len(triangles) == 0:
        raise CadError("the mesh is empty")
    _check_closed(tets, triangles)
    _check_connected(tets)
    lower, mean = jacobian_bounds(arrays.points, tets)
    flattest = float((lower / np.where(mean > 0.0, mean, np.inf)).min())
    if np.any(mean <= 0.0) or flattest <= 0.0:
        turned = int(np.sum((lower <= 0.0) | (mean <= 0.0)))
        raise CadError(f"the mesh has {turned} elements that are turned over")
    volume_error = _check_volumes(part, mean / 6.0, arrays.tet_solid)
    area_error = _check_areas(part, arrays)
    return MeshCheck(len(tets), volume_error, area_error, flattest, straightened)


def _check_closed(tets: Indices, triangles: Indices) -> None:
    """Check that each side of an element is shared by two, or is the surface's."""
    sides = np.sort(tets[:, _SIDES].reshape(-1, 3), axis=1)
    keys, counts = np.unique(_keys(sides, int(tets.max())), return_counts=True)
    if counts.max() > 2:
        raise CadError(f"the mesh crosses itself: {int(np.sum(counts > 2))} sides have 3 elements")
    surface = np.unique(_keys(np.sort(triangles[:, :3], axis=1), int(tets.max())))
    if len(surface) != len(triangles):
        raise CadError("the mesh has surface elements that lie on each other")
    open_sides = int(np.sum(~np.isin(keys[counts == 1], surface)))
    if open_sides:
        raise CadError(f"the mesh is not closed: {open_sides} outer sides belong to no face")
    loose = int(np.sum(~np.isin(surface, keys)))
    if loose:
        raise CadError(f"the mesh is not closed: {loose} surface elements have no element behind")


def _keys(corners: Indices, largest: int) -> NDArray[np.int64]:
    """Return one integer (n,) for each row of sorted indices (n, 3)."""
    base = np.int64(largest) + 1
    if base > 2_000_000:
        raise CadError("the mesh has more points than can be handled", mend="ask for a larger size")
    return np.asarray((corners[:, 0] * base + corners[:, 1]) * base + corners[:, 2])


def _check_connected(tets: Indices) -> None:
    corners = tets[:, :4]
    n = int(corners.max()) + 1
    rows, columns = np.repeat(corners[:, 0], 3), corners[:, 1:].ravel()
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(n, n))
    labels = connected_components(graph, directed=False)[1]
    pieces = len(np.unique(labels[corners]))
    if pieces > 1:
        raise CadError(f"the mesh falls into {pieces} pieces")


def _check_volumes(part: Part, volumes: Array, solid: Indices) -> float:
    """Check each solid's volume and return the error of the whole."""
    if int(solid.max()) >= len(part.solids):
        raise CadError("the mesh has more solids than the part")
    for i, facts in enumerate(part.solids):
        error = float(volumes[solid == i].sum() / facts.volume - 1.0)
        if abs(error) > VOLUME_ERROR:
            raise CadError(f"the mesh's volume of {facts.name} is {100 * error:+.2g} % off")
    return float(volumes.sum() / part.volume - 1.0)


def _check_areas(part: Part, arrays: MeshArrays) -> float:
    """Check that no face is missing or badly met, and return the error of the whole surface."""
    areas = triangle_areas(arrays.points, arrays.triangles)
    face = arrays.triangle_face
    if int(face.max()) >= len(part.faces):
        raise CadError("the mesh has more faces than the part")
    meshed = np.bincount(face, areas, minlength=len(part.faces))
    wanted = np.array([f.area for f in part.faces])
    bad = (np.abs(meshed / wanted - 1.0) > _FACE_ERROR) & (wanted > _TINY * part.area)
    missing = np.bincount(face, minlength=len(part.faces)) == 0
    for i in np.flatnonzero(bad | missing):
        raise CadError(f"the mesher did not mesh {part.faces[i].describe()}")
    error = float(meshed.sum() / part.area - 1.0)
    if abs(error) > AREA_ERROR:
        raise CadError(f"the mesh's surface is {100 * error:+.2g} % off")
    return error


def triangle_areas(points: Array, triangles: Indices) -> Array:
    """Return the areas (t,) of six-node triangles."""
    p = points[triangles]
    out = np.zeros(len(triangles))
    for barycentric, weight in zip(*_TRIANGLE_RULE, strict=True):
        a, b, c = barycentric
        # Derivatives of the shape functions along the first two coordinates.
        first = np.array([4 * a - 1, 0, 1 - 4 * c, -4 * b, 4 * (c - a), 4 * b])
        second = np.array([0, 4 * b - 1, 1 - 4 * c, 4 * (c - b), -4 * a, 4 * a])
        normal = np.cross(np.tensordot(p, first, (1, 0)), np.tensordot(p, second, (1, 0)))
        out += 0.5 * weight * np.linalg.norm(normal, axis=1)
    return out
