"""Compliances computed another way: from the world frames of a mechanism, with NumPy alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from stiffkit.kinematics.numeric import one_thread
from stiffkit.robot import BASE, DIRECTIONS, Freedom, Joint
from stiffkit.spatial import Frame, shift_compliance, twist_shift
from tests.properties.mechanisms import LENGTH, Mechanism

Array = NDArray[np.float64]

UNIT_FREE = np.diag([1.0 / LENGTH] * 3 + [1.0] * 3)
"""Twist in SI to twist with lengths over the mechanism's size."""


def joint_frames(mechanism: Mechanism, joint: Joint) -> tuple[Frame, Frame]:
    """Return T_world_joint of the ``from`` and of the ``to`` side."""
    T_world = mechanism.T_world
    return (
        T_world[joint.from_body] @ joint.T_from_joint,
        T_world[joint.to_body] @ joint.T_to_joint,
    )


def joint_axes(mechanism: Mechanism, joint: Joint) -> Array:
    """Return the six unit directions of a joint as columns (3, 6), world axes."""
    near, far = joint_frames(mechanism, joint)
    turns = near.rotation.copy()
    if joint.kind == "universal":
        first, second = ("xyz".index(axis) for axis in joint.axes)
        turns[:, second] = far.rotation[:, second]
        turns[:, 3 - first - second] = np.cross(turns[:, first], turns[:, second])
    return np.hstack([near.rotation, turns])


def joint_twist(mechanism: Mechanism, joint: Joint, direction: str, point: Array) -> Array:
    """Return the twist (6,) at a point for a unit motion of a joint, ``to`` against ``from``."""
    _, far = joint_frames(mechanism, joint)
    axis = joint_axes(mechanism, joint)[:, DIRECTIONS.index(direction)]
    if direction.startswith("r"):
        return np.concatenate([np.cross(axis, point - far.position), axis])
    return np.concatenate([axis, np.zeros(3)])


def leg_elements(mechanism: Mechanism, leg: tuple[str, ...]) -> tuple[Array, Array]:
    """Return the compliance S (6, 6) and the passive twists J (6, q) of a leg without sub-loops.

    World axes, at the tool point: Briot et al. 2009, eq. 4.
    """
    robot, point = mechanism.robot, mechanism.T_world_tool.position
    S, passive = np.zeros((6, 6)), [np.zeros((6, 0))]
    for name in leg:
        if name in robot.links:
            link = robot.links[name]
            if link.compliance is not None:
                T_world_link = mechanism.T_world[name]
                tip = T_world_link @ link.ports["tip"]
                at_tool = Frame(T_world_link.rotation, tip.position - point)
                S += shift_compliance(link.compliance, at_tool)
            continue
        joint = robot.joints[name]
        for direction, freedom, c in zip(DIRECTIONS, joint.freedoms, joint.stiffness, strict=True):
            twist = joint_twist(mechanism, joint, direction, point)
            if freedom is Freedom.PASSIVE:
                passive.append(twist[:, None])
            elif freedom is not Freedom.BLOCKED:
                S += np.outer(twist, twist) / c
    return S, np.hstack(passive)


def leg_stiffness(mechanism: Mechanism, leg: tuple[str, ...]) -> Array:
    """Return the stiffness (6, 6) of a leg: the block of [[S, J], [J^T, 0]]^-1.

    Briot et al. 2009, eqs 3 and 9; the pseudo-inverse, for passive joints that are redundant.
    """
    S, J = leg_elements(mechanism, leg)
    S, J = UNIT_FREE @ S @ UNIT_FREE, UNIT_FREE @ J
    size = np.linalg.norm(S)
    q = J.shape[1]
    blocks = np.block([[S / size, J], [J.T, np.zeros((q, q))]])
    K = np.linalg.pinv(blocks, rcond=1e-12, hermitian=True)[:6, :6] / size
    return np.asarray(UNIT_FREE @ K @ UNIT_FREE)


def compliance_by_nodes(mechanism: Mechanism) -> Array:
    """Return the tool's compliance (6, 6), SI, world axes, at the tool point.

    Unknowns are the twists of all rigid bodies and of both ends of elastic links, at the world's
    origin. Links and springs add their energy, and blocked directions are constraints, fulfilled by
    a basis of what they allow.
    """
    robot = mechanism.robot
    nodes: dict[tuple[str, str], int] = {}

    def node(body: str, port: str) -> int | None:
        if body == BASE:
            return None
        elastic = robot.links[body].compliance is not None
        return nodes.setdefault((body, "tip" if elastic and port == "tip" else "base"), len(nodes))

    springs: list[tuple[int | None, int | None, Array]] = []
    constraints: list[tuple[int | None, int | None, Array]] = []
    for name, link in robot.links.items():
        if link.compliance is not None:
            T_world_link = mechanism.T_world[name]
            tip = T_world_link @ link.ports["tip"]
            turn = np.kron(np.eye(2), T_world_link.rotation.T)
            root = np.linalg.inv(np.linalg.cholesky(UNIT_FREE @ link.compliance @ UNIT_FREE))
            strain = root @ UNIT_FREE @ turn @ twist_shift(tip.position)
            springs.append((node(name, "base"), node(name, "tip"), strain))
    for joint in robot.joints.values():
        ends = node(joint.from_body, joint.from_port), node(joint.to_body, joint.to_port)
        axes = joint_axes(mechanism, joint)
        _, far = joint_frames(mechanism, joint)
        read = np.zeros((6, 6))
        read[:3, :3], read[3:, 3:] = axes[:, :3].T, axes[:, 3:].T
        relative = read @ twist_shift(far.position)
        for row, freedom, c in zip(relative, joint.freedoms, joint.stiffness, strict=True):
            if freedom is Freedom.BLOCKED:
                constraints.append((*ends, row[None]))
            elif freedom is not Freedom.PASSIVE:
                springs.append((*ends, np.sqrt(c) * row[None]))
    tool = node(robot.tool.body, robot.tool.port)

    def spread(parts: list[tuple[int | None, int | None, Array]]) -> Array:
        rows = [np.zeros((0, 6 * len(nodes)))]
        for a, b, block in parts:
            row = np.zeros((block.shape[0], 6 * len(nodes)))
            for end, sign in ((a, -1.0), (b, 1.0)):
                if end is not None:
                    row[:, 6 * end : 6 * end + 6] += sign * block
            rows.append(row)
        return np.vstack(rows)

    with one_thread():
        allowed = null_space(spread(constraints), rcond=1e-9)
        strains = spread(springs) @ allowed
        at_tool = spread([(None, tool, twist_shift(mechanism.T_world_tool.position))]) @ allowed
        # With the energy |strains x|^2 / 2 the deflection under w is half half^T w.
        half = at_tool @ np.linalg.pinv(strains, rcond=1e-10)
    return np.asarray(half @ half.T)
