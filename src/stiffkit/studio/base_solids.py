"""The base as solids: a foot under each joint that stands on it, and bars that join the feet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stiffkit.robot import BASE, Joint, Robot
from stiffkit.spatial.rotation import Array
from stiffkit.studio.mesh import block, cylinder, frame_along, joined, rounded_hull
from stiffkit.studio.proportions import Proportions
from stiffkit.studio.solid import Ride, Solid
from stiffkit.vibration.curve import outline

_HIGH = 1.7
"""Height of a foot over the radius of the joint that stands on it."""

_SAME = 1e-6
"""Points nearer than this, over the robot's size, are one."""


def base_solids(robot: Robot, tool: Array, proportions: Proportions) -> Iterator[Solid]:
    """Yield the solids of the base; ``tool`` (3,), m, is where the tool is at home."""
    standing = {
        joint: frame.position
        for joint in robot.joints.values()
        # What slides stands on its guide.
        if joint.kind != "prismatic"
        for body, frame in (
            (joint.from_body, joint.T_from_joint),
            (joint.to_body, joint.T_to_joint),
        )
        if body == BASE
    }
    if not standing:
        return
    down = _outwards(list(standing), np.array(list(standing.values())), tool)
    soles = []
    for joint, point in standing.items():
        r = proportions.radii[joint.name]
        sole = point + _HIGH * r * down
        leg = cylinder(0.7 * r, _HIGH * r, frame_along((point + sole) / 2.0, down))
        plate = block([0.5 * r, 3.4 * r, 3.4 * r], frame_along(sole, down))
        yield Solid(f"base under {joint.name}", "base", BASE, joined([leg, plate]), Ride(BASE))
        soles.append(sole)
    lines = outline(soles, _SAME * proportions.size)
    thickness = np.full(3, 0.5 * proportions.gauge)
    bars = [
        rounded_hull(line[i : i + 2], thickness) for line in lines for i in range(len(line) - 1)
    ]
    if bars:
        yield Solid("base", "base", BASE, joined(bars), Ride(BASE))


def _outwards(joints: Sequence[Joint], points: Array, tool: Array) -> Array:
    """Return the direction (3,) in which the base lies behind the joints that stand on it.

    Square to the plane of the joints' places, away from the tool; where they lie on a line, along
    the axis of their revolutes; downwards where nothing decides.
    """
    centred = points - points.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=True)
    size = float(np.linalg.norm(points - tool, axis=1).max())
    if len(points) > 2 and sizes[1] > 0.01 * size:
        normal = axes[2]
    else:
        revolutes = [joint for joint in joints if joint.kind == "revolute"]
        if not revolutes:
            return np.array([0.0, 0.0, -1.0])
        frame = (
            revolutes[0].T_to_joint if revolutes[0].to_body == BASE else revolutes[0].T_from_joint
        )
        normal = frame.rotation[:, "xyz".index(revolutes[0].axes[0])]
    away = float(normal @ (points.mean(axis=0) - tool))
    if abs(away) < 0.05 * size:
        # Of two sides the lower one, or whichever is not along an axis.
        away = -float(normal[int(np.argmax(np.abs(normal)))])
    return np.asarray(np.sign(away) * normal)
