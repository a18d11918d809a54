"""Where bodies, joints and tool are at one posture, and which way joints yield."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffkit.compiled import BatchFunction, Constants, Kernel
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.kinematics.locate import add_geometry
from stiffkit.robot import BASE, DIRECTIONS
from stiffkit.smallmat import Vector, vector
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array


class Places:
    """Frames and joint directions of one posture, world axes."""

    def __init__(self, tree: SpanningTree, q: Array) -> None:
        """Take coordinates (n,) of the tree, SI."""
        robot = tree.robot
        constants = Constants()
        add_geometry(constants, robot)

        def places(q: Vector, c: Vector) -> Vector:
            located = Located(tree, constants, q, c)
            values = []
            for frame in [*map(located.body, robot.links), located.tool]:
                values += [*frame.R.ravel(), *frame.p]
            for joint in robot.joints.values():
                point, axes = located.directions(joint)
                values += [*point, *(x for name in DIRECTIONS for x in axes[name])]
            return vector(values)

        kernel = Kernel("verified places", places, tree.n_coordinates, constants, tree.topology)
        values = BatchFunction(kernel, "numpy")(q[:, None])[:, 0]
        n = 12 * (len(robot.links) + 1)
        frames = [Frame(row[:9].reshape(3, 3), row[9:]) for row in values[:n].reshape(-1, 12)]
        self.body: Mapping[str, Frame] = {
            BASE: Frame(),
            **dict(zip(robot.links, frames, strict=False)),
        }
        """T_world_body of each body."""
        self.tool: Frame = frames[-1]
        """T_world_tool."""
        joints = values[n:].reshape(-1, 7, 3)
        self.joint_point: Mapping[str, Array] = dict(zip(robot.joints, joints[:, 0], strict=True))
        """(3,), m, where the two sides of each joint meet."""
        self.joint_directions: Mapping[str, Array] = {
            name: _unit_twists(axes) for name, axes in zip(robot.joints, joints[:, 1:], strict=True)
        }
        """(6, 6), the columns are twists at the joint's point for a unit of each direction."""


def _unit_twists(axes: Array) -> Array:
    """Return the unit twists (6, 6) of the six axes (6, 3) of a joint."""
    twists = np.zeros((6, 6))
    twists[:3, :3] = axes[:3].T
    twists[3:, 3:] = axes[3:].T
    return twists
