"""Parts from CAD: STEP in, facts about the solid and its faces out, in metres."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import CadError, FileError
from stiffkit.fea.child import run_child, work_folder
from stiffkit.spatial.rotation import Array

MM = 1e-3
"""m, the kernel's unit of length."""

_PLAUSIBLE = (2e-3, 20.0)
"""m: a part whose diagonal is outside has probably been read in the wrong unit."""


@dataclass(frozen=True, eq=False)
class Face:
    """One face of a part."""

    index: int
    area: float
    """m^2."""
    centre: Array
    """(3,), m, centroid of the area."""
    normal: Array
    """(3,), mean outward normal, unit; zero where the normals cancel, as round a hole."""
    kind: str
    """plane, cylinder or other."""
    low: Array
    """(3,), m, corner of the bounding box."""
    high: Array
    """(3,), m, the opposite corner."""
    name: str = ""
    colour: tuple[float, float, float] | None = None
    """Red, green, blue from 0 to 1."""
    radius: float | None = None
    """m, of a cylinder."""
    axis: Array | None = None
    """(3,), unit direction of a cylinder's axis."""
    axis_point: Array | None = None
    """(3,), m, point of a cylinder's axis half-way along the face."""

    def describe(self) -> str:
        """Return the face in a line."""
        x, y, z = self.centre / MM
        name = f' "{self.name}"' if self.name else ""
        shape = "" if self.radius is None else f" of radius {self.radius / MM:.4g} mm"
        area = f"{self.area / MM**2:.4g} mm2"
        return f"face {self.index}{name}: {self.kind}{shape}, {area} at ({x:.4g}, {y:.4g}, {z:.4g})"


@dataclass(frozen=True, eq=False)
class Solid:
    """One solid of a part, of unit density."""

    name: str
    volume: float
    """m^3."""
    centre: Array
    """(3,), m."""
    inertia: Array
    """(3, 3), m^5, about the centre, for unit density."""


@dataclass(frozen=True, eq=False)
class Part:
    """A connected body of one or more solids, as the CAD kernel knows it."""

    name: str
    brep: bytes = field(repr=False)
    """The shape in the kernel's own form, mm."""
    faces: tuple[Face, ...]
    solids: tuple[Solid, ...]
    low: Array
    """(3,), m, corner of the bounding box."""
    high: Array
    """(3,), m, the opposite corner."""
    triangles: Array = field(repr=False)
    """(t, 3, 3), m, a triangulation of the surface, for pictures and distances."""
    triangle_face: NDArray[np.intp] = field(repr=False)
    """(t,), the face of each triangle."""
    shortest_edges: Array = field(repr=False)
    """(e,), m, lengths of all edges, shortest first."""
    unit: str
    """The file's length unit, in words."""
    digest: str
    """SHA-256 of the file that the part came from."""

    @property
    def diagonal(self) -> float:
        """Diagonal of the bounding box, m."""
        return float(np.linalg.norm(self.high - self.low))

    @property
    def volume(self) -> float:
        """Volume, m^3."""
        return math.fsum(solid.volume for solid in self.solids)

    @property
    def area(self) -> float:
        """Area of all faces, m^2; faces between two solids count once."""
        return math.fsum(face.area for face in self.faces)

    def mass_properties(self, density: float | tuple[float, ...]) -> tuple[float, Array, Array]:
        """Return mass (kg), centre of mass (3,) and inertia (3, 3) about it, kg m^2.

        ``density`` in kg/m^3, one or one for each solid.
        """
        densities = np.broadcast_to(np.asarray(density, dtype=float), (len(self.solids),))
        masses = densities * [solid.volume for solid in self.solids]
        centres = np.array([solid.centre for solid in self.solids])
        mass = float(masses.sum())
        centre = masses @ centres / mass
        inertia = np.zeros((3, 3))
        for rho, m, solid in zip(densities, masses, self.solids, strict=True):
            d = solid.centre - centre
            inertia += rho * solid.inertia + m * (d @ d * np.eye(3) - np.outer(d, d))
        return mass, np.asarray(centre), inertia


def read_step(path: Path | str, *, scale: float | None = None) -> Part:
    """Read a STEP (or BREP, in millimetres) file of one part.

    The file's own unit is heeded; ``scale`` multiplies all lengths on top of it, for files that
    state a wrong one. A part of implausible size is an error as long as no scale is given. Raises
    `FileError` if there is no such file and `CadError` if it holds no single solid body.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FileError(f"cannot be read: {error.strerror}", path=path) from error
    job = {"source": str(path.resolve()), "scale": 1.0 if scale is None else scale}
    unit = _unit(data) if path.suffix.lower() in (".step", ".stp") else "millimetre"
    part = _part("read", job, path.name, path.stem, unit, hashlib.sha256(data).hexdigest())
    if scale is None:
        _check_size(part)
    return part


def build_part(
    script: Path | str,
    function: str,
    arguments: Mapping[str, Any] | None = None,
    *,
    unit: float = MM,
) -> Part:
    """Return the part that a Python function makes with `netgen.occ`, run in a child process.

    ``script`` is the file with the ``function``, which is called with ``arguments`` (anything that
    JSON can say) and returns a shape; ``unit`` is its unit of length in m. Raises `FileError` if
    there is no such file and `CadError` if the function fails, crashes the kernel, or makes no
    single solid body.
    """
    path = Path(script)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FileError(f"cannot be read: {error.strerror}", path=path) from error
    given = dict(arguments or {})
    data += json.dumps([function, given, unit], sort_keys=True).encode()
    job = {
        "script": str(path.resolve()),
        "function": function,
        "arguments": given,
        "scale": unit / MM,
    }
    digest = hashlib.sha256(data).hexdigest()
    return _part("build", job, f"{path.name}: {function}", function, f"{unit:g} m", digest)


def build_registered(name: str, dimensions: Mapping[str, float], digest: str) -> Part:
    """Return a parametric part of this package, built in a child process.

    ``dimensions`` are all of the part's, SI; ``digest`` is the hash of what the shape depends on.
    Raises `CadError` if it cannot be built.
    """
    job = {"part": name, "dimensions": dict(dimensions)}
    return _part("parametric", job, name, name, "none, built from dimensions", digest)


def _part(task: str, job: dict[str, Any], what: str, name: str, unit: str, digest: str) -> Part:
    """Let the child read or build a part and return it in metres."""
    with work_folder() as folder:
        facts = run_child(task, folder, job, doing=f"{what}: reading the part")
        with np.load(folder / "triangles.npz", allow_pickle=False) as arrays:
            triangles, owner = MM * arrays["triangles"], arrays["face"]
        brep = (folder / "shape.brep").read_bytes()
    return Part(
        name=name,
        brep=brep,
        faces=tuple(_face(i, face) for i, face in enumerate(facts["faces"])),
        solids=tuple(_solid(i, solid) for i, solid in enumerate(facts["solids"])),
        low=MM * np.array(facts["low"]),
        high=MM * np.array(facts["high"]),
        triangles=triangles,
        triangle_face=owner,
        shortest_edges=MM * np.array(facts["edges"]),
        unit=unit,
        digest=digest,
    )


def _face(index: int, facts: dict[str, Any]) -> Face:
    colour, axis, point = facts["colour"], facts.get("axis"), facts.get("axis_point")
    radius = facts.get("radius")
    return Face(
        index=index,
        area=facts["area"] * MM**2,
        centre=MM * np.array(facts["centre"]),
        normal=np.array(facts["normal"]),
        kind=facts["kind"],
        low=MM * np.array(facts["low"]),
        high=MM * np.array(facts["high"]),
        name=facts["name"],
        colour=None if colour is None else (colour[0], colour[1], colour[2]),
        radius=None if radius is None else MM * radius,
        axis=None if axis is None else np.array(axis),
        axis_point=None if point is None else MM * np.array(point),
    )


def _solid(index: int, facts: dict[str, Any]) -> Solid:
    return Solid(
        name=facts["name"] or f"solid{index + 1}",
        volume=facts["volume"] * MM**3,
        centre=MM * np.array(facts["centre"]),
        inertia=MM**5 * np.array(facts["inertia"]),
    )


def _unit(step: bytes) -> str:
    """Return the length unit that a STEP file states, in words."""
    text = step.decode("latin-1")
    other = re.search(r"CONVERSION_BASED_UNIT\s*\(\s*'(INCH|FOOT|YARD)'", text, re.IGNORECASE)
    if other is not None:
        return other[1].lower()
    metre = re.search(r"SI_UNIT\s*\(\s*(\$|\.[A-Z]+\.)\s*,\s*\.METRE\.\s*\)", text)
    if metre is None:
        return "none stated, taken as millimetre"
    return f"{metre[1].strip('.$').lower()}metre"


def _check_size(part: Part) -> None:
    """Raise `CadError` if the part is of a size that points to a wrong unit."""
    low, high = _PLAUSIBLE
    if low <= part.diagonal <= high:
        return
    x, y, z = (part.high - part.low) / MM
    raise CadError(
        f"{part.name} measures {x:.4g} x {y:.4g} x {z:.4g} mm; the file's unit is {part.unit}",
        mend="if the size is right, say so by scale = 1; if the file states a wrong unit, give the "
        "factor (1000 if metres were written as millimetres)",
    )
