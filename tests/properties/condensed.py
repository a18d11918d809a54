"""Links with three ports that are made of simpler ones: two links in one, a link with a spring."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.link.given_superelement import given_superelement
from stiffkit.link.ports import carried, places_of
from stiffkit.link.superelement import Superelement, consistent_superelement
from stiffkit.robot import Joint, Link, Robot
from stiffkit.spatial import Frame, twist_shift

Array = NDArray[np.float64]

LEFT, RIGHT = "left", "right"


def with_superelements(robot: Robot, n_modes: int = 4) -> Robot:
    """Return a robot whose beams are superelements, each with its lowest modes."""
    links = {name: _reduced(link, n_modes) for name, link in robot.links.items()}
    return replace(robot, links=links)


def _reduced(link: Link, n_modes: int) -> Link:
    if link.line is None:
        return link
    return replace(link, superelement=consistent_superelement(link.line, 4, n_modes), line=None)


def condensed(robot: Robot, weld: str) -> Robot:
    """Return a robot without a fixed joint: the two links with bases that it joins are one.

    The link is called as the one on the joint's ``from`` side, whose base and axes it has; its port
    "left" is that one's tip and "right" the other's.
    """
    joint = robot.joints[weld]
    first, second = robot.links[joint.from_body], robot.links[joint.to_body]
    T_first_second = joint.T_from_joint @ joint.T_to_joint.inverse
    links = {name: link for name, link in robot.links.items() if name != second.name}
    links[first.name] = _merged(first, second, T_first_second)
    joints = {
        name: _moved(other, first.name, second.name, T_first_second)
        for name, other in robot.joints.items()
        if name != weld
    }
    tool = robot.tool
    if tool.body in (first.name, second.name):
        side = LEFT if tool.body == first.name else RIGHT
        frame = T_first_second @ tool.T_body_tool if side == RIGHT else tool.T_body_tool
        port = tool.port if tool.port == "base" else side
        tool = replace(tool, body=first.name, port=port, T_body_tool=frame)
    home = replace(robot.home, joints={k: v for k, v in robot.home.joints.items() if k in joints})
    return replace(robot, links=links, joints=joints, tool=tool, home=home)


def _moved(joint: Joint, first: str, second: str, T_first_second: Frame) -> Joint:
    """Return a joint of a link that is now part of another one, attached there."""
    if joint.from_body == first and joint.from_port == "tip":
        joint = replace(joint, from_port=LEFT)
    if joint.to_body == first and joint.to_port == "tip":
        joint = replace(joint, to_port=LEFT)
    if joint.from_body == second:
        port = RIGHT if joint.from_port == "tip" else "base"
        frame = T_first_second @ joint.T_from_joint
        joint = replace(joint, from_body=first, from_port=port, T_from_joint=frame)
    if joint.to_body == second:
        port = RIGHT if joint.to_port == "tip" else "base"
        frame = T_first_second @ joint.T_to_joint
        joint = replace(joint, to_body=first, to_port=port, T_to_joint=frame)
    return joint


def _merged(first: Link, second: Link, T_first_second: Frame) -> Link:
    ports = {
        "base": Frame(),
        LEFT: first.ports["tip"],
        RIGHT: T_first_second @ second.ports["tip"],
    }
    turn = np.kron(np.eye(2), T_first_second.rotation)
    compliance = np.zeros((12, 12))
    compliance[:6, :6] = np.asarray(first.compliance)
    compliance[6:, 6:] = turn @ np.asarray(second.compliance) @ turn.T
    link = Link(first.name, ports, compliance=compliance, origin="two in one")
    one, other = first.superelement, second.superelement
    if one is None or other is None:
        return link
    n, m = one.mode_stiffness.size, other.mode_stiffness.size
    # Coordinates of each element by those of both: base, left, right, modes of one, of the other.
    of_one, of_other = np.zeros((12 + n, 18 + n + m)), np.zeros((12 + m, 18 + n + m))
    of_one[:12, :12] = np.eye(12)
    of_one[12:, 18 : 18 + n] = np.eye(n)
    of_other[:6, :6] = turn.T @ twist_shift(T_first_second.position)
    of_other[6:12, 12:18] = turn.T
    of_other[12:, 18 + n :] = np.eye(m)
    element = Superelement(
        compliance,
        np.concatenate([one.mode_stiffness, other.mode_stiffness]),
        of_one.T @ one.mass @ of_one + of_other.T @ other.mass @ of_other,
        "two links in one",
    )
    return replace(link, superelement=element)


def sprung(robot: Robot, name: str, spring: Array) -> tuple[Robot, Robot]:
    """Return a robot whose link has a spring (6, 6) at its base, apart from it and inside of it.

    Inside, the spring couples all other ports of the link, and what was its base is a coordinate
    that its superelement keeps.
    """
    link = robot.links[name]
    stem = Link(f"{name}_stem", {"base": Frame(), "tip": Frame()}, compliance=spring)
    weld = replace(
        next(joint for joint in robot.joints.values() if joint.kind == "fixed"),
        name=f"{name}_weld",
        from_body=stem.name,
        from_port="tip",
        T_from_joint=Frame(),
        to_body=name,
        to_port="base",
        T_to_joint=Frame(),
    )
    joints = {key: _onto(joint, name, stem.name) for key, joint in robot.joints.items()}
    links = {**robot.links, stem.name: stem}
    apart = replace(robot, links=links, joints={**joints, weld.name: weld})
    within = replace(robot, links={**robot.links, name: _with_spring(link, spring)})
    return apart, within


def _onto(joint: Joint, link: str, stem: str) -> Joint:
    """Return a joint at the base of a link, moved to the base of what the link stands on."""
    if (joint.from_body, joint.from_port) == (link, "base"):
        joint = replace(joint, from_body=stem)
    if (joint.to_body, joint.to_port) == (link, "base"):
        joint = replace(joint, to_body=stem)
    return joint


def _with_spring(link: Link, spring: Array) -> Link:
    others = {port: link.ports[port] for port in link.other_ports}
    carry = carried(places_of(others))
    compliance = np.asarray(link.compliance) + carry @ spring @ carry.T
    element = link.superelement
    if element is None:
        return replace(link, compliance=compliance)
    # Coordinates: the new base, the other ports, the modes, and the old base among them.
    n = len(element.mass)
    order = np.r_[n : n + 6, 6:n, 0:6]
    relative = np.hstack([np.eye(6), np.zeros((6, n - 6)), -np.eye(6)])
    K, M = relative.T @ np.linalg.solve(spring, relative), np.zeros((n + 6, n + 6))
    K[:n, :n] += element.stiffness(places_of(others))
    M[:n, :n] += element.mass
    K, M = K[np.ix_(order, order)], M[np.ix_(order, order)]
    reduced = given_superelement(K, M, len(link.ports))
    return replace(
        link, compliance=compliance, superelement=replace(reduced, compliance=compliance)
    )
