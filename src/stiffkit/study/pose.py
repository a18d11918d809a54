"""One posture, looked at closely."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Status
from stiffkit.robot import DIRECTIONS, Robot
from stiffkit.stiffness import Model, PrincipalAxes, principal_axes
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
    wrenches = loads or {name: load.wrench for name, load in analysis.robot.loads.items()}
    if not postures.reached[0]:
        return _unreachable(analysis, model, at)
    found = stiffness.at(postures)
    status = Status(int(found.status[0]))
    # One posture can afford the general assembly, which also says what is free.
    exact = stiffness.assembly.at(postures.coordinates[:, 0])
    tool = postures.tool[:, 0]
    free = tuple(analysis.words(motion, tool) for motion in exact.free_motions)
    if status is Status.OK and free:
        # So near to singular that only the more precise of the two ways sees it.
        status = Status.SINGULAR
    k = _settled(exact.compliance, kinematics.length) if status is Status.OK else None
    return PoseResult(
        robot=analysis.robot.name,
        model=model,
        status=status,
        reason=_reason(status, free),
        tool=tool,
        joints=dict(zip(kinematics.joint_names, postures.joints[:, 0], strict=True)),
        compliance=k,
        stiffness=exact.stiffness if k is None or _yields(k, kinematics.length) else None,
        deflections={} if k is None else {name: k @ w for name, w in wrenches.items()},
        translation=None if k is None else principal_axes(k[:3, :3]),
        rotation=None if k is None else principal_axes(k[3:, 3:]),
        free_motions=free,
        method=stiffness.method,
    )


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
    asked = ", ".join(
        f"{d} = {round(at.get(d, home[DIRECTIONS.index(d)]), 12):.6g}"
        f" {'rad' if d.startswith('r') else 'm'}"
        for d in kinematics.asked
    )
    return f"the assembly mode of the home posture does not reach {asked}"


def _unreachable(analysis: Analysis, model: Model, at: Mapping[str, float]) -> PoseResult:
    return PoseResult(
        robot=analysis.robot.name,
        model=model,
        status=Status.UNREACHABLE,
        reason=out_of_reach(analysis, at),
        tool=np.full(6, np.nan),
        joints=dict.fromkeys(analysis.kinematics.joint_names, float("nan")),
        compliance=None,
        stiffness=None,
        deflections={},
        translation=None,
        rotation=None,
        free_motions=(),
        method=analysis.model(model).method,
    )


def _reason(status: Status, free: tuple[str, ...]) -> str:
    if status is Status.OK:
        return ""
    what = "; ".join(free) or "the compliance is larger than can be told from infinite"
    if status is Status.SINGULAR:
        return f"the posture is singular: {what}"
    return f"the robot does not hold its tool: {what}"
