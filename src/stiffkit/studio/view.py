"""One posture of a variant, looked at closely."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import GeometriesFunction
from stiffkit.kinematics import Postures, Status
from stiffkit.kinematics.postures import check_names
from stiffkit.kinematics.tracking import Tracker
from stiffkit.stiffness import Model
from stiffkit.studio.stations import Closed
from stiffkit.study.pose import PoseResult, judge_posture, not_reached, unreachable_pose
from stiffkit.vibration import Modes

if TYPE_CHECKING:
    from stiffkit.studio.variant import Variant

Array = NDArray[np.float64]

_STARTS = 4
"""Postures of the workspace, the nearest ones, that a pose is tried to be reached from."""


class PoseView:
    """What is known of one tool pose, each piece computed when it is asked for."""

    def __init__(self, variant: Variant, asked: Mapping[str, float], unknowns: Array) -> None:
        """Take tool coordinates (m, rad) and unknowns (n,) of the closure, NaN if not reached."""
        self.variant = variant
        self.asked: Mapping[str, float] = dict(asked)
        """The tool coordinates that fix the posture, m and rad."""
        self._unknowns = unknowns
        self._results: dict[Model, PoseResult] = {}
        self._modes: dict[int, Modes] = {}
        self._shapes: dict[str, Array | None] = {}

    @property
    def reached(self) -> bool:
        """Whether the assembly mode reaches the pose."""
        return bool(np.isfinite(self._unknowns).all())

    @property
    def q(self) -> Array:
        """(n,), coordinates of the variant's tree, m and rad; NaN where not reached."""
        return self._unknowns[: self.variant.tree.n_coordinates]

    @cached_property
    def posture(self) -> Postures:
        """The posture, a batch of one."""
        tool, joints = self.variant.closed.observe(self._unknowns[:, None])
        return Postures(self.q[:, None], tool, joints, np.array([self.reached]))

    @property
    def tool(self) -> Array:
        """(6,), tool pose; NaN where not reached."""
        return np.asarray(self.posture.tool[:, 0])

    def result(self, model: Model = "refined") -> PoseResult:
        """Return stiffness, compliance and deflections, or why there are none."""
        if model not in self._results:
            self._results[model] = self._judged(model)
        return self._results[model]

    def _judged(self, model: Model) -> PoseResult:
        variant = self.variant
        method = variant.by_model(model).method
        if not self.reached:
            return unreachable_pose(variant.robot, model, method, not_reached(self.asked))
        status = Status.OK
        if method != "assembly":
            _, ok = variant.compliances_at(model, self._unknowns[:, None], np.ones(1, dtype=bool))
            status = Status.OK if ok[0] else Status.SINGULAR
        found = judge_posture(variant.assembly(model), self.posture, status, method)
        if found.status is Status.SINGULAR and variant.machine.uncontrolled(model):
            return judge_posture(variant.assembly(model), self.posture, Status.UNCONTROLLED, method)
        return found

    def modes(self, n: int = 4) -> Modes | None:
        """Return the lowest modes of the refined model; None where the pose is not reached.

        Raises LinkError where masses are at fault.
        """
        if not self.reached:
            return None
        if n not in self._modes:
            self._modes[n] = self.variant.modes(self.q, n)
        return self._modes[n]

    def static_shape(self, load: str) -> Array | None:
        """Return the deflection under a load, (n_shape, 1), in the coordinates of `modes`.

        None where the pose is not reached, or where the load moves the tool freely.
        """
        if not self.reached:
            return None
        if load not in self._shapes:
            self._shapes[load] = self.variant.static_shape(self.q, load)
        return self._shapes[load]


def posture_at(variant: Variant, pose: Mapping[str, float]) -> tuple[dict[str, float], Array]:
    """Return the tool coordinates that fix a posture, and its unknowns (n,), NaN if not reached.

    Raises PoseError for a coordinate that does not exist, or that follows from the others and has
    another value.
    """
    check_names(pose)
    asked = {d: float(pose.get(d, own)) for d, own in variant.home.items()}
    closed, end = variant.closed, np.array(list(asked.values()))
    tracker = _tracker(closed)
    for start, start_pose in _starts(closed, end, np.array(list(variant.home.values()))):
        found = tracker.follow(start[:, None], start_pose[:, None], end[:, None])
        if found.reached[0]:
            tool, _ = closed.observe(found.q)
            variant.machine.check_dependent(pose, tool[:, 0])
            return asked, found.q[:, 0]
    return asked, np.full(closed.group.closure.n_unknowns, np.nan)


def _starts(closed: Closed, end: Array, home: Array) -> list[tuple[Array, Array]]:
    """Return postures to begin at with their tool coordinates: the nearest ones, and home."""
    turns = _turns(closed)
    scale = np.where(turns, 1.0, closed.geometry.length)
    apart = np.sum(((closed.asked - end[:, None]) / scale[:, None]) ** 2, axis=0)
    apart[~closed.reached] = np.inf
    count = min(_STARTS, int(closed.reached.sum()))
    nearest = np.argsort(apart, kind="stable")[:count] if count else np.zeros(0, dtype=np.intp)
    starts = [(closed.q[:, i], closed.asked[:, i]) for i in nearest]
    return [*starts, (closed.home_unknowns, home)]


def _tracker(closed: Closed) -> Tracker:
    rows = slice(None, closed.group.n_geometric)
    step = _Step(closed.group.step, closed.geometry.constants[rows, None])
    return Tracker(step, closed.group.closure.n_unknowns, _turns(closed))


def _turns(closed: Closed) -> NDArray[np.bool_]:
    return np.array([d.startswith("r") for d in closed.group.family.asked], dtype=bool)


class _Step:
    """Newton's step of one geometry."""

    def __init__(self, function: GeometriesFunction, constants: Array) -> None:
        self._function = function
        self._constants = constants

    def __call__(self, inputs: Array) -> Array:
        only = np.zeros(inputs.shape[1], dtype=np.intp)
        return self._function.at(self._constants, only)(inputs)
