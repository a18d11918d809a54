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

SIZES = "sizes.npz"
MESH = "mesh.npz"
_MM = 1e-3


def mesh_shape(folder: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Mesh the shape in ``folder`` and write the arrays; ``job`` holds Netgen's settings.

    If there are wanted sizes (``points`` (n, 3) and ``sizes`` (n,), m), they are heeded on top.
    """
    from netgen.occ import OCCGeometry

    geometry = OCCGeometry(str(folder / SHAPE))
    settings = dict(job["settings"])
    if (folder / SIZES).exists():
        settings["meshsizefilename"] = str(_write_sizes(folder))
    mesh = geometry.GenerateMesh(**settings)
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


def _write_sizes(folder: Path) -> Path:
    """Write the wanted sizes in Netgen's format, in the kernel's unit."""
    with np.load(folder / SIZES, allow_pickle=False) as wanted:
        rows = np.column_stack([wanted["points"], wanted["sizes"]]) / _MM
    path = folder / "sizes.msz"
    lines = [f"{len(rows)}", *(" ".join(f"{x:.9g}" for x in row) for row in rows), "0"]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path
