"""Where joints and tool sit on the bodies of a mechanism, for drawing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stiffkit.robot import BASE, Joint, Robot
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Seat:
    """A point of a body to which something is attached."""

    port: str
    point: Array
    """(3,), m, body axes."""


@dataclass(frozen=True, eq=False)
class Seats:
    """All places of a robot to which joints or the tool are attached."""

    of_body: dict[str, list[Seat]]
    """Those of the joints on each body, the base among them."""
    offset: dict[str, Array]
    """(3,), m, in the joint frame: where each joint is drawn instead of at its origin."""

    @staticmethod
    def of(robot: Robot) -> Seats:
        """Return the seats of a robot.

        A slide may be described anywhere, as all points of its carriage move alike. On a rigid
        carriage it is drawn where the carriage carries something.
        """
        offset = {joint.name: _offset(robot, joint) for joint in robot.joints.values()}
        of_body: dict[str, list[Seat]] = {name: [] for name in [BASE, *robot.links]}
        for joint in robot.joints.values():
            at = offset[joint.name]
            of_body[joint.from_body].append(Seat(joint.from_port, joint.T_from_joint.point(at)))
            of_body[joint.to_body].append(Seat(joint.to_port, joint.T_to_joint.point(at)))
        return Seats(of_body, offset)


def _offset(robot: Robot, joint: Joint) -> Array:
    """Return where a joint is drawn, in its frame."""
    sides = {joint.from_body: joint.T_from_joint, joint.to_body: joint.T_to_joint}
    carriage = next((body for body in sides if body != BASE), BASE)
    if (
        joint.kind != "prismatic"
        or BASE not in sides
        or robot.links[carriage].compliance is not None
    ):
        return np.zeros(3)
    carried = list(_carried(robot, carriage, joint))
    if not carried:
        return np.zeros(3)
    return sides[carriage].inverse.point(np.mean(carried, axis=0))


def _carried(robot: Robot, carriage: str, slide: Joint) -> Iterator[Array]:
    """Yield the origins (3,) of all but the slide itself that is attached to a carriage."""
    for joint in robot.joints.values():
        if joint is slide:
            continue
        if joint.from_body == carriage:
            yield joint.T_from_joint.position
        if joint.to_body == carriage:
            yield joint.T_to_joint.position
    if robot.tool.body == carriage:
        yield robot.tool.T_body_tool.position
