"""CalculiX and Stiffkit on the same mesh, and to the same error."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.fea import calculix, ours
from benchmarks.fea.convergence import Errors, Reached, errors, reach
from benchmarks.fea.parts import STEEL, Case
from benchmarks.measure import Cost, median_cost
from stiffkit.fea import (
    MeshSettings,
    Part,
    PartMesh,
    SolveSettings,
    mesh_part,
    reduce_part,
    relative_difference,
)

REPEATS = 3
"""Solutions of ours, of which the median is taken; CalculiX runs once."""

_CLEARLY = 0.8
"""The share of the time of six steps up to which Green functions are clearly faster; equations
that tie the tip together make them slower on finer meshes."""

LONGEST = 180.0
"""s of processors that one run of CalculiX may take."""


@dataclass(frozen=True)
class Same:
    """One mesh of quadratic tetrahedra, solved by both on one core."""

    part: str
    tip: str
    """Interface of the tip: average or rigid."""
    unknowns: int
    ours: Cost
    """Of assembly and of the solution for all six loads."""
    reading: Cost
    """Of CalculiX's whole process without a solution."""
    processes: dict[calculix.Way, Cost]
    """Of CalculiX's whole process."""
    difference: dict[calculix.Way, float]
    """Of the two compliances, relative, over all wrenches."""

    def theirs(self, way: calculix.Way) -> Cost:
        """Return what CalculiX takes beside reading."""
        return self.processes[way] - self.reading

    def ratio(self, way: calculix.Way) -> float:
        """Return CalculiX's processor seconds, beside reading, over ours."""
        return self.theirs(way).cpu / self.ours.cpu

    @property
    def best(self) -> calculix.Way:
        """The way in which CalculiX is to give all six loads on finer meshes.

        Where both take about as long, that whose time grows more slowly.
        """
        is_faster = self.theirs("Green").cpu < _CLEARLY * self.theirs("six steps").cpu
        return "Green" if is_faster else "six steps"


def same_mesh(case: Case, part: Part, tip: str) -> Same:
    """Solve a part with both on one mesh."""
    mesh, ports = mesh_part(part, MeshSettings(case.size)), case.ports(part, tip)
    settings = SolveSettings(order=2, threads=1)
    k = reduce_part(mesh, ports, [STEEL], settings)
    own = median_cost(lambda: reduce_part(mesh, ports, [STEEL], settings), REPEATS)
    costs: dict[calculix.Way, Cost] = {}
    differences: dict[calculix.Way, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        for way in calculix.WAYS:
            run = calculix.run(mesh, ports, way, Path(folder))
            costs[way] = run.cost
            if run.compliance.shape == (6, 6):
                D = run.compliance - k.compliance
                differences[way] = relative_difference(0.5 * (D + D.T), k.compliance)
    return Same(case.name, tip, k.n_unknowns, own, costs.pop("read"), costs, differences)


@dataclass(frozen=True)
class Mesh:
    """One of CalculiX's meshes."""

    unknowns: int
    cost: Cost
    """Beside reading, for all six loads."""
    errors: Errors


@dataclass(frozen=True)
class Accuracy:
    """What both take to reach an error."""

    part: str
    tolerance: float
    way: calculix.Way
    meshes: list[Mesh]
    ours: ours.Loop
    ours_errors: Errors
    """Real ones, against the reference."""
    by_wrenches: Reached
    """CalculiX, error over all wrenches."""
    by_elements: Reached
    """CalculiX, error of the elements."""


def convergence(case: Case, part: Part, way: calculix.Way) -> list[Mesh]:
    """Return CalculiX's errors and costs on finer and finer meshes."""
    ports, reference = case.ports(part), case.reference()
    out: list[Mesh] = []
    with tempfile.TemporaryDirectory() as folder:
        for size in case.finer:
            mesh = mesh_part(part, MeshSettings(size))
            if out and out[-1].cost.cpu * _growth(out[-1], mesh) > LONGEST:
                break
            read = calculix.run(mesh, ports, "read", Path(folder)).cost
            run = calculix.run(mesh, ports, way, Path(folder))
            found = errors(run.compliance, reference)
            out.append(Mesh(3 * len(mesh.points), run.cost - read, found))
    return out


def _growth(last: Mesh, mesh: PartMesh) -> float:
    """Return how many times as long as the last mesh this one may take."""
    return float((3 * len(mesh.points) / last.unknowns) ** 2)


def same_error(case: Case, meshes: list[Mesh], way: calculix.Way, tolerance: float) -> Accuracy:
    """Solve a part to a tolerance, and say what CalculiX takes for that."""
    loop = ours.solve(case.name, tolerance, 1)
    sizes = np.array([m.unknowns for m in meshes], dtype=float)
    cpu = np.array([m.cost.cpu for m in meshes])
    return Accuracy(
        case.name,
        tolerance,
        way,
        meshes,
        loop,
        errors(loop.compliance, case.reference()),
        reach(sizes, np.array([m.errors.wrenches for m in meshes]), cpu, tolerance),
        reach(sizes, np.array([m.errors.elements for m in meshes]), cpu, tolerance),
    )
