"""What the studio draws of a mechanism: bodies made of triangles, and how each of them moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from stiffkit.robot import Link
from stiffkit.spatial.rotation import Array, skew
from stiffkit.studio.mesh import Indices, Mesh
from stiffkit.vibration import Moving

Role = Literal["link", "joint", "drive", "base", "tool"]
"""What a solid is there for; a drive is a driven joint, or the part of it that is seen."""


class Motion(Protocol):
    """How a solid's vertices follow the ports of its body."""

    def moved(self, moving: Moving, body: str, vertices: Array) -> Array:
        """Return the displacements (n, V, 3), m, world axes, of vertices (V, 3), body axes."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A body at rest, described in the frame of the body of the robot that carries it."""

    name: str
    """Such as "link foot", unique in a robot."""
    role: Role
    body: str
    """The robot's body whose frame its vertices are in."""
    mesh: Mesh
    motion: Motion
    elastic: bool = False
    """Whether it bends itself."""
    is_equivalent: bool = False
    """Whether the true shape is not known, and this one only stands for it."""

    @property
    def vertices(self) -> Array:
        """(V, 3), m, in the frame of `body`."""
        return self.mesh.vertices

    @property
    def faces(self) -> Indices:
        """(F, 3), indices of vertices; seen from outside, their corners run anticlockwise."""
        return self.mesh.faces


@dataclass(frozen=True)
class Ride:
    """The motion of what is rigidly attached to a port."""

    port: str

    def moved(self, moving: Moving, body: str, vertices: Array) -> Array:
        """Return the displacements (n, V, 3); see `Motion`."""
        T_world_body = moving.places.body[body]
        twist = moving.twist(body, self.port, T_world_body.position)
        return _rigid(twist[None], vertices @ T_world_body.rotation.T)


@dataclass(frozen=True, eq=False)
class Bend:
    """The motion of a bar whose sections follow the line between two ports."""

    link: Link
    port: str
    """At the other end than the base."""
    shares: Array
    """(s,), where there are sections, over the length."""
    section: NDArray[np.intp]
    """(V,), which of these each vertex belongs to."""

    def moved(self, moving: Moving, body: str, vertices: Array) -> Array:
        """Return the displacements (n, V, 3); see `Motion`."""
        spine = moving.spine(self.link, self.port)
        if spine is None:
            return Ride(self.port).moved(moving, body, vertices)
        tip = self.link.ports[self.port].position
        offsets = vertices - self.shares[self.section, None] * tip
        twists = spine.at(self.shares)[self.section]
        return _rigid(twists, offsets @ moving.places.body[body].rotation.T)


@dataclass(frozen=True, eq=False)
class Follow:
    """The motion of a part whose deformation under loads at its ports is known."""

    link: Link
    displacements: Array
    """(V, 3, 6(m-1)), m, link axes, under unit loads at the ports with the base held."""

    def moved(self, moving: Moving, body: str, vertices: Array) -> Array:
        """Return the displacements (n, V, 3); see `Motion`.

        What internal modes add is not known at the surface and left out.
        """
        T_world_body = moving.places.body[body]
        turn = np.kron(np.eye(2), T_world_body.rotation)
        base = moving.twist(body, "base", T_world_body.position)
        relative = []
        for port in self.link.other_ports:
            at = T_world_body.point(self.link.ports[port].position)
            carried = np.concatenate([_carried(base, at - T_world_body.position), base[3:]])
            relative.append(turn.T @ (moving.twist(body, port, at) - carried))
        loads = np.linalg.solve(np.asarray(self.link.compliance), np.concatenate(relative))
        bent = np.einsum("ij,vjk,kn->nvi", T_world_body.rotation, self.displacements, loads)
        return np.asarray(bent + _rigid(base[None], vertices @ T_world_body.rotation.T))


def _carried(twist: Array, arm: Array) -> Array:
    """Return the translations (3, n) of twists (6, n) at an arm (3,) from their point."""
    return np.asarray(twist[:3] - skew(arm) @ twist[3:])


def _rigid(twists: Array, arms: Array) -> Array:
    """Return the displacements (n, V, 3) at arms (V, 3) from where the twists hold.

    There is one twist (V, 6, n) for each arm, or one (1, 6, n) for all.
    """
    x, y, z = arms.T[..., None]
    a, b, c = twists[:, 3:].transpose(1, 0, 2)
    turned = np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)
    return np.asarray((twists[:, :3] + turned).transpose(2, 0, 1))
