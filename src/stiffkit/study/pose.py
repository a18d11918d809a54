"""One posture, looked at closely."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Postures, Status
from stiffkit.robot import DIRECTIONS, Robot
from stiffkit.stiffness import (
    Assembly,
    Model,
    PrincipalAxes,
    describe_free_motion,
    principal_axes,
)
from stiffkit.study.analysis import Analysis

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PoseResult:
    """What is known of one posture; SI, world axes, at the tool point, translation first."""

    robot: str
    model: Model
    status: Status
    reason: str
    """Why the status is not OK, "" if it is."""
    tool: Array
    """(6,), tool pose; NaN where unreachable."""
    joints: Mapping[str, float]
    """Joint coordinates by name, m and rad."""
    compliance: Array | None
    """(6, 6); None if it is not finite."""
    stiffness: Array | None
    """(6, 6); None where a direction is held rigidly, as in the simplified model."""
    deflections: Mapping[str, Array]
    """(6,) for each load case, m and rad."""
    translation: PrincipalAxes | None
    """Principal translational stiffness, N/m."""
    rotation: PrincipalAxes | None
    """Principal rotational stiffness, N m/rad."""
    free_motions: tuple[str, ...]
    """Motions of the tool that nothing holds, in words."""
    method: str
    """composition, jacobian or assembly."""

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON; what is not a finite number is null."""
        return {
            "robot": self.robot,
            "model": self.model,
            "status": self.status.word,
            "reason": self.reason or None,
            "tool": dict(zip(DIRECTIONS, plain(self.tool), strict=True)),
            "joints": {name: plain(value) for name, value in self.joints.items()},
            "compliance": plain(self.compliance),
            "stiffness": plain(self.stiffness),
            "deflections": {name: plain(d) for name, d in self.deflections.items()},
            "translational_stiffness": _axes(self.translation),
            "rotational_stiffness": _axes(self.rotation),
            "free_motions": list(self.free_motions),
            "units": {
                "compliance": "m/N, 1/N, rad/(N m)",
                "stiffness": "N/m, N, N m/rad",
                "deflections": "m, rad",
            },
            "method": self.method,
        }


def plain(value: Any) -> Any:
    """Return numbers or arrays as plain data for JSON; what is not finite is None."""
    if value is None:
        return None
    if isinstance(value, np.ndarray):
        return [plain(x) for x in value]
    return float(value) if np.isfinite(value) else None


def _axes(axes: PrincipalAxes | None) -> dict[str, Any] | None:
    if axes is None:
        return None
    return {"values": plain(axes.stiffness), "directions": plain(axes.directions.T)}


def analyse_pose(
    robot: Robot | Analysis,
    at: Mapping[str, float] | None = None,
    *,
    model: Model = "refined",
    loads: Mapping[str, Array] | None = None,
) -> PoseResult:
    """Return stiffness, compliance and deflections at one tool pose.

    ``at`` names tool coordinates (m, rad); independent ones that are missing are the home
    posture's. ``loads`` (wrenches (6,), N and N m) replace the robot's load cases. Raises PoseError
    for coordinates that do not fit the robot, AssemblyError if it cannot be put together.
    """
    at = at or {}
    analysis = robot if isinstance(robot, Analysis) else Analysis(robot, prefer=at)
    kinematics = analysis.kinematics
    postures = kinematics.solve_at(at)
    stiffness = analysis.model(model)
    if not postures.reached[0]:
        return unreachable_pose(analysis.robot, model, stiffness.method, out_of_reach(analysis, at))
    status = Status(int(stiffness.at(postures).status[0]))
    return judge_posture(stiffness.assembly, postures, status, stiffness.method, loads=loads)


def judge_posture(
    assembly: Assembly,
    posture: Postures,
    status: Status,
    method: str,
    *,
    loads: Mapping[str, Array] | None = None,
) -> PoseResult:
    """Return what is known of a posture that was reached, a batch of one.

    ``status`` is what the ``method`` by which maps are made found there. ``loads`` (wrenches (6,),
    N and N m) replace the robot's load cases.
    """
    robot, length = assembly.coordinates.tree.robot, assembly.length
    wrenches = loads or {name: load.wrench for name, load in robot.loads.items()}
    # One posture can afford the general assembly, which also says what is free.
    exact = assembly.at(posture.coordinates[:, 0])
    tool = posture.tool[:, 0]
    free = tuple(describe_free_motion(motion, tool, length) for motion in exact.free_motions)
    if status is Status.OK and free:
        # So near to singular that only the more precise of the two ways sees it.
        status = Status.SINGULAR
    k = _settled(exact.compliance, length) if status is Status.OK else None
    return PoseResult(
        robot=robot.name,
        model=assembly.coordinates.model,
        status=status,
        reason=_reason(status, free),
        tool=tool,
        joints=dict(zip(_joint_names(robot), posture.joints[:, 0], strict=True)),
        compliance=k,
        stiffness=exact.stiffness if k is None or _yields(k, length) else None,
        deflections={} if k is None else {name: k @ w for name, w in wrenches.items()},
        translation=None if k is None else principal_axes(k[:3, :3]),
        rotation=None if k is None else principal_axes(k[3:, 3:]),
        free_motions=free,
        method=method,
    )


def unreachable_pose(robot: Robot, model: Model, method: str, reason: str) -> PoseResult:
    """Return what is known of a tool pose that is not reached, for a ``reason`` in words."""
    return PoseResult(
        robot=robot.name,
        model=model,
        status=Status.UNREACHABLE,
        reason=reason,
        tool=np.full(6, np.nan),
        joints=dict.fromkeys(_joint_names(robot), float("nan")),
        compliance=None,
        stiffness=None,
        deflections={},
        translation=None,
        rotation=None,
        free_motions=(),
        method=method,
    )


def _joint_names(robot: Robot) -> list[str]:
    return [f"{joint.name}.{motion}" for joint in robot.joints.values() for motion in joint.motions]


_ROUNDING = 1e-14
"""Share of the largest entry of a compliance, unit-free, below which there is nothing."""


def _settled(compliance: Array | None, length: float) -> Array | None:
    """Return a compliance (6, 6) with zeros in place of what is rounding beside its largest entry.

    Directions that a model holds rigidly come out of the arithmetic as 1e-25 or the like.
    """
    if compliance is None:
        return None
    per_unit = np.abs(compliance) * _unit_free(length)
    return np.where(per_unit > _ROUNDING * per_unit.max(), compliance, 0.0)


def _yields(compliance: Array, length: float) -> bool:
    """Tell whether a compliance (6, 6) has an inverse: no direction is rigid."""
    values = np.linalg.eigvalsh(compliance * _unit_free(length))
    return bool(values[0] > _ROUNDING * values[-1])


def _unit_free(length: float) -> Array:
    scale = np.array([1.0 / length] * 3 + [1.0] * 3)
    return np.outer(scale, scale)


def out_of_reach(analysis: Analysis, at: Mapping[str, float]) -> str:
    """Return in words that the tool coordinates ``at`` (m, rad) cannot be reached."""
    kinematics = analysis.kinematics
    home = kinematics.home.tool[:, 0]
    return not_reached({d: at.get(d, home[DIRECTIONS.index(d)]) for d in kinematics.asked})


def not_reached(asked: Mapping[str, float]) -> str:
    """Return in words that the assembly mode does not reach tool coordinates (m, rad)."""
    coordinates = ", ".join(
        f"{d} = {round(value, 12) + 0.0:.6g} {'rad' if d.startswith('r') else 'm'}"
        for d, value in asked.items()
    )
    return f"the assembly mode of the home posture does not reach {coordinates}"


def _reason(status: Status, free: tuple[str, ...]) -> str:
    if status is Status.OK:
        return ""
    what = "; ".join(free) or "the compliance is larger than can be told from infinite"
    if status is Status.SINGULAR:
        return f"the posture is singular: {what}"
    return f"the robot does not hold its tool: {what}"
