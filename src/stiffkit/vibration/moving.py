"""How every part of a robot moves in some shapes: modes, or deflections under loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Places
from stiffkit.network import CoordinatesAtPosture
from stiffkit.robot import BASE, Link
from stiffkit.spatial import skew
from stiffkit.vibration.curve import bent_twists
from stiffkit.vibration.modes import ModalModel

Array = NDArray[np.float64]

SAME = 1e-6
"""Points nearer than this, over the robot's length, are one."""


@dataclass(frozen=True, eq=False)
class Spine:
    """The straight line between two ports of an elastic link, and how it moves; world axes."""

    base: Array
    """(3,), m, of the link's base."""
    tip: Array
    """(3,), m, of the other port."""
    stations: Array
    """(s,), m from the base."""
    twists: Array
    """(s, 6, n), m and rad, of the link at the stations."""

    @property
    def along(self) -> Array:
        """(3,), unit vector from base to tip."""
        return np.asarray((self.tip - self.base) / np.linalg.norm(self.tip - self.base))

    def at(self, shares: Array) -> Array:
        """Return the twists (m, 6, n) of sections at shares (m,) of the length."""
        return bent_twists(self.stations, self.twists, self.along, shares)


class Moving:
    """The motion of everything at one posture in n shapes, SI, world axes."""

    def __init__(self, model: ModalModel, places: Places, q: Array, shapes: Array) -> None:
        """Take coordinates (n_tree,) of the tree, the places there, and the shapes.

        The shapes (n_coordinates, n) are in the network's coordinates, as those of `Modes` are.
        """
        self.model = model
        self.places = places
        self.shapes = shapes
        self.tolerance = SAME * model.length
        """m; points nearer than this are one."""
        self._at: CoordinatesAtPosture = next(model.coordinates.at_each(q[:, None]))
        self._of_cluster = {node: M @ shapes for node, M in self._at.motion_of.items()}

    def twist(self, body: str, port: str, p: Array) -> Array:
        """Return the twist (6, n), at a point (3,), of what moves rigidly with a port."""
        if body == BASE:
            return np.zeros((6, self.shapes.shape[1]))
        twist = self._of_cluster[self.model.coordinates.network.cluster_of(body, port)]
        arm = p - self.places.tool.position
        translation = self.model.length * twist[:3] - skew(arm) @ twist[3:]
        return np.concatenate([translation, twist[3:]])

    def spine(self, link: Link, port: str) -> Spine | None:
        """Return the line from an elastic link's base to a port, bent by its static and own modes.

        What is between the ports of a link with more than two is not known: their twists say all.
        None for a line of no length.
        """
        T_world_link = self.places.body[link.name]
        base, tip = (T_world_link.point(link.ports[end].position) for end in (BASE, port))
        length = float(np.linalg.norm(tip - base))
        if length <= self.tolerance:
            return None
        twist_base = self.twist(link.name, BASE, base)
        twist_tip = self.twist(link.name, port, tip)
        element = self.model.bodies.elastic.get(link.name)
        if element is None or element.stations.size == 0:
            return Spine(base, tip, np.array([0.0, length]), np.stack([twist_base, twist_tip]))
        turn = np.kron(np.eye(2), T_world_link.rotation)
        own = [i for i, name in enumerate(self._at.names) if name == f"{link.name}.mode"]
        ports = [turn.T @ twist_base, turn.T @ twist_tip]
        inside = element.shapes @ np.concatenate([*ports, self.shapes[own]])
        twists = turn @ inside.reshape(element.stations.size, 6, -1)
        return Spine(base, tip, element.stations, twists)
