"""Section 4 of Pashkevich 2009: a cantilever by finite elements, read as the paper reads it.

A. Pashkevich, A. Klimchik, D. Chablat, P. Wenger, "Accuracy improvement for stiffness modeling of
parallel manipulators", Proc. 42nd CIRP Conference on Manufacturing Systems, 2009. A bar of 1000 x
10 x 10 mm, clamped at one end, is loaded at the other by six loads in turn; the compliance is
identified by LIN from the nodes of that end, each of them counting alike. Errors are those of its
ten elements that are not zero, against the theory of beams (equation 22 with L/EI for k55, k66).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.fea import (
    MeshSettings,
    Part,
    PartMesh,
    Port,
    PortModel,
    SolveSettings,
    mesh_part,
    named_ports,
    reduce_part,
)
from stiffkit.fea.fields import CASES, face_nodes, node_field
from stiffkit.fea.memory import free_bytes
from stiffkit.fea.square_bar import square_bar
from stiffkit.identify import Field, Identified, Options, ResidualFields, identify, residual_fields
from stiffkit.link import Material, beam_compliance, rectangle
from stiffkit.progress import Progress, no_progress
from stiffkit.spatial.rotation import Array

LENGTH, WIDTH = 1.0, 0.01
"""m."""
STEEL = Material("steel of the paper", E=2e11, nu=0.266, density=7800.0)
LOADS = np.diag([1000.0, 1.0, 1.0, 1.0, 1.0, 1.0])
"""N and N m, section 4.2."""
TIP_POINT = np.array([LENGTH, 0.5 * WIDTH, 0.5 * WIDTH])
DROPPED = 10.0
"""Percent of the nodes that section 4.5 takes away."""
NEIGHBOURHOOD = WIDTH
"""m, length of the cubic field of section 4.4."""

_TIP = 1


@dataclass(frozen=True)
class Meshing:
    """One column of Table 5."""

    order: int
    """1 linear, 2 parabolic."""
    size: float
    """mm."""
    printed: str
    """%, largest error."""
    memory: float
    """bytes that the solve takes, measured."""

    @property
    def name(self) -> str:
        """In the paper's words."""
        return f"{'linear' if self.order == 1 else 'parabolic'} {self.size:g} mm"


MESHINGS = (
    Meshing(1, 3.0, "27", 0.5e9),
    Meshing(1, 2.0, "20", 0.8e9),
    Meshing(1, 1.0, "12", 4e9),
    Meshing(2, 5.0, "3.3", 0.5e9),
    Meshing(2, 3.0, "0.19", 0.8e9),
    Meshing(2, 2.0, "0.10", 2.5e9),
)
"""Table 5."""

USUAL = tuple(meshing for meshing in MESHINGS if meshing.size > 1.0)
"""Those that take less than a minute; the others take minutes to mesh."""

REFERENCE = (5.0, 5)
"""Size, mm, and order of the converged solution: 0.003 % from order 6 on the same mesh."""


@dataclass(frozen=True, eq=False)
class Level:
    """What one mesh gives."""

    meshing: Meshing
    elements: int
    unknowns: int
    seconds: float
    """s for mesh and solution."""
    field: Field
    """The nodes of the loaded end."""
    found: Identified
    """From all of them."""
    filtered: Identified
    """Without `DROPPED` percent in each load case."""
    residuals: ResidualFields
    """Of `filtered`, and before."""
    cubic: Identified | None
    """From all nodes within `NEIGHBOURHOOD` of the loaded end, by a parabolic mesh."""

    @property
    def zeros(self) -> int:
        """Elements whose interval holds zero."""
        return int((~self.found.significant).sum())


@dataclass(frozen=True, eq=False)
class Cantilever:
    """All of section 4."""

    levels: tuple[Level, ...]
    left_out: tuple[tuple[Meshing, str], ...]
    """Meshes that were not solved, and why."""
    converged: Array
    """(6, 6), SI, of the solid with its end clamped, read as the mean of the other end."""

    @property
    def finest(self) -> Level | None:
        """The finest parabolic mesh that was solved; that of 2 mm is what section 4 speaks of."""
        parabolic = [level for level in self.levels if level.meshing.order == 2]
        return min(parabolic, key=lambda level: level.meshing.size, default=None)


def theory() -> Array:
    """Return the compliance (6, 6), SI, of equation 22 without its misprint."""
    slender = replace(rectangle(WIDTH, WIDTH), shear_y=None, shear_z=None)
    return beam_compliance(LENGTH, slender, STEEL)


def largest_error(k: Array, wanted: Array) -> tuple[float, str]:
    """Return the largest relative error of the ten elements that are not zero, and which it is."""
    is_there = theory() != 0.0
    error = np.abs(np.divide(k, wanted, out=np.ones((6, 6)), where=is_there) - 1.0)
    i, j = np.unravel_index(int(np.where(is_there, error, 0.0).argmax()), (6, 6))
    return float(error[i, j]), f"k{i + 1}{j + 1}"


def study_cantilever(
    meshings: Sequence[Meshing] = USUAL, progress: Progress | None = None
) -> Cantilever:
    """Solve the cantilever on the given meshes, and on one of high order.

    Meshes for which memory does not suffice are left out. Raises `CadError` where one cannot be
    made or solved, or NGSolve is not there.
    """
    report = progress or no_progress
    bar = square_bar(LENGTH, WIDTH)
    ends = named_ports(bar, {"base": "clamped", "tip": "average"})
    levels: list[Level] = []
    left_out = [(m, "it takes minutes; --full solves it") for m in MESHINGS if m not in meshings]
    meshes: dict[float, PartMesh] = {}
    for number, meshing in enumerate(meshings):
        report(f"cantilever, {meshing.name}", 0.9 * number / len(meshings))
        if meshing.memory > free_bytes():
            left_out.append((meshing, f"it takes {meshing.memory / 1e9:.2g} GB of memory"))
            continue
        levels.append(_level(_mesh(bar, meshing.size, meshes), ends, meshing))
    report("cantilever, converged", 0.9)
    size, order = REFERENCE
    mesh = _mesh(bar, size, meshes)
    reference = reduce_part(mesh, ends, [STEEL], SolveSettings(order)).compliance
    return Cantilever(tuple(levels), tuple(left_out), reference)


def _mesh(bar: Part, size: float, known: dict[float, PartMesh]) -> PartMesh:
    """Return a mesh of a size in mm, made once."""
    if size not in known:
        known[size] = mesh_part(bar, MeshSettings(1e-3 * size))
    return known[size]


def _level(mesh: PartMesh, ends: tuple[Port, ...], meshing: Meshing) -> Level:
    # Of a bar as slender as this the factor is small, so that a direct solve always fits.
    settings = SolveSettings(meshing.order, solver="direct", memory=np.inf)
    model = reduce_part(mesh, ends, [STEEL], settings)
    order = meshing.order
    field = _loaded(model, face_nodes(mesh, ends[_TIP].faces, order))
    filtered = identify(field, LOADS, TIP_POINT, Options(outliers="drop", drop_percent=DROPPED))
    # What the paper calls a cube: the last ten millimetres.
    near = np.flatnonzero(mesh.points[:, 0] > LENGTH - NEIGHBOURHOOD - 1e-9)
    cubic = identify(_loaded(model, near), LOADS, TIP_POINT) if order == 2 else None
    return Level(
        meshing,
        elements=mesh.check.n_tets,
        unknowns=model.n_unknowns,
        seconds=mesh.seconds,
        field=field,
        found=identify(field, LOADS, TIP_POINT),
        filtered=filtered,
        residuals=residual_fields(field, filtered),
        cubic=cubic,
    )


def _loaded(model: PortModel, nodes: NDArray[np.integer]) -> Field:
    """Return the displacements of nodes under the paper's loads."""
    unit = node_field(model, _TIP, nodes)
    loads = np.diag(LOADS)[:, None, None]
    return Field(unit.points, loads * unit.displacements, None, CASES, unit.nodes)
