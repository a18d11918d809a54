"""What the over-constraints of a mechanism do for its stiffness: the Orthoglide without them.

Kutzbach counts -9 degrees of freedom for the Orthoglide, and it has 3: twelve constraints too many.
Each planar parallelogram holds three directions twice: the right bar on a ball joint and a
universal joint, instead of two revolutes, holds each of them once. Each leg keeps two rotations of
the platform, six for three: a universal joint at each wrist leaves each leg one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stiffkit.robot import Joint, Robot, with_freedoms
from stiffkit.spatial.rotation import Array
from stiffkit.study import Analysis, analyse_pose

RELEASES = {
    "pin_near_right_": ("spherical", ()),
    "pin_far_right_": ("universal", ("z", "y")),
    "wrist_": ("universal", ("y", "x")),
}
"""By the begin of a joint's name: the kind and axes that it has instead."""


@dataclass(frozen=True, eq=False)
class Softening:
    """How much softer a posture is without over-constraints."""

    at: Mapping[str, float]
    """Tool coordinates, m."""
    ratios: Array
    """(6,), compliance without them over that with them, along x, y, z and about x, y, z."""
    least: float
    """The same, in the stiffest combination of directions: never below one."""
    most: float
    """The same, in the softest."""


@dataclass(frozen=True, eq=False)
class OverConstraint:
    """The count of constraints, and what follows from removing those that are too many."""

    counted: tuple[int, int]
    """Kutzbach's mobility with and without over-constraints."""
    mobility: tuple[int, int]
    """True mobility with and without."""
    postures: tuple[Softening, ...]

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "counted": list(self.counted),
            "mobility": list(self.mobility),
            "postures": [
                {
                    "at": dict(one.at),
                    "ratios": one.ratios.tolist(),
                    "least": one.least,
                    "most": one.most,
                }
                for one in self.postures
            ],
        }


def without_over_constraints(robot: Robot) -> Robot:
    """Return an Orthoglide whose mobility is what Kutzbach counts; every leg moves as before."""
    joints = {name: _released(name, joint) for name, joint in robot.joints.items()}
    return replace(robot, joints=joints)


def study_over_constraint(robot: Robot, places: tuple[float, ...]) -> OverConstraint:
    """Return what an Orthoglide loses at places (m) along the diagonal of its cube."""
    free = without_over_constraints(robot)
    before, after = (Analysis(one).kinematics.mobility for one in (robot, free))
    return OverConstraint(
        (before.counted, after.counted),
        (before.numeric, after.numeric),
        tuple(_softening(robot, free, dict.fromkeys("xyz", place)) for place in places),
    )


def _softening(robot: Robot, free: Robot, at: dict[str, float]) -> Softening:
    k, softer = (analyse_pose(one, at).compliance for one in (robot, free))
    if k is None or softer is None:
        raise ValueError(f"the robot has no compliance at {at}")
    root = np.linalg.inv(np.linalg.cholesky(k))
    shares = np.linalg.eigvalsh(root @ softer @ root.T)
    return Softening(at, np.diag(softer) / np.diag(k), float(shares[0]), float(shares[-1]))


def _released(name: str, joint: Joint) -> Joint:
    for prefix, (kind, axes) in RELEASES.items():
        if name.startswith(prefix):
            return with_freedoms(replace(joint, kind=kind, axes=axes), drives={}, springs={})
    return joint
