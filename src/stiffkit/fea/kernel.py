"""What the CAD kernel knows of a part; runs in the child process only.

Lengths are millimetres here, the kernel's own unit whatever the file's; the parent converts.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.parts import find_part
from stiffkit.fea.surfaces import surface_kind
from stiffkit.spatial.rotation import Array

SHAPE = "shape.brep"
TRIANGLES = "triangles.npz"
STEP = "part.step"


def read_part(folder: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Read the STEP or BREP file ``job["source"]``, write the shape, and return its facts."""
    from netgen.occ import OCCGeometry

    return describe(OCCGeometry(job["source"]).shape, folder, job["scale"])


def build_part(folder: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Call a Python function that makes a shape, write the shape, and return its facts.

    ``job``: ``script`` (path of a Python file), ``function`` in it, ``arguments`` (mapping), and
    ``scale`` from the function's length unit to millimetres.
    """
    path = Path(job["script"])
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise CadError(f"{path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    function = getattr(module, job["function"], None)
    if function is None:
        raise CadError(f"{path.name} has no function {job['function']}")
    return describe(function(**job["arguments"]), folder, job["scale"])


def build_registered(folder: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Build a parametric part of this package, write the shape, and return its facts.

    ``job``: ``part`` (its name) and ``dimensions`` (all of them, SI).
    """
    return describe(find_part(job["part"]).build(job["dimensions"]), folder, 1.0)


def export_registered(folder: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Build a parametric part of this package, as `build_registered`, and write it as STEP."""
    find_part(job["part"]).build(job["dimensions"]).WriteStep(str(folder / STEP))
    return {}


def describe(shape: Any, folder: Path, scale: float) -> dict[str, Any]:
    """Check a shape, write it in millimetres and return its facts.

    ``scale`` multiplies all lengths. Raises `CadError` if it is not one connected body.
    """
    from netgen.occ import OCCGeometry, Pnt

    if scale != 1.0:
        shape = shape.Scale(Pnt(0, 0, 0), scale)
    body = _one_body(shape)
    names = [(_name(face), _colour(face)) for face in _faces(body)]
    solid_names = [str(solid.name or "") for solid in body.solids]
    body.WriteBrep(str(folder / SHAPE), withTriangles=False)
    # What is meshed later is what was written, in the order in which it is read again.
    geometry = OCCGeometry(str(folder / SHAPE))
    body = geometry.shape
    triangles, normals, owner = _triangles(geometry)
    np.savez(folder / TRIANGLES, triangles=triangles, face=owner)
    faces = []
    for i, (face, (name, colour)) in enumerate(zip(_faces(body), names, strict=True)):
        own = owner == i
        facts = _face_facts(face, triangles[own], folder)
        facts["normal"] = _mean_normal(triangles[own], normals[own])
        faces.append({"name": name, "colour": colour, **facts})
    low, high = (_xyz(corner) for corner in body.bounding_box)
    return {
        "low": low,
        "high": high,
        "faces": faces,
        "solids": [_solid_facts(*pair) for pair in zip(body.solids, solid_names, strict=True)],
        "edges": sorted(float(edge.mass) for edge in body.edges),
    }


def _faces(body: Any) -> list[Any]:
    """Return the faces in the mesher's order; one between two solids counts once."""
    unique: list[Any] = []
    seen: set[Any] = set()
    for face in body.faces:
        if face not in seen:
            seen.add(face)
            unique.append(face)
    return unique


def _triangles(geometry: Any) -> tuple[Array, Array, Array]:
    """Return triangles (t, 3, 3), their normals (t, 3) and the index (t,) of their face."""
    data = geometry._visualizationData()
    triangles = np.asarray(data["vertices"], dtype=float).reshape(-1, 3, 3)
    normals = np.asarray(data["normals"], dtype=float).reshape(-1, 3, 3).mean(axis=1)
    return triangles, normals, np.asarray(data["indices"], dtype=int)


def _mean_normal(triangles: Array, normals: Array) -> list[float]:
    """Return the unit mean (3,) of the outward normals, zero where they cancel (a cylinder)."""
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2.0
    areas = np.linalg.norm(sides, axis=1)
    mean = areas @ normals
    size = float(np.linalg.norm(mean))
    if size <= 1e-3 * areas.sum():
        return [0.0, 0.0, 0.0]
    return _xyz(mean / size)


def _one_body(shape: Any) -> Any:
    """Return the shape as one connected body of one or more solids, or raise `CadError`."""
    from netgen.occ import Glue

    solids = list(shape.solids)
    if not solids:
        raise CadError(*_no_solid(shape))
    if any(float(solid.mass) <= 0.0 for solid in solids):
        raise CadError(
            "a solid has no positive volume: its faces point inwards or cross each other",
            mend="repair the solid in the CAD system and export it again",
        )
    if len(solids) == 1:
        return solids[0]
    body = Glue(solids)
    pieces = _pieces(list(body.solids))
    if pieces > 1:
        raise CadError(
            f"the file holds {len(solids)} solids that form {pieces} disconnected bodies",
            mend="export one part, or join the bodies; an assembly is a robot, not a link",
        )
    return body


def _no_solid(shape: Any) -> tuple[str]:
    if len(list(shape.faces)) == 0:
        return ("the file holds no solid and no face",)
    return (
        "the file holds no solid, only an open shell of "
        f"{len(list(shape.faces))} faces; close it in the CAD system and export a solid",
    )


def _pieces(solids: list[Any]) -> int:
    """Return how many groups of solids hang together by common faces."""
    group = list(range(len(solids)))
    faces = [list(solid.faces) for solid in solids]
    for i in range(len(solids)):
        for j in range(i):
            if any(a == b for a in faces[i] for b in faces[j]):
                group = [group[j] if g == group[i] else g for g in group]
    return len(set(group))


def _face_facts(face: Any, triangles: Array, folder: Path) -> dict[str, Any]:
    path = folder / "face.brep"
    face.WriteBrep(str(path), withTriangles=False)
    low, high = (_xyz(corner) for corner in face.bounding_box)
    return {
        "area": float(face.mass),
        "centre": _xyz(face.center),
        "low": low,
        "high": high,
        **surface_kind(path.read_text(encoding="ascii"), triangles.reshape(-1, 3)),
    }


def _name(face: Any) -> str:
    # CAD systems write NONE or nothing for faces that nobody named.
    name = str(face.name or "")
    return "" if name.upper() in ("NONE", "DEFAULT") else name


def _colour(face: Any) -> list[float] | None:
    return None if face.col is None else [float(c) for c in list(face.col)[:3]]


def _solid_facts(solid: Any, name: str) -> dict[str, Any]:
    inertia = solid.inertia
    return {
        "name": name,
        "volume": float(solid.mass),
        "centre": _xyz(solid.center),
        "inertia": [[float(inertia[i, j]) for j in range(3)] for i in range(3)],
    }


def _xyz(point: Any) -> list[float]:
    return [float(point[0]), float(point[1]), float(point[2])]
