"""Degrees of freedom: counted, numeric, and which of them move the tool."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics.closure import ClosureEquations, tool_jacobian
from stiffkit.kinematics.numeric import evaluate, null_space, rank
from stiffkit.robot import DIRECTIONS, Freedom

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Mobility:
    """The instantaneous degrees of freedom of a mechanism at one posture."""

    n_bodies: int
    """Moving bodies."""
    n_loops: int
    """Independent loops."""
    counted: int
    """Kutzbach's formula: 6 for each body, less what each joint blocks."""
    numeric: int
    """Dimension of the motions that the linearised closure allows."""
    tool: int
    """Dimension of the motions of the tool."""
    idle: int
    """Motions that neither move the tool nor any driven joint, such as a rod's spin."""

    @property
    def over_constraint(self) -> int:
        """Number of closure equations that say nothing new."""
        return self.numeric - self.counted

    @staticmethod
    def of(loops: ClosureEquations, q: Array) -> Mobility:
        """Return the mobility at coordinates ``q`` (n,) of the tree."""
        tree = loops.tree
        robot = tree.robot
        free = null_space(evaluate(loops, q, np.empty(0)).jacobian)
        tool = tool_jacobian(loops, q) @ free
        driven = free[_driven_rows(loops)]
        blocked = sum(6 - len(joint.motions) for joint in robot.joints.values())
        return Mobility(
            n_bodies=len(robot.links),
            n_loops=len(tree.chords),
            counted=6 * len(robot.links) - blocked,
            numeric=free.shape[1],
            tool=rank(tool),
            idle=free.shape[1] - rank(np.concatenate([tool, driven])),
        )


def _driven_rows(loops: ClosureEquations) -> list[int]:
    rows = []
    for t in loops.tree.joints:
        for offset, motion in enumerate(t.joint.motions):
            if t.joint.freedoms[DIRECTIONS.index(motion)] is Freedom.DRIVEN:
                rows.append(t.coordinates.start + offset)
    return rows


def controllable(loops: ClosureEquations, q: Array, candidates: Sequence[str]) -> list[str]:
    """Return the tool coordinates, taken in order, that can be chosen independently at ``q``."""
    free = null_space(evaluate(loops, q, np.empty(0)).jacobian)
    rates = tool_jacobian(loops, q, rotation_vector_rates=True) @ free
    chosen: list[str] = []
    for name in candidates:
        rows = [DIRECTIONS.index(d) for d in [*chosen, name]]
        if rank(rates[rows]) == len(rows):
            chosen.append(name)
    return chosen
