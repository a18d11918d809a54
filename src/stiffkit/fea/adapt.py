"""The adaptive loop: order and mesh are refined until the compliance stands still."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.elasticity import SolveSettings
from stiffkit.fea.estimate import (
    Convergence,
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
from stiffkit.fea.superelement import PortModel, reduce_part
from stiffkit.fea.tets import volumes
from stiffkit.spatial.rotation import Array

ORDERS = (2, 6)
"""The first and the highest order that are tried on a mesh."""

RAISED = 4
"""The order up to which raising it is the better way to spend unknowns than a finer mesh.

Measured on real parts of a few thousand elements: their error is spread over thin walls, and order
4 on the coarsest mesh beats order 3 on one with seven times the elements.
"""

CHEAP = 60_000
"""Unknowns up to which a still higher order is tried without asking whether it will do."""

_MOST = 4.0
"""How much more than is wanted the mesher is asked for, at most, where it makes too little."""

_SURELY = 0.7
"""A solve that costs must promise to end below this share of the tolerance."""

_SAFELY = 0.5
"""And one that costs much, below this."""

GROWTH = (2.0, 3.0)
"""How many times as many elements the next mesh may have, at least and at most."""

AFFORDABLE = 450_000
"""Unknowns beyond which a solve must be likely to be the last that is needed."""


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
    order: int
    n_tets: int
    n_unknowns: int
    seconds: float
    """s since the loop began."""
    solve_seconds: float
    """s that assembly and solve took."""
    compliance: Array
    """(6(m-1), 6(m-1)), of the ports but the held one."""
    estimate: float
    """Relative error of the compliance over all wrenches; inf for the first solution."""
    geometry: float
    """The part of the estimate that is the mesh's shape."""
    trend: Convergence
    """How the solutions on this mesh converge."""


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

    On each mesh the order rises as long as that promises to do; then the elements that hold most
    of the error, which is that of the energy for all wrenches together, are made smaller and the
    whole is meshed anew. ``progress`` is called after each solution. If time, unknowns or memory
    run out, the best solution so far is returned with its estimate. Raises `CadError` if there is
    none.
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
        self.asked: tuple[int, float] | None = None
        """How many elements the last mesh but one had, and how many times as many were wanted."""
        self.distrust = 1.0
        """How much too small the estimates have proved to be so far."""

    def run(self) -> Adapted:
        wanted = self.settings.mesh or coarse_settings(self.part)
        stopped = ""
        for number in range(100):
            try:
                mesh = mesh_part(self.part, wanted)
                models, stopped = self._raise_order(mesh, number)
            except CadError as error:
                if self.best is None:
                    raise
                stopped = error.what
                break
            if stopped or self._is_done():
                break
            wanted = self._finer(mesh, models)
        if self.best is None:
            raise CadError("no solution was found within the limits", mend="allow more")
        model, mesh = self.best
        if model.solver.body.is_released:
            # A solve that failed came after it; what is still to be asked of it needs its factor.
            settings = model.solver.body.settings
            model = reduce_part(mesh, self.ports, self.laws, settings, self.held)
        return Adapted(model, mesh, tuple(self.history), self._is_done(), stopped)

    def _is_done(self) -> bool:
        return self.history[-1].estimate <= self.settings.tolerance

    def _raise_order(self, mesh: PartMesh, number: int) -> tuple[list[PortModel], str]:
        """Solve with rising order on a mesh; return the last two solutions and why it must end."""
        first, highest = ORDERS
        models: list[PortModel] = []
        levels: list[Level] = []
        for order in range(first, highest + 1):
            reason = self._limit(levels, order) if self.history else ""
            if reason:
                return models, reason
            if self.best is not None:
                self.best[0].solver.body.release()
            begin = time.perf_counter()
            solve = replace(self.settings.solve, order=order)
            model = reduce_part(mesh, self.ports, self.laws, solve, self.held)
            models = [*models[-1:], model]
            levels.append(self._level(mesh, number, model, levels, order, begin))
            self.history.append(levels[-1])
            self.best = (model, mesh)
            if self.progress is not None:
                self.progress(levels[-1])
            if self._is_done() or not self._another_order_pays(levels):
                break
        self._learn(number)
        return models, ""

    def _level(
        self,
        mesh: PartMesh,
        number: int,
        model: PortModel,
        before: Sequence[Level],
        order: int,
        begin: float,
    ) -> Level:
        k = model.compliance
        same = [*((level.n_unknowns, level.compliance) for level in before), (model.n_unknowns, k)]
        trend = convergence([n for n, _ in same], [c for _, c in same])
        shape = geometry_error(mesh.check.volume_error, mesh.check.area_error)
        now = time.perf_counter()
        return Level(
            mesh=number,
            order=order,
            n_tets=mesh.check.n_tets,
            n_unknowns=model.n_unknowns,
            seconds=now - self.start,
            solve_seconds=now - begin,
            compliance=k,
            estimate=self.distrust * trend.error + shape,
            geometry=shape,
            trend=trend,
        )

    def _another_order_pays(self, levels: Sequence[Level]) -> bool:
        """Say whether another order is cheap, or likely to be the last that is needed."""
        if len(levels) < 2:
            return True
        last = levels[-1]
        growth = ((last.order + 1.0) / last.order) ** 3
        tolerance = self.settings.tolerance
        if last.geometry > 0.7 * tolerance:
            return False
        unknowns = growth * last.n_unknowns
        if unknowns <= (AFFORDABLE if last.order < RAISED else CHEAP):
            return True
        # Singular edges slow convergence down as the order rises: leave some room.
        promise = last.geometry + self.distrust * last.trend.predict(growth)
        return promise <= (_SURELY if unknowns <= AFFORDABLE else _SAFELY) * tolerance

    def _limit(self, levels: Sequence[Level], order: int) -> str:
        """Say which limit another solve would break, if any."""
        if time.perf_counter() - self.start > self.settings.max_seconds:
            return f"the time of {self.settings.max_seconds:g} s is used up"
        if levels:
            unknowns = levels[-1].n_unknowns * (order / (order - 1.0)) ** 3
            if unknowns > self.settings.max_unknowns:
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

    def _finer(self, mesh: PartMesh, models: Sequence[PortModel]) -> MeshSettings:
        """Return settings for a mesh with smaller elements where the error is."""
        coarse, fine = models
        W = whitening(fine.solver.compliance_of_loads)
        energies = fine.solver.body.difference_energies(
            fine.solver.load_fields @ W, coarse.solver.body, coarse.solver.load_fields @ W
        )
        sizes = (6.0 * np.sqrt(2.0) * volumes(mesh.points, mesh.tets)) ** (1.0 / 3.0)
        last = self.history[-1]
        excess = (last.estimate - last.geometry) / (_SURELY * self.settings.tolerance)
        growth = float(np.clip(np.sqrt(excess), *GROWTH))
        finer = wanted_sizes(sizes, energies, growth * self._shortfall(mesh))
        self.asked = (len(sizes), growth)
        marked = finer < 0.95 * sizes
        points = mesh.points[mesh.tets[marked, :4]].mean(axis=1)
        wanted = finer[marked]
        old = mesh.settings
        if old.wanted is not None:
            points = np.concatenate([old.wanted[0], points])
            wanted = np.concatenate([old.wanted[1], wanted])
        bends = 1.4 if last.geometry > 0.4 * self.settings.tolerance else 1.0
        return replace(
            old,
            feature=0.5 * old.feature,
            curvature=bends * old.curvature,
            wanted=(points, wanted),
        )
