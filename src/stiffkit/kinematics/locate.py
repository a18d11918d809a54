"""Where bodies, joints and tool are, at given coordinates of the spanning tree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stiffkit.compiled import Constants
from stiffkit.kinematics.frames import (
    AXES,
    ScalarFrame,
    axis_rotation,
    exp_rotation_rate,
    joint_motion,
    read_frame,
)
from stiffkit.kinematics.tree import SpanningTree, TreeJoint
from stiffkit.robot import BASE, Joint, Robot
from stiffkit.smallmat import Vector, cross, identity, matmul, plus, scale, zeros
from stiffkit.spatial import Frame


def add_frame(constants: Constants, name: str, frame: Frame) -> None:
    """Store a constant frame, for `stiffkit.kinematics.frames.read_frame`."""
    constants.add(f"{name}.rotation", frame.rotation, rotation=True)
    constants.add(f"{name}.position", frame.position)


def add_geometry(constants: Constants, robot: Robot) -> None:
    """Store the constant frames of a robot: both sides of each joint, and the tool."""
    for joint in robot.joints.values():
        add_frame(constants, f"from:{joint.name}", joint.T_from_joint)
        add_frame(constants, f"to:{joint.name}", joint.T_to_joint)
    add_frame(constants, "tool", robot.tool.T_body_tool)


@dataclass(frozen=True, eq=False)
class Screws:
    """Unit motions at a point: velocity of the point, and angular velocity, world axes."""

    point: Vector
    axes: list[tuple[str, Vector]]
    """("t" or "r", direction (3,)) for each motion."""


class Located:
    """Frames in world axes; computed on demand, each once."""

    def __init__(self, tree: SpanningTree, constants: Constants, q: Vector, c: Vector) -> None:
        """Take the tree's coordinates ``q`` (SI) and the vector of constants ``c``."""
        self.tree = tree
        self._constants = constants
        self._q = q
        self._c = c
        self._bodies = {BASE: ScalarFrame(identity(3), zeros(3))}
        self._parents = {t.child: t for t in tree.joints}
        self._frames: dict[str, ScalarFrame] = {}
        self._screws: dict[str, Screws] = {}

    def constant(self, name: str) -> ScalarFrame:
        """Return a constant frame by its name among the constants."""
        return self._once(name, lambda: read_frame(self._constants, self._c, name))

    def _once(self, name: str, make: Callable[[], ScalarFrame]) -> ScalarFrame:
        if name not in self._frames:
            self._frames[name] = make()
        return self._frames[name]

    def coordinates(self, tree_joint: TreeJoint) -> Vector:
        """Return the coordinates of a tree joint."""
        return self._q[tree_joint.coordinates]

    def body(self, name: str) -> ScalarFrame:
        """Return T_world_body."""
        if name not in self._bodies:
            t = self._parents[name]
            motion = joint_motion(t.joint, self.coordinates(t))
            near, far = self.constant(f"from:{t.joint.name}"), self.constant(f"to:{t.joint.name}")
            forward = near @ motion @ far.inverse
            self._bodies[name] = self.body(t.parent) @ (forward if t.forward else forward.inverse)
        return self._bodies[name]

    def from_side(self, joint: Joint) -> ScalarFrame:
        """Return the joint frame on the ``from`` side, T_world_joint."""
        return self._once(
            f"world from:{joint.name}",
            lambda: self.body(joint.from_body) @ self.constant(f"from:{joint.name}"),
        )

    def to_side(self, joint: Joint) -> ScalarFrame:
        """Return the joint frame on the ``to`` side, T_world_joint."""
        return self._once(
            f"world to:{joint.name}",
            lambda: self.body(joint.to_body) @ self.constant(f"to:{joint.name}"),
        )

    @property
    def tool(self) -> ScalarFrame:
        """T_world_tool."""
        return self._once(
            "world tool", lambda: self.body(self.tree.robot.tool.body) @ self.constant("tool")
        )

    def screws(self, tree_joint: TreeJoint) -> Screws:
        """Return the motion of the child for a unit rate of each coordinate of a tree joint."""
        if tree_joint.joint.name not in self._screws:
            self._screws[tree_joint.joint.name] = self._unit_motions(tree_joint)
        return self._screws[tree_joint.joint.name]

    def _unit_motions(self, tree_joint: TreeJoint) -> Screws:
        joint, q = tree_joint.joint, self.coordinates(tree_joint)
        frame = self.from_side(joint)
        motion = joint_motion(joint, q)
        point = plus(matmul(frame.R, motion.p), frame.p)
        sign = 1.0 if tree_joint.forward else -1.0
        if joint.kind == "spherical":
            rates = matmul(frame.R, exp_rotation_rate(q))
            return Screws(point, [("r", scale(sign, rates[:, i])) for i in range(3)])
        axes: list[tuple[str, Vector]] = []
        R = frame.R
        for name, value in zip(joint.motions, q, strict=True):
            axis = R[:, AXES.index(name[-1])]
            axes.append((name[0] if name[0] == "r" else "t", scale(sign, axis)))
            if name.startswith("r"):
                R = matmul(R, axis_rotation(name[1], value))
        return Screws(point, axes)

    def directions(self, joint: Joint) -> tuple[Vector, dict[str, Vector]]:
        """Return the point (3,) of a joint and its six unit directions, for its statics.

        The directions x, y, z, rx, ry, rz are those of the ``from`` side's joint frame, except
        that a universal joint's second axis is fixed to the ``to`` side and its third direction is
        normal to both. The point is the origin of the ``to`` side's joint frame.
        """
        R = self.from_side(joint).R
        directions = {axis: R[:, i] for i, axis in enumerate(AXES)}
        directions |= {f"r{axis}": R[:, i] for i, axis in enumerate(AXES)}
        if joint.kind == "universal":
            first, second = joint.axes
            (third,) = set(AXES) - {first, second}
            b = self.to_side(joint).R[:, AXES.index(second)]
            directions[f"r{second}"] = b
            directions[f"r{third}"] = cross(directions[f"r{first}"], b)
        return self.to_side(joint).p, directions
