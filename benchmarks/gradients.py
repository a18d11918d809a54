"""What derivatives cost beside the values: a mean over the workspace, by all parameters."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from benchmarks.measure import cost, median_cost
from stiffkit.kinematics.numeric import one_thread
from stiffkit.robot import load_robot
from stiffkit.study.sweep.engine import Engine
from stiffkit.study.sweep.family import Family
from stiffkit.study.sweep.gradients import Gradients
from stiffkit.study.sweep.group import Groups
from stiffkit.study.sweep.prepare import make_anchors
from stiffkit.study.sweep.spec import Column, StudySpec, Varied

LOADS = {
    "biglide": "f_y",
    "delta": "push",
    "orthoglide-table-7": "push",
    "hexapod-cubic": "push",
}
"""A load case of each robot."""
POSTURES = 10_000
_REPEATS = 3


@dataclass(frozen=True)
class Gradient:
    """Seconds of a processor for one geometry over its workspace, one thread."""

    robot: str
    parameters: int
    postures: int
    value: float
    """Loops closed, compliances, deflections and their mean."""
    both: float
    """The same with the derivatives by all parameters."""
    backwards: float
    """Of that, what is computed at each posture beside the value: adjoints of compliance and
    closure. The rest differentiates the robot file's formulas, however many postures there are."""
    first: float
    """s, the first time, with the adjoints' compilation."""

    @property
    def ratio(self) -> float:
        """Value and derivatives over the value alone."""
        return self.both / self.value


def measure(robot: str) -> Gradient:
    """Return what a robot's derivatives cost."""
    parameters = load_robot(robot).parameters.values()
    varied = tuple(Varied(p.name, (0.99 * p.value, 1.01 * p.value), p.unit) for p in parameters)
    column = Column("mean", "mean", "deflection_translation", LOADS[robot])
    spec = StudySpec("benchmark", robot, varied, 1, 0, POSTURES, ("refined",), 0, (column,))
    groups = Groups(Family(spec), "heyoka")
    engine = Engine(groups, make_anchors(groups), None)
    gradients, own = Gradients(engine), engine.family.own_values()
    with one_thread():
        before = time.perf_counter()
        gradients.at(own, [column])
        first = time.perf_counter() - before
        value = median_cost(lambda: engine.rows(own[:, None]), _REPEATS)
        both = median_cost(lambda: gradients.at(own, [column]), _REPEATS)
        postures = gradients.postures(own)
        if postures is None:
            raise RuntimeError(f"{robot} is not assembled")
        lower, ok = postures.compliances("refined")
        at = np.flatnonzero(ok)
        name, load = column.quantity, column.load
        backwards = cost(lambda: postures.quantity_slopes(name, load, "refined", at, lower[:, at]))
    return Gradient(robot, len(varied), at.size, value.cpu, both.cpu, backwards.cpu, first)
