"""The adaptive loop: orders rise and elements are cut until the compliance stands still."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.child import TIMEOUT
from stiffkit.fea.choice import choose
from stiffkit.fea.estimate import convergence, geometry_error, whitening
from stiffkit.fea.geometry import Part
from stiffkit.fea.interfaces import Port
from stiffkit.fea.material import Law
from stiffkit.fea.memory import Fill
from stiffkit.fea.mesh import MeshSettings, PartMesh, bisect_mesh, coarse_settings, mesh_part
from stiffkit.fea.orders import Orders
from stiffkit.fea.settings import SolveSettings
from stiffkit.fea.superelement import PortModel, reduce_part
from stiffkit.spatial.rotation import Array

FIRST_ORDER = 2
"""Of all elements of a new mesh."""

_ANSWER = 0.1
"""An estimate that makes a first answer: up to it, the mesh is not made again for its shape."""

_SHAPE = 0.5
"""The share of the tolerance that the mesh's shape may take."""

_BENDS = (1.0, 1.4, 1.8, 2.3, 3.0, 4.0, 5.0)
"""How much finer than the first mesh the others resolve curved faces."""

_WORK = 1.7
"""A solve takes time with this power of the unknowns."""

_NOTHING_LEFT = 0.2
"""The share of the tolerance below which more solves do not help where the shape is too bad."""


@dataclass(frozen=True)
class AdaptSettings:
    """When the loop ends."""

    tolerance: float = 1e-3
    """Relative error of the compliance, over all wrenches, that is asked for."""
    max_unknowns: int = 1_500_000
    max_seconds: float = 600.0
    """s beyond which no further solve is expected to last."""
    solve: SolveSettings = field(default_factory=SolveSettings)
    """How each discretisation is solved; its order is the loop's to choose."""
    mesh: MeshSettings | None = None
    """The first mesh; chosen from the part's size if None."""
    features: float | None = None
    """m: smaller features refine no mesh; chosen mesh by mesh from the part's size if None."""


@dataclass(frozen=True, eq=False)
class Level:
    """One solution on the way."""

    mesh: int
    """Which mesh of the mesher, from 0; elements may have been cut since."""
    orders: tuple[int, int]
    """The lowest and the highest of the elements."""
    n_tets: int
    n_unknowns: int
    seconds: float
    """s since the loop began."""
    compliance: Array
    """(6(m-1), 6(m-1)), of the ports but the held one."""
    estimate: float
    """Relative error of the compliance over all wrenches; inf for a mesh's first solution."""
    geometry: float
    """The part of the estimate that is the mesh's shape."""
    ratio: float
    """Of the errors of successive solutions, as estimated."""


@dataclass(frozen=True, eq=False)
class Adapted:
    """The best solution, and the way to it and beyond."""

    model: PortModel
    mesh: PartMesh
    level: Level
    """Of the history, the one that the solution is of."""
    history: tuple[Level, ...]
    converged: bool
    """Whether the estimate is below the tolerance."""
    stopped: str = ""
    """Why the loop ended before that."""

    @property
    def estimate(self) -> float:
        """Relative error of the compliance, over all wrenches."""
        return self.level.estimate


@dataclass(frozen=True, eq=False)
class _Solution:
    level: Level
    mesh: PartMesh
    orders: Orders
    model: PortModel


def adapt(
    part: Part,
    ports: Sequence[Port],
    laws: Sequence[Law],
    settings: AdaptSettings | None = None,
    *,
    held: int = 0,
    progress: Callable[[Level], None] | None = None,
) -> Adapted:
    """Refine until the estimated error of the compliance is below the tolerance.

    With each solution, the elements that hold most of the error get a higher order or are cut, see
    `choose`, so that the functions of one solution contain those of the one before. If the mesh
    meets the part's shape too badly for the tolerance, the part is meshed anew, once there is a
    first answer. ``progress`` is called after each solution. If time, unknowns or memory run out,
    the best solution so far is returned with its estimate. Raises `CadError` if there is none.
    """
    return _Loop(part, ports, laws, settings or AdaptSettings(), held, progress).run()


class _Loop:
    def __init__(
        self,
        part: Part,
        ports: Sequence[Port],
        laws: Sequence[Law],
        settings: AdaptSettings,
        held: int,
        progress: Callable[[Level], None] | None,
    ) -> None:
        self.part, self.ports, self.laws = part, ports, laws
        self.settings, self.held, self.progress = settings, held, progress
        self.start = time.perf_counter()
        self.history: list[Level] = []
        self.chain: list[Array] = []
        """Compliances of successive approximations of one shape."""
        self.n_meshes = 0
        self.best: _Solution | None = None
        self.last: _Solution | None = None
        self.last_work: tuple[float, int] | None = None
        """s that the last solve took, and its unknowns."""
        self.fill: Fill | None = None

    def run(self) -> Adapted:
        stopped = ""
        try:
            self._approach()
        except CadError as error:
            if self.best is None:
                raise
            stopped = error.what
        best = self.best
        if best is None:
            raise CadError("no solution was found within the limits", mend="allow more")
        model = best.model
        if model.solver.body.is_released:
            # What is still to be asked of it needs its factor.
            model = self._reduce(best.mesh, best.orders)
        done = best.level.estimate <= self.settings.tolerance
        return Adapted(model, best.mesh, best.level, tuple(self.history), done, stopped)

    def _approach(self) -> None:
        """Solve and refine until the tolerance is reached; raise `CadError` where it cannot be."""
        wanted = self.settings.mesh or coarse_settings(self.part)
        if self.settings.features is not None:
            wanted = replace(wanted, feature=self.settings.features)
        mesh = self._new_mesh(wanted)
        orders = np.full(len(mesh.tets), FIRST_ORDER)
        keeps_shape = False
        while True:
            last = self._solve(mesh, orders)
            level = last.level
            if level.estimate <= self.settings.tolerance:
                return
            if not keeps_shape and level.estimate < _ANSWER and not self._has_shape(mesh):
                keeps_shape = True
                better = self._better_shape(mesh)
                if better is not None:
                    mesh, orders = better, np.full(len(better.tets), FIRST_ORDER)
                    self.chain.clear()
                    continue
            left = level.estimate - level.geometry
            if keeps_shape and left < _NOTHING_LEFT * self.settings.tolerance < level.geometry:
                raise CadError("the mesh meets the part's shape no better")
            mesh, orders = self._refined(last)

    def _new_mesh(self, settings: MeshSettings) -> PartMesh:
        """Return a mesh; the first may take as long as it needs, others the time that is left."""
        timeout = TIMEOUT if self.best is None else max(1.0, self._seconds_left())
        return mesh_part(self.part, settings, timeout=timeout)

    def _seconds_left(self) -> float:
        return self.settings.max_seconds - (time.perf_counter() - self.start)

    def _has_shape(self, mesh: PartMesh) -> bool:
        return _shape_error(mesh) <= _SHAPE * self.settings.tolerance

    def _better_shape(self, mesh: PartMesh) -> PartMesh | None:
        """Return a mesh that meets the part's shape well enough, or best; None if none is better.

        One that is too large to be solved is none.
        """
        first, best = mesh.settings, mesh
        for previous, bends in itertools.pairwise(_BENDS):
            if self._is_too_large(len(best.tets), (bends / previous) ** 2):
                break
            feature = self.settings.features or first.feature / bends
            finer = replace(first, curvature=bends * first.curvature, feature=feature)
            try:
                found = self._new_mesh(finer)
            except CadError:
                break
            if _shape_error(found) < _shape_error(best):
                best = found
            if self._has_shape(best):
                break
        self.n_meshes += best is not mesh
        return None if best is mesh else best

    def _is_too_large(self, n_tets: int, growth: float) -> bool:
        """Say whether a mesh with so many times as many elements is beyond all limits."""
        # Quadratic elements have about four unknowns each, and more than once that is needed.
        return 8.0 * growth * n_tets > self.settings.max_unknowns or self._seconds_left() < 0.0

    def _refined(self, last: _Solution) -> tuple[PartMesh, Orders]:
        """Return the mesh and the orders (e,) of the next solution."""
        W = whitening(last.model.solver.compliance_of_loads)
        contents = last.model.solver.body.contents(last.model.solver.load_fields @ W)
        choice = choose(last.orders, contents)
        orders = last.orders + choice.raised
        if not choice.cut.any():
            return last.mesh, orders
        mesh, parents = bisect_mesh(self.part, last.mesh, choice.cut)
        return mesh, orders[parents]

    def _solve(self, mesh: PartMesh, orders: Orders) -> _Solution:
        """Solve within the limits, and add the solution to the history."""
        self._check_limits(mesh, orders)
        if self.last is not None:
            self.last.model.solver.body.release()
        before = time.perf_counter()
        model = self._reduce(mesh, orders)
        self.last_work = time.perf_counter() - before, model.n_unknowns
        self.fill = model.solver.body.fill
        self.chain.append(model.compliance)
        trend, shape = convergence(self.chain), _shape_error(mesh)
        level = Level(
            mesh=self.n_meshes,
            orders=(int(orders.min()), int(orders.max())),
            n_tets=len(mesh.tets),
            n_unknowns=model.n_unknowns,
            seconds=time.perf_counter() - self.start,
            compliance=model.compliance,
            estimate=trend.error + shape,
            geometry=shape,
            ratio=trend.ratio,
        )
        self.history.append(level)
        self.last = _Solution(level, mesh, orders, model)
        if self.best is None or level.estimate <= self.best.level.estimate:
            self.best = self.last
        if self.progress is not None:
            self.progress(level)
        return self.last

    def _reduce(self, mesh: PartMesh, orders: Orders) -> PortModel:
        solve = replace(
            self.settings.solve, order=int(orders.max()), orders=orders, known=self.fill
        )
        return reduce_part(mesh, self.ports, self.laws, solve, self.held)

    def _check_limits(self, mesh: PartMesh, orders: Orders) -> None:
        """Raise `CadError` if a solve with orders (e,) is to break a limit."""
        n_unknowns = 3 * mesh.topology.node_count(orders)
        if n_unknowns > self.settings.max_unknowns:
            raise CadError(
                f"the next solve would take {n_unknowns} unknowns, of "
                f"{self.settings.max_unknowns} allowed",
                mend="allow more unknowns, or a larger error",
            )
        if self.last_work is None:
            return
        seconds, solved = self.last_work
        expected = seconds * (n_unknowns / solved) ** _WORK
        if expected > self._seconds_left():
            raise CadError(
                f"the next solve would take about {math.ceil(expected)} s, beyond the time of "
                f"{self.settings.max_seconds:g} s",
                mend="allow more time, or a larger error",
            )


def _shape_error(mesh: PartMesh) -> float:
    return geometry_error(mesh.check.volume_error, mesh.check.area_error)
