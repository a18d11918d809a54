"""Where everything is at single postures, as frames in NumPy: for drawing, not for maps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffkit.kinematics.frames import joint_motion
from stiffkit.kinematics.tree import SpanningTree
from stiffkit.robot import BASE, Joint, Robot
from stiffkit.smallmat import vector
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Places:
    """Frames of one posture, world axes."""

    robot: Robot
    body: Mapping[str, Frame]
    """T_world_body of each body, the base among them."""

    @property
    def tool(self) -> Frame:
        """T_world_tool."""
        return self.body[self.robot.tool.body] @ self.robot.tool.T_body_tool

    def from_side(self, joint: Joint) -> Frame:
        """Return the joint frame on the ``from`` side, T_world_joint."""
        return self.body[joint.from_body] @ joint.T_from_joint

    def to_side(self, joint: Joint) -> Frame:
        """Return the joint frame on the ``to`` side, T_world_joint."""
        return self.body[joint.to_body] @ joint.T_to_joint


class Locator:
    """Finds the places of a robot, one posture at a time, in about a millisecond.

    A map goes through kernels, which compute many postures at once and know derivatives; joints
    move here by the very same function.
    """

    def __init__(self, tree: SpanningTree) -> None:
        """Take the mechanism."""
        self.tree = tree
        self._far_joint = [t.joint.T_to_joint.inverse for t in tree.joints]

    def at(self, q: Array) -> Places:
        """Return the places at coordinates (n,) of the tree, m and rad."""
        body = {BASE: Frame()}
        for t, T_joint_to in zip(self.tree.joints, self._far_joint, strict=True):
            T_from_to = t.joint.T_from_joint @ _moved(t.joint, q[t.coordinates]) @ T_joint_to
            step = T_from_to if t.forward else T_from_to.inverse
            body[t.child] = body[t.parent] @ step
        return Places(self.tree.robot, body)


def _moved(joint: Joint, q: Array) -> Frame:
    """Return the ``to`` side's joint frame in the ``from`` side's, at the joint's coordinates."""
    moved = joint_motion(joint, vector(q.tolist()))
    return Frame(np.array(moved.R, dtype=float), np.array(moved.p, dtype=float))
