"""Meshing with Netgen; runs in the child process only.

The mesh that leaves is plain arrays: points, ten-node tetrahedra, six-node triangles, metres.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.arrays import MeshArrays
from stiffkit.fea.kernel import SHAPE
from stiffkit.fea.tets import straighten

MESH = "mesh.npz"
_MM = 1e-3


def mesh_shape(folder: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Mesh the shape in ``folder`` and write the arrays; ``job`` holds Netgen's settings."""
    from netgen.occ import OCCGeometry

    geometry = OCCGeometry(str(folder / SHAPE))
    mesh = geometry.GenerateMesh(**job["settings"])
    if mesh.ne == 0:
        raise CadError("the mesher made no elements")
    n_corners = len(mesh.Points())
    mesh.SecondOrder()
    arrays = _arrays(mesh)
    straightened = straighten(arrays.points, arrays.tets, n_corners)
    arrays.save(folder / MESH)
    return {"straightened": straightened}


def _arrays(mesh: Any) -> MeshArrays:
    volume, surface = mesh.Elements3D().NumPy(), mesh.Elements2D().NumPy()
    # Solid by solid, as they are numbered when the mesh is built again.
    volume = volume[np.argsort(volume["index"], kind="stable")]
    return MeshArrays(
        points=_MM * np.asarray(mesh.Coordinates(), dtype=float),
        tets=volume["nodes"][:, :10].astype(np.int32) - 1,
        tet_solid=volume["index"].astype(np.int32) - 1,
        triangles=surface["nodes"][:, :6].astype(np.int32) - 1,
        triangle_face=surface["index"].astype(np.int32) - 1,
    )
