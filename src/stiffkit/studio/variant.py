"""A robot with values of its parameters, solved over its workspace."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import over_blocks
from stiffkit.errors import StiffkitError
from stiffkit.kinematics import SpanningTree, Status
from stiffkit.robot import DIRECTIONS, Robot
from stiffkit.stiffness import Assembly, Model, deflection
from stiffkit.studio.statics import static_shape
from stiffkit.studio.stations import Closed
from stiffkit.studio.view import PoseView, posture_at
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.engine import compliances
from stiffkit.study.sweep.group import CompliancesOfModel
from stiffkit.vibration import ModalModel, Modes

if TYPE_CHECKING:
    from stiffkit.studio.machine import Machine

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_TOGETHER = 2048
"""Postures at a time: what is computed of them then stays in the cache."""


class Variant:
    """A robot with values of its parameters: P postures over its workspace, and any other.

    What is asked for is computed then, and remembered. All numbers are SI.
    """

    def __init__(self, machine: Machine, values: Mapping[str, float], closed: Closed) -> None:
        """Take the parameters that are not the file's own, and the workspace of the geometry."""
        self.machine = machine
        self.values: Mapping[str, float] = dict(values)
        """Those of the parameters that were given, SI."""
        self.closed = closed
        self.swept = machine.swept
        self._compliances: dict[Model, tuple[Array, Mask]] = {}
        self._status: dict[Model, NDArray[np.int8]] = {}
        self._quantities: dict[tuple[str, Model, str | None], Array] = {}
        self._assemblies: dict[Model, Assembly] = {}

    @property
    def robot(self) -> Robot:
        """The robot, with all parameters as they are here."""
        return self.closed.geometry.robot

    @property
    def size(self) -> float:
        """A length that is typical of the robot, m."""
        return self.closed.geometry.length

    @cached_property
    def tree(self) -> SpanningTree:
        """The spanning tree, whose coordinates postures are given by."""
        return SpanningTree.of(self.robot)

    # --- the workspace ---

    @property
    def poses(self) -> Array:
        """(s, P), the tool coordinates that are swept, m and rad."""
        return self.closed.geometry.poses

    @property
    def inside(self) -> Mask:
        """(P,), which poses lie in the workspace's outline."""
        return self.closed.geometry.inside

    @property
    def reached(self) -> Mask:
        """(P,), which poses the assembly mode reaches."""
        return self.closed.reached

    @property
    def q(self) -> Array:
        """(n, P), coordinates of the tree, m and rad; NaN where not reached."""
        return self.closed.q[: self.closed.group.tree.n_coordinates]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the grid of poses, the last one of `swept` fastest; (P,) of a list."""
        return self.machine.shape

    @property
    def is_grid(self) -> bool:
        """Whether the poses are a grid rather than a list."""
        return self.machine.is_grid

    @property
    def axes(self) -> dict[str, Array]:
        """The values along each of the swept coordinates of a grid; none of a list."""
        if not self.is_grid:
            return {}
        grids = self.poses.reshape(-1, *self.shape)
        return {
            name: np.moveaxis(grid, i, 0).reshape(self.shape[i], -1)[:, 0]
            for i, (name, grid) in enumerate(zip(self.swept, grids, strict=True))
        }

    @cached_property
    def home_tool(self) -> Array:
        """(6,), tool pose at home."""
        return np.asarray(self.closed.homes.tool[:, 0])

    @cached_property
    def home(self) -> dict[str, float]:
        """The tool coordinates that fix a posture, at home."""
        return {d: float(self.home_tool[DIRECTIONS.index(d)]) for d in self.machine.asked}

    @cached_property
    def points(self) -> Array:
        """(P, 3), where the tool point is, m; coordinates that are not swept are those at home."""
        points = np.repeat(self.home_tool[None, :3], self.poses.shape[1], axis=0)
        for name, values in zip(self.swept, self.poses, strict=True):
            if name in DIRECTIONS[:3]:
                points[:, DIRECTIONS.index(name)] = values
        return points

    # --- quantities ---

    def status(self, model: Model) -> NDArray[np.int8]:
        """Return what is known of each posture by a model (P,), `stiffkit.kinematics.Status`."""
        if model not in self._status:
            _, ok = self._compliance(model)
            otherwise = Status.SINGULAR
            if (self.reached & ~ok).any() and self.machine.uncontrolled(model):
                otherwise = Status.UNCONTROLLED
            status = np.where(ok, Status.OK, otherwise).astype(np.int8)
            status[~self.reached] = Status.UNREACHABLE
            status[~self.inside] = Status.OUTSIDE
            self._status[model] = status
        return self._status[model]

    def quantity(self, name: str, model: Model, load: str | None = None) -> Array:
        """Return a quantity of `stiffkit.study.QUANTITIES` (P,), NaN where there is none.

        ``load`` is that of a deflection. Raises StiffkitError for names that do not exist, and
        for natural frequencies where there is no fast model of them.
        """
        key = name, model, load if self._check(name, model, load) else None
        if key not in self._quantities:
            quantity = QUANTITIES[name]
            lower, known = self._compliance(model)
            if quantity.source == "frequencies":
                found = self.machine.frequencies.lowest(self.closed, model, lower, known)
            elif quantity.per_load:
                found = quantity.of(deflection(lower, self.robot.loads[str(load)].wrench))
            else:
                found = quantity.of(lower)
            self._quantities[key] = found
        return self._quantities[key]

    def worst(self, name: str, model: Model, load: str | None = None) -> tuple[int, float] | None:
        """Return the number of the posture where a quantity is worst, and its value there.

        None where it has no finite value at all.
        """
        values = self.quantity(name, model, load)
        finite = np.flatnonzero(np.isfinite(values))
        if not finite.size:
            return None
        pick = np.argmax if QUANTITIES[name].worst_is_largest else np.argmin
        at = int(finite[pick(values[finite])])
        return at, float(values[at])

    def _check(self, name: str, model: Model, load: str | None) -> bool:
        """Check the names that a quantity is asked for by, and tell whether the load matters."""
        for what, given, known in (
            ("quantity", name, self.machine.quantities),
            ("model", model, self.machine.models),
        ):
            if given not in known:
                raise StiffkitError(
                    f"{self.robot.name} has no {what} '{given}'",
                    mend=f"there are: {', '.join(known)}",
                )
        per_load = QUANTITIES[name].per_load
        if per_load:
            self._wrench(load)
        return per_load

    def _wrench(self, load: str | None) -> Array:
        if load is None or load not in self.robot.loads:
            raise StiffkitError(
                f"{self.robot.name} has no load '{load}'",
                mend=f"its loads are: {', '.join(self.robot.loads) or 'none'}",
            )
        return self.robot.loads[load].wrench

    def _compliance(self, model: Model) -> tuple[Array, Mask]:
        """Return compliances (21, P), NaN where there is no answer, and where there is one (P,)."""
        if model not in self._compliances:
            self._compliances[model] = self.compliances_at(model, self.closed.q, self.reached)
        return self._compliances[model]

    def compliances_at(self, model: Model, q: Array, reached: Mask) -> tuple[Array, Mask]:
        """Return compliances (21, N) at unknowns (n, N) of the closure, and where there is one."""
        closed, own = self.closed, self.by_model(model)
        lower, ok = np.empty((21, reached.size)), np.empty(reached.size, dtype=bool)
        if own.function is not None:
            own.function.compiled()

        def work(block: slice) -> None:
            found = compliances(
                closed.group, own, [closed.geometry], q[:, None, block], reached[None, block]
            )
            lower[:, block], ok[block] = found[0][:, 0], found[1][0]

        over_blocks(reached.size, _TOGETHER, work)
        return lower, ok

    def by_model(self, model: Model) -> CompliancesOfModel:
        """Return how compliances of a model are computed."""
        return next(own for own in self.closed.group.models if own.model == model)

    def assembly(self, model: Model) -> Assembly:
        """Return the general assembly of a model, for single postures."""
        if model not in self._assemblies:
            self._assemblies[model] = Assembly(self.tree, self.size, model)
        return self._assemblies[model]

    # --- single poses ---

    def at(self, pose: Mapping[str, float]) -> PoseView:
        """Return one posture, closely, at named tool coordinates (m, rad).

        Those of `Machine.asked` that are missing are the home posture's. Raises PoseError for one
        that does not exist, or that follows from the others and has another value.
        """
        return PoseView(self, *posture_at(self, pose))

    @cached_property
    def modal(self) -> ModalModel:
        """The vibration of the refined model. Raises LinkError where masses are at fault."""
        return ModalModel(self.tree, self.size)

    def modes(self, q: Array, n: int = 4) -> Modes:
        """Return the lowest ``n`` modes at coordinates (n_coordinates,) of the tree, of `modal`."""
        return self.modal.at(q, n)

    def static_shape(self, q: Array, load: str) -> Array | None:
        """Return the static deflection under a load, as a shape of `modal`: (n_shape, 1).

        The coordinates are those of `stiffkit.vibration.Modes.shapes`, at coordinates
        (n_coordinates,) of the tree. None where the load moves the tool freely.
        """
        return static_shape(self.modal, q, self._wrench(load))
