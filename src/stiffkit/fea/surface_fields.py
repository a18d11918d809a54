"""The surface of a solved part and how loads move it, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.superelement import PortModel
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Surface:
    """Corners of the mesh's surface triangles and their displacements, link axes."""

    points: Array
    """(n, 3), m."""
    triangles: NDArray[np.int64]
    """(t, 3), indices of points."""
    displacements: Array
    """(n, 3, 6(m-1)), m, under a unit force or moment along each axis at each of m ports but the
    base, in order, with the base held."""


def surface_of(model: PortModel, mesh: PartMesh, order: int, T_part_link: Frame) -> Surface:
    """Return the surface of a part whose first port is held."""
    from ngsolve import BND

    space = mesh.curved if order > 1 else mesh.straight
    points = np.array([vertex.point for vertex in space.vertices])
    corners = np.array([[v.nr for v in e.vertices] for e in space.Elements(BND)])
    R = T_part_link.rotation
    twists = model.compliance @ np.kron(np.eye(len(model.compliance) // 3), R)
    # Coefficients of the hierarchical polynomials at vertices are values.
    fields = model.solver.static_fields()[: len(points), :, 6:] @ twists
    used, triangles = np.unique(corners, return_inverse=True)
    return Surface(
        points=(points[used] - T_part_link.position) @ R,
        triangles=triangles.reshape(corners.shape).astype(np.int64),
        displacements=np.einsum("ij,nik->njk", R, fields[used]),
    )
