"""Compliances and free directions of links and joints, at the tool point, in world axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Constants
from stiffkit.kinematics import Located
from stiffkit.kinematics.locate import add_frame, add_geometry
from stiffkit.robot import DIRECTIONS, Freedom, Joint, Link, Robot
from stiffkit.smallmat import (
    Matrix,
    Scalar,
    Vector,
    congruence,
    cross,
    matmul,
    minus,
    plus,
    scale,
    skew,
    subtract,
    symmetric,
    zeros,
)


def add_elasticity(constants: Constants, robot: Robot, length: float) -> None:
    """Store the geometry, the compliances of links, joints and drives, and a typical length."""
    add_geometry(constants, robot)
    constants.add("length", np.array([length]))
    for name, link in robot.links.items():
        if link.compliance is not None:
            for port in link.other_ports:
                add_frame(constants, f"port:{name}.{port}", link.ports[port])
            constants.add_symmetric(f"compliance:{name}", link.compliance)
    for name, joint in robot.joints.items():
        constants.add(f"compliance of joint:{name}", joint_compliance(joint))


def joint_compliance(joint: Joint) -> NDArray[np.float64]:
    """Return the compliance (6,) of a joint's directions, 0 where passive or blocked; SI."""
    compliance = np.zeros(6)
    for i, (freedom, stiffness) in enumerate(zip(joint.freedoms, joint.stiffness, strict=True)):
        if freedom in (Freedom.DRIVEN, Freedom.ELASTIC):
            compliance[i] = 1.0 / stiffness
    return compliance


@dataclass(frozen=True)
class LooseDirection:
    """A direction of a joint that is passive, or has a compliance."""

    name: str
    """Such as "elbow_left.rz"."""
    index: int
    """Among the six directions of the joint."""
    freedom: Freedom
    moves: bool
    """Whether the direction is one of the joint's motions."""

    @property
    def turns(self) -> bool:
        """Whether the direction is a rotation."""
        return self.index >= 3


def loose_directions(joint: Joint) -> list[LooseDirection]:
    """Return the directions of a joint in which its sides can move or deflect."""
    return [
        LooseDirection(f"{joint.name}.{name}", i, joint.freedoms[i], name in joint.motions)
        for i, name in enumerate(DIRECTIONS)
        if joint.freedoms[i] is Freedom.PASSIVE
        or (joint.freedoms[i] is not Freedom.BLOCKED and np.isfinite(joint.stiffness[i]))
    ]


@dataclass(frozen=True, eq=False)
class Looseness:
    """A loose direction of a joint at a posture."""

    direction: LooseDirection
    twist: Vector
    """Unit twist (6,) at the tool point, world axes."""
    compliance: Scalar
    """m/N or rad/(N m); 0 where passive."""


class PartsAtTool:
    """Makes the parts of a posture, referred to the tool point."""

    def __init__(self, located: Located, constants: Constants, c: Vector) -> None:
        """Take frames in world axes and the constants that `add_elasticity` stored."""
        self.located = located
        self._constants = constants
        self._c = c
        self._point = located.tool.p

    @property
    def length(self) -> Scalar:
        """The robot's typical length, m."""
        return self._constants.read(self._c, "length")[0]

    def link_compliance(self, link: Link, port: str) -> Matrix:
        """Return the compliance (6, 6) of a port of an elastic link, under loads there."""
        R = self.located.body(link.name).R
        return _moved(self._given(link, port, port), R, self._arm(link, port))

    def link_coupling(self, link: Link, port: str, other: str) -> Matrix:
        """Return the compliance (6, 6) of a port under loads at another port of the same link."""
        transforms = self.from_port(link, port), self.from_port(link, other)
        return matmul(matmul(transforms[0], self._given(link, port, other)), transforms[1].T)

    def whole_compliance(self, link: Link) -> Matrix:
        """Return the compliance (6p, 6p) of the p ports of an elastic link but its base."""
        ports = link.other_ports
        S = zeros(6 * len(ports), 6 * len(ports))
        for i, port in enumerate(ports):
            rows = slice(6 * i, 6 * i + 6)
            S[rows, rows] = self.link_compliance(link, port)
            for j, other in enumerate(ports[:i]):
                columns = slice(6 * j, 6 * j + 6)
                S[rows, columns] = self.link_coupling(link, port, other)
                S[columns, rows] = S[rows, columns].T
        return S

    def from_port(self, link: Link, port: str) -> Matrix:
        """Return the 6x6 matrix from a twist at a link's port, link axes, to the tool point."""
        R = self.located.body(link.name).R
        T = zeros(6, 6)
        T[:3, :3] = T[3:, 3:] = R
        T[:3, 3:] = scale(-1.0, matmul(skew(self._arm(link, port)), R))
        return T

    def _given(self, link: Link, port: str, other: str) -> Matrix:
        """Return the block (6, 6) of a link's compliance that stands in its data."""
        S = self._constants.read_symmetric(self._c, f"compliance:{link.name}")
        i, j = link.other_ports.index(port), link.other_ports.index(other)
        return S[6 * i : 6 * i + 6, 6 * j : 6 * j + 6]

    def _arm(self, link: Link, port: str) -> Vector:
        """Return the way (3,) from a link's port to the tool point."""
        body = self.located.body(link.name)
        place = plus(matmul(body.R, self.located.constant(f"port:{link.name}.{port}").p), body.p)
        return minus(self._point, place)

    def joint_looseness(self, joint: Joint) -> list[Looseness]:
        """Return what a joint lets happen, in the order of `loose_directions`."""
        point, axes = self.located.directions(joint)
        arm = minus(self._point, point)
        compliance = self._constants.read(self._c, f"compliance of joint:{joint.name}")
        return [
            Looseness(
                direction,
                _twist(DIRECTIONS[direction.index], axes[DIRECTIONS[direction.index]], arm),
                compliance[direction.index],
            )
            for direction in loose_directions(joint)
        ]


def _twist(name: str, axis: Vector, arm: Vector) -> Vector:
    twist = zeros(6)
    if name.startswith("r"):
        twist[:3], twist[3:] = cross(axis, arm), axis
    else:
        twist[:3] = axis
    return twist


def _moved(S: Matrix, R: Matrix, arm: Vector) -> Matrix:
    """Return a compliance turned by R, and referred to the point that is ``arm`` away."""
    tt, rt, rr = S[:3, :3], S[3:, :3], S[3:, 3:]
    tt, rr = congruence(R, tt), congruence(R, rr)
    rt = matmul(matmul(R, rt), R.T)
    W = skew(arm)
    # With t' = t - W phi, and W^T = -W:
    rt_moved = plus(rt, matmul(rr, W))
    Wrt, W_moved = matmul(W, rt), matmul(W, rt_moved)
    moved = zeros(6, 6)
    moved[3:, 3:] = rr
    moved[3:, :3] = rt_moved
    moved[:3, 3:] = rt_moved.T
    moved[:3, :3] = symmetric(
        3, lambda i, j: subtract(subtract(tt[i, j], Wrt[j, i]), W_moved[i, j])
    )
    return moved
