"""A mechanism as the studio shows it: its solids, where they are, and how they bend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffkit.kinematics import Locator, Places, SpanningTree
from stiffkit.robot import Robot
from stiffkit.spatial.rotation import Array
from stiffkit.studio.base_solids import base_solids
from stiffkit.studio.ellipsoid import Ellipsoid, ellipsoid
from stiffkit.studio.joint_solids import joint_solids
from stiffkit.studio.link_solids import link_solids
from stiffkit.studio.mesh import Mesh, ball, block, joined
from stiffkit.studio.proportions import Proportions
from stiffkit.studio.seats import Seat, Seats
from stiffkit.studio.solid import Ride, Solid
from stiffkit.studio.strokes import strokes
from stiffkit.vibration import ModalModel, Moving

__all__ = ["Anatomy", "Ellipsoid", "Mesh", "Solid", "ellipsoid", "suggested_scale"]

_SHOWN = 0.08
"""Largest displacement that is shown, about, over the robot's size."""


@dataclass(frozen=True, eq=False)
class Anatomy:
    """The solids of a robot with certain parameters."""

    solids: tuple[Solid, ...]
    proportions: Proportions
    _locator: Locator

    @staticmethod
    def of(tree: SpanningTree, home: Array, postures: Array | None = None) -> Anatomy:
        """Return the anatomy of a robot, given by its tree and coordinates (n,) there at home, SI.

        ``postures`` (n, P) say how far guides reach, such as those of the workspace; those that
        hold NaN do not count.
        """
        robot = tree.robot
        locator = Locator(tree)
        at_home = locator.at(home)
        seats = Seats.of(robot)
        proportions = Proportions.of(robot, at_home, seats)
        known = home[:, None]
        if postures is not None:
            known = np.hstack([known, postures[:, np.isfinite(postures).all(axis=0)]])
        reach = strokes(locator, known)
        solids = [
            *base_solids(robot, at_home.tool.position, proportions),
            *_links(robot, seats, proportions.gauge),
            *(
                solid
                for name, joint in robot.joints.items()
                for solid in joint_solids(
                    joint, seats.offset[name], proportions.radii[name], reach.get(name)
                )
            ),
            _tool(robot, proportions.gauge),
        ]
        return Anatomy(tuple(solids), proportions, locator)

    @property
    def size(self) -> float:
        """m, the diagonal of the box around joints and tool at home."""
        return self.proportions.size

    def places(self, q: Array) -> Places:
        """Return where bodies, joints and tool are at coordinates (n,) of the tree, SI."""
        return self._locator.at(q)

    def vertices(self, q: Array) -> list[Array]:
        """Return the vertices (V, 3) of each solid at coordinates (n,), m, world axes."""
        places = self.places(q)
        placed = []
        for solid in self.solids:
            frame = places.body[solid.body]
            placed.append(solid.vertices @ frame.rotation.T + frame.position)
        return placed

    def displacements(self, model: ModalModel, q: Array, shapes: Array) -> list[Array]:
        """Return the displacements (n, V, 3) of the vertices of each solid, m, world axes.

        ``shapes`` (n_coordinates, n) are in the coordinates of the ``model`` of this robot at
        coordinates ``q`` (n_tree,) of the tree: modes, or deflections under loads. What comes out
        is as large as they are.
        """
        moving = Moving(model, self.places(q), q, shapes)
        return [solid.motion.moved(moving, solid.body, solid.vertices) for solid in self.solids]


def suggested_scale(displacements: Sequence[Array], size: float) -> float:
    """Return a factor 1, 2 or 5 times a power of ten by which displacements are well seen.

    With it the largest of the displacements (..., 3) is about 8 % of ``size``, in their unit. It is
    1 if nothing moves.
    """
    largest = max(
        (float(np.linalg.norm(d, axis=-1).max(initial=0.0)) for d in displacements), default=0.0
    )
    if not (largest > 0.0 and np.isfinite(largest)):
        return 1.0
    wanted = np.log10(_SHOWN * size / largest)
    steps = np.log10([1.0, 2.0, 5.0, 10.0])
    decade = np.floor(wanted)
    return float(10.0**decade * [1, 2, 5, 10][int(np.argmin(np.abs(steps - (wanted - decade))))])


def _links(robot: Robot, seats: Seats, gauge: float) -> list[Solid]:
    tool = Seat(robot.tool.port, robot.tool.T_body_tool.position)
    return [
        solid
        for name, link in robot.links.items()
        for solid in link_solids(
            link, seats.of_body[name], tool if robot.tool.body == name else None, gauge
        )
    ]


def _tool(robot: Robot, gauge: float) -> Solid:
    """Return the mark of the tool point: a small ball with bars along the axes of the tool."""
    tool = robot.tool
    long, thin = 5.0 * gauge, 0.4 * gauge
    bars = [block(np.roll([long, thin, thin], i), tool.T_body_tool) for i in range(3)]
    mark = joined([ball(gauge, tool.T_body_tool.position), *bars])
    return Solid("tool", "tool", tool.body, mark, Ride(tool.port))
