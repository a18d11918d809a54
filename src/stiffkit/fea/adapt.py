"""The adaptive loop: orders and mesh are refined until the compliance stands still."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import cKDTree

from stiffkit.errors import CadError
from stiffkit.fea.child import TIMEOUT
from stiffkit.fea.elasticity import SolveSettings
from stiffkit.fea.estimate import (
    convergence,
    geometry_error,
    relative_difference,
    wanted_sizes,
    whitening,
)
from stiffkit.fea.geometry import Part
from stiffkit.fea.interfaces import Port
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import MeshSettings, PartMesh, coarse_settings, mesh_part
from stiffkit.fea.orders import Gains, Orders
from stiffkit.fea.superelement import PortModel, reduce_part
from stiffkit.fea.tets import volumes
from stiffkit.spatial.rotation import Array

FIRST_ORDER = 2
"""Of all elements of the first mesh."""

CHEAP = 80_000
"""Unknowns up to which orders are raised without asking whether that will do."""

AFFORDABLE = 300_000
"""Unknowns that are worth spending on a mesh before it is judged."""

LAST = 600_000
"""Those within which it must then promise to reach the tolerance."""

GROWTH = (1.3, 2.0)
"""How many times as many elements the next mesh may have, at least and at most."""

_FEWEST = 3
"""Solutions that a mesh gets, if they are affordable, before it is judged."""

_ANSWER = 0.1
"""An estimate that makes a first answer: up to it, the mesh is not made again for its shape."""

_SURELY = 0.7
"""The share of the tolerance that is aimed at."""

_STUCK = 0.5
"""The share that elements of the highest order may have before they are made smaller."""

_SMALLER = 0.7
"""Elements this much smaller than those that they replace begin with a lower order."""

_MOST = 4.0
"""How much more than is wanted the mesher is asked for, at most, where it makes too little."""


@dataclass(frozen=True)
class AdaptSettings:
    """When the loop ends."""

    tolerance: float = 1e-3
    """Relative error of the compliance, over all wrenches, that is asked for."""
    max_unknowns: int = 1_500_000
    max_seconds: float = 600.0
    """s after which no further solve is begun."""
    solve: SolveSettings = field(default_factory=SolveSettings)
    """How each discretisation is solved; its order is the loop's to choose."""
    mesh: MeshSettings | None = None
    """The first mesh; chosen from the part's size if None."""


@dataclass(frozen=True, eq=False)
class Level:
    """One solution on the way."""

    mesh: int
    """Which mesh, from 0."""
    orders: tuple[int, int]
    """The lowest and the highest of the elements."""
    n_tets: int
    n_unknowns: int
    seconds: float
    """s since the loop began."""
    compliance: Array
    """(6(m-1), 6(m-1)), of the ports but the held one."""
    estimate: float
    """Relative error of the compliance over all wrenches; inf for the first solution."""
    geometry: float
    """The part of the estimate that is the mesh's shape."""
    stuck: float
    """The part that is left in elements of the highest order."""
    ratio: float
    """Of the errors of successive solutions, as estimated."""


@dataclass(frozen=True, eq=False)
class Adapted:
    """The last solution, and the way to it."""

    model: PortModel
    mesh: PartMesh
    history: tuple[Level, ...]
    converged: bool
    """Whether the estimate is below the tolerance."""
    stopped: str = ""
    """Why the loop ended before that."""

    @property
    def estimate(self) -> float:
        """Relative error of the compliance, over all wrenches."""
        return self.history[-1].estimate


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

    On each mesh the order is raised in the elements where that is to gain most, which is the
    energy of the difference for all wrenches together, as long as it promises to do; then the
    elements that hold most of what is left are made smaller and the whole is meshed anew.
    ``progress`` is called after each solution. If time, unknowns or memory run out, the best
    solution so far is returned with its estimate. Raises `CadError` if there is none.
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
        self.best: tuple[PortModel, PartMesh] | None = None
        self.chain: list[Array] = []
        """Compliances of successive approximations."""
        self.orders: Orders = np.ones(1, dtype=np.intp)
        self.last: tuple[PartMesh, Gains] | None = None
        """The last mesh, and what its orders gained."""
        self.asked: tuple[int, float] | None = None
        """How many elements the last mesh but one had, and how many times as many were wanted."""
        self.distrust = 1.0
        """How much too small the estimates have proved to be so far."""

    def run(self) -> Adapted:
        wanted = self.settings.mesh or coarse_settings(self.part)
        stopped = ""
        for number in range(100):
            try:
                mesh = mesh_part(self.part, wanted, timeout=self._time_to_mesh())
                gains, stopped = self._raise_orders(mesh, number)
            except CadError as error:
                if self.best is None:
                    raise
                stopped = error.what
                break
            if stopped or self._is_done():
                break
            wanted = self._finer(mesh, gains)
            self.last = (mesh, gains)
        if self.best is None:
            raise CadError("no solution was found within the limits", mend="allow more")
        model, mesh = self.best
        if model.solver.body.is_released:
            # A solve that failed came after it; what is still to be asked of it needs its factor.
            settings = model.solver.body.settings
            model = reduce_part(mesh, self.ports, self.laws, settings, self.held)
        return Adapted(model, mesh, tuple(self.history), self._is_done(), stopped)

    def _time_to_mesh(self) -> float:
        """Return the s that a mesh may take: the first as many as it needs."""
        if self.best is None:
            return TIMEOUT
        return max(1.0, self.settings.max_seconds - (time.perf_counter() - self.start))

    def _is_done(self) -> bool:
        return self.history[-1].estimate <= self.settings.tolerance

    def _raise_orders(self, mesh: PartMesh, number: int) -> tuple[Gains, str]:
        """Solve with rising orders on a mesh; return their gains and why it must end, if so."""
        model, gains = self._begin(mesh, number)
        stopped = ""
        while not (self._is_done() or stopped):
            orders = gains.raised()
            if np.array_equal(orders, gains.orders) or not self._another_pays(gains):
                break
            stopped = self._limit(mesh, orders)
            if not stopped:
                before, model = model, self._solve(mesh, orders)
                gains.learn(orders, _energies(before, model))
                self._record(number, gains)
        self._learn(number)
        return gains, stopped

    def _begin(self, mesh: PartMesh, number: int) -> tuple[PortModel, Gains]:
        """Solve on a new mesh with the orders that the last one ended with, at the same places."""
        if self.last is None:
            orders = np.full(len(mesh.tets), FIRST_ORDER, dtype=np.intp)
            before = self._solve(mesh, orders - 1)
            self._record(number)
            model = self._solve(mesh, orders)
            gains = Gains(orders, _energies(before, model))
        else:
            old, gains = self.last
            _, there = cKDTree(_centres(old)).query(_centres(mesh))
            shrink = np.minimum(1.0, _sizes(mesh) / _sizes(old)[there])
            orders = np.maximum(gains.orders[there] - (shrink < _SMALLER), FIRST_ORDER)
            gains = gains.moved(orders, there, shrink)
            if self._is_shape_bad():
                # The next solution is no better approximation of the same, but of another shape.
                self.chain.pop()
            if reason := self._limit(mesh, orders):
                raise CadError(reason, mend="allow more time or unknowns, or a larger error")
            model = self._solve(mesh, orders)
        self._record(number)
        return model, gains

    def _solve(self, mesh: PartMesh, orders: Orders) -> PortModel:
        if self.best is not None:
            self.best[0].solver.body.release()
        solve = replace(self.settings.solve, order=int(orders.max()), orders=orders)
        model = reduce_part(mesh, self.ports, self.laws, solve, self.held)
        self.best = (model, mesh)
        self.orders = orders
        return model

    def _record(self, number: int, gains: Gains | None = None) -> None:
        """Add the last solution, and what it gained where that is known, to the history."""
        if self.best is None:
            return
        model, mesh = self.best
        self.chain.append(model.compliance)
        trend = convergence(self.chain)
        shape = geometry_error(mesh.check.volume_error, mesh.check.area_error)
        waiting = gains.waiting() * trend.change if gains else 0.0
        level = Level(
            mesh=number,
            orders=(int(self.orders.min()), int(self.orders.max())),
            n_tets=mesh.check.n_tets,
            n_unknowns=model.n_unknowns,
            seconds=time.perf_counter() - self.start,
            compliance=model.compliance,
            estimate=self.distrust * (trend.error + waiting) + shape,
            stuck=self.distrust * gains.stuck() * trend.change if gains else 0.0,
            geometry=shape,
            ratio=trend.ratio,
        )
        self.history.append(level)
        if self.progress is not None:
            self.progress(level)

    def _is_shape_bad(self) -> bool:
        """Say whether it is the mesh's shape that keeps the solution from being right."""
        last = self.history[-1]
        return last.geometry > _SURELY * self.settings.tolerance and last.estimate < _ANSWER

    def _another_pays(self, gains: Gains) -> bool:
        """Say whether higher orders are likely to reach the tolerance at a bearable cost."""
        last, before = self.history[-1], self.history[-2]
        tolerance = self.settings.tolerance
        if self._is_shape_bad() or last.stuck > _STUCK * tolerance:
            return False
        growth = float(np.clip(last.n_unknowns / before.n_unknowns, 1.2, 1.5))
        tried = sum(level.mesh == last.mesh for level in self.history)
        if last.n_unknowns * growth <= (AFFORDABLE if tried < _FEWEST else CHEAP):
            return True
        room = max(_SURELY * tolerance - last.geometry, 0.1 * tolerance)
        excess = (last.estimate - last.geometry) / room
        steps = max(1.0, float(np.log(excess) / -np.log(last.ratio)))
        if gains.smooth() > 0.5:
            steps = 1.0
        return bool(last.n_unknowns * growth**steps <= LAST)

    def _limit(self, mesh: PartMesh, orders: Orders) -> str:
        """Say which limit a solve with orders (e,) would break, if any."""
        if time.perf_counter() - self.start > self.settings.max_seconds:
            return f"the time of {self.settings.max_seconds:g} s is used up"
        if 3 * int(mesh.topology.space(orders).ndof) > self.settings.max_unknowns:
            return f"the next solve would take more than {self.settings.max_unknowns} unknowns"
        return ""

    def _learn(self, number: int) -> None:
        """Compare what the last mesh's estimate promised with what this mesh's solution says."""
        previous = [level for level in self.history if level.mesh == number - 1]
        if not previous:
            return
        promised, now = previous[-1], self.history[-1]
        real = relative_difference(promised.compliance - now.compliance, now.compliance)
        if np.isfinite(promised.estimate) and real > promised.estimate:
            self.distrust *= min(3.0, real / promised.estimate)

    def _shortfall(self, mesh: PartMesh) -> float:
        """Return how many times fewer elements than asked for the mesher made last time."""
        if self.asked is None:
            return 1.0
        before, growth = self.asked
        return float(np.clip(growth * before / len(mesh.tets), 1.0, _MOST))

    def _finer(self, mesh: PartMesh, gains: Gains) -> MeshSettings:
        """Return settings for a mesh with smaller elements where the error is."""
        sizes = _sizes(mesh)
        last = self.history[-1]
        excess = (last.estimate - last.geometry) / (_SURELY * self.settings.tolerance)
        growth = float(np.clip(1.0 if self._is_shape_bad() else np.sqrt(excess), *GROWTH))
        finer = wanted_sizes(sizes, gains.left(), growth * self._shortfall(mesh))
        self.asked = (len(sizes), growth)
        marked = finer < 0.95 * sizes
        points, wanted = _centres(mesh)[marked], finer[marked]
        old = mesh.settings
        if old.wanted is not None:
            points = np.concatenate([old.wanted[0], points])
            wanted = np.concatenate([old.wanted[1], wanted])
        bends = 1.4 if last.geometry > 0.5 * self.settings.tolerance else 1.0
        return replace(
            old,
            feature=0.5 * old.feature,
            curvature=bends * old.curvature,
            wanted=(points, wanted),
        )


def _energies(before: PortModel, model: PortModel) -> Array:
    """Return the energies (e,), J, of the difference of two solutions on a mesh, all wrenches."""
    W = whitening(model.solver.compliance_of_loads)
    return model.solver.body.difference_energies(
        model.solver.load_fields @ W, before.solver.body, before.solver.load_fields @ W
    )


def _sizes(mesh: PartMesh) -> Array:
    """Return the sizes (e,), m, of the elements: the edges of regular ones of their volume."""
    return np.asarray((6.0 * np.sqrt(2.0) * volumes(mesh.points, mesh.tets)) ** (1.0 / 3.0))


def _centres(mesh: PartMesh) -> Array:
    return np.asarray(mesh.points[mesh.tets[:, :4]].mean(axis=1))
