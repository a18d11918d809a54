"""Meshes of parts: made in the child process, tried with other settings where it fails, checked."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import CadError
from stiffkit.fea.arrays import MeshArrays, load_arrays
from stiffkit.fea.bisection import Mask, bisect
from stiffkit.fea.child import TIMEOUT, run_child, work_folder
from stiffkit.fea.geometry import MM, Part
from stiffkit.fea.meshcheck import MeshCheck, check_mesh
from stiffkit.fea.orders import Topology

COARSE = 6.0
"""Elements along the diagonal of the bounding box, in the coarsest mesh."""

FEATURE = 150.0
"""Features smaller than the diagonal divided by this do not refine the coarsest mesh."""


@dataclass(frozen=True, eq=False)
class MeshSettings:
    """What the mesher is asked for."""

    size: float
    """m, the largest element."""
    feature: float = 0.0
    """m: features (fillets, threads, engraved text) below this size do not refine the mesh."""
    grading: float = 0.7
    """0 to 1, how fast elements may grow."""
    curvature: float = 1.0
    """Elements along an arc as long as its radius."""
    per_edge: float = 0.3
    """Elements along an edge, at least; less than one lets short edges be."""
    close_edges: float | None = None
    """Elements between edges that run close to each other; not heeded if None."""

    def netgen(self) -> dict[str, Any]:
        """Return the settings in Netgen's words and millimetres."""
        return {
            "maxh": self.size / MM,
            "minh": self.feature / MM,
            "grading": self.grading,
            "curvaturesafety": self.curvature,
            "segmentsperedge": self.per_edge,
            "closeedgefac": self.close_edges,
        }

    def describe(self) -> str:
        """Return the settings in a line."""
        return (
            f"size {self.size / MM:.3g} mm, features from {self.feature / MM:.3g} mm, "
            f"grading {self.grading:g}"
        )


@dataclass(frozen=True, eq=False)
class PartMesh(MeshArrays):
    """A checked mesh of a part."""

    settings: MeshSettings
    check: MeshCheck
    seconds: float
    failures: tuple[str, ...] = ()
    """What went wrong with the settings that were tried before."""
    cuts: int = 0
    """How often elements have been cut since."""

    def describe(self) -> str:
        """Return how the mesh was made, in a line."""
        cuts = f", elements cut {self.cuts} times where the error is" if self.cuts else ""
        return self.settings.describe() + cuts

    @cached_property
    def curved(self) -> Any:
        """The mesh as NGSolve has it: faces are named f0, f1 ..., solids s0, s1 ..."""
        return self._to_ngsolve(curved=True)

    @cached_property
    def topology(self) -> Topology:
        """Edges and faces of the elements of `curved`."""
        return Topology(self.curved)

    @cached_property
    def straight(self) -> Any:
        """The mesh as NGSolve has it, with straight edges."""
        return self._to_ngsolve(curved=False)

    def _to_ngsolve(self, *, curved: bool) -> Any:
        from netgen.meshing import FaceDescriptor, Mesh
        from ngsolve import Mesh as Space

        n_faces, n_solids = int(self.triangle_face.max()) + 1, int(self.tet_solid.max()) + 1
        mesh = Mesh(dim=3)
        tets, triangles, points = self.tets, self.triangles, self.points
        if not curved:
            tets, triangles = tets[:, :4], triangles[:, :3]
            kept, new = np.unique(tets, return_inverse=True)
            points, tets = points[kept], new.reshape(tets.shape).astype(np.int32)
            triangles = np.searchsorted(kept, triangles).astype(np.int32)
        mesh.AddPoints(np.ascontiguousarray(points))
        for face in range(n_faces):
            mesh.Add(FaceDescriptor(surfnr=face + 1, domin=1, bc=face + 1))
        for solid in range(n_solids):
            own = np.ascontiguousarray(tets[self.tet_solid == solid])
            mesh.AddElements(dim=3, index=solid + 1, data=own, base=0)
            mesh.SetMaterial(solid + 1, f"s{solid}")
        for face in range(n_faces):
            own = np.ascontiguousarray(triangles[self.triangle_face == face])
            mesh.AddElements(dim=2, index=face + 1, data=own, base=0)
            mesh.SetBCName(face, f"f{face}")
        return Space(mesh)


def coarse_settings(part: Part) -> MeshSettings:
    """Return the settings that a part's first mesh is tried with."""
    return MeshSettings(
        size=part.diagonal / COARSE,
        feature=part.diagonal / FEATURE,
        grading=0.8,
    )


def mesh_part(
    part: Part,
    settings: MeshSettings,
    *,
    timeout: float = TIMEOUT,
    progress: Callable[[str], None] | None = None,
) -> PartMesh:
    """Mesh a part, trying other settings where those asked for fail, and check the mesh.

    ``timeout`` in s for each try. Raises `CadError` if no try gives a whole mesh.
    """
    start = time.perf_counter()
    failures: list[str] = []
    for attempt in _attempts(settings):
        try:
            arrays, straightened = _mesh_once(part, attempt, timeout)
            check = check_mesh(part, arrays, straightened)
        except CadError as error:
            failures.append(f"{attempt.describe()}: {error.what}")
            if progress is not None:
                progress(f"meshing failed ({error.what.splitlines()[0]}), trying other settings")
            continue
        seconds = time.perf_counter() - start
        return PartMesh(
            **vars(arrays),
            settings=attempt,
            check=check,
            seconds=seconds,
            failures=tuple(failures),
        )
    raise CadError(
        f"{part.name} could not be meshed; tried:\n"
        + "\n".join(f"    {failure}" for failure in failures),
        mend="remove tiny or damaged faces in the CAD system, or try another mesh size",
    )


def bisect_mesh(part: Part, mesh: PartMesh, chosen: Mask) -> tuple[PartMesh, NDArray[np.intp]]:
    """Return a mesh in which the ``chosen`` elements (e,) are cut, and the parents of its elements.

    Raises `CadError` if it is not whole.
    """
    start = time.perf_counter()
    arrays, parents = bisect(mesh, chosen)
    check = check_mesh(part, arrays, mesh.check.straightened)
    seconds = mesh.seconds + time.perf_counter() - start
    bisected = PartMesh(
        **vars(arrays),
        settings=mesh.settings,
        check=check,
        seconds=seconds,
        failures=mesh.failures,
        cuts=mesh.cuts + 1,
    )
    return bisected, parents


def _attempts(first: MeshSettings) -> Iterator[MeshSettings]:
    """Yield the settings asked for and, after them, ones that succeed more often and cost more."""
    yield first
    yield replace(first, feature=first.feature / 2.0, curvature=1.5 * first.curvature)
    yield replace(first, feature=0.0, size=0.8 * first.size, grading=0.5)
    yield replace(first, feature=0.0, size=0.8 * first.size, per_edge=1.0, close_edges=2.0)
    yield replace(
        first,
        feature=0.0,
        size=0.5 * first.size,
        grading=0.3,
        per_edge=1.0,
        curvature=2.0,
        close_edges=2.0,
    )


def _mesh_once(part: Part, settings: MeshSettings, timeout: float) -> tuple[MeshArrays, int]:
    """Return the arrays of a mesh, unchecked, and how many of its nodes were straightened."""
    with work_folder() as folder:
        (folder / "shape.brep").write_bytes(part.brep)
        job = {"settings": settings.netgen()}
        doing = f"meshing {part.name}"
        answer = run_child("mesh", folder, job, doing=doing, timeout=timeout)
        return load_arrays(folder / "mesh.npz"), int(answer["straightened"])
