"""Mode shapes as geometry: where a mechanism's lines are at rest, and how each mode moves them.

Nothing here draws; figures and pages do, from the same lines. All lengths are in metres, world
axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import BatchFunction, Constants, Kernel
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.kinematics.locate import add_geometry
from stiffkit.network import CoordinatesAtPosture
from stiffkit.robot import BASE, Freedom, Joint, Link
from stiffkit.smallmat import Vector, vector
from stiffkit.spatial import Frame
from stiffkit.vibration.curve import bent_line, outline
from stiffkit.vibration.modes import ModalModel, Modes

Array = NDArray[np.float64]

SHOWN = 0.1
"""Largest displacement that a drawing shows, over the robot's size."""

_IN_PLANE = 0.2
"""A mode that leaves a flat mechanism's plane by less than this share of its largest displacement
is best seen in that plane."""

_SAME = 1e-6
"""Points nearer than this, over the robot's length, are one."""


@dataclass(frozen=True, eq=False)
class Path:
    """A line at rest and its displacements."""

    rest: Array
    """(m, 3)."""
    moved: Array
    """(n_modes, m, 3), displacement of each point in each mode."""


@dataclass(frozen=True, eq=False)
class LinkDrawing:
    """A link as lines."""

    name: str
    elastic: bool
    paths: tuple[Path, ...]


@dataclass(frozen=True, eq=False)
class JointDrawing:
    """A joint as a point."""

    name: str
    kind: str
    driven: bool
    grounded: bool
    """Whether it stands on the base."""
    position: Array
    """(3,)."""
    axis: Array | None
    """(3,), unit vector of a revolute, prismatic or cylindrical joint."""
    moved: Array
    """(n_modes, 3)."""
    guide: Path | None
    """What a sliding joint slides along: from where its coordinates are zero to where it is."""


@dataclass(frozen=True, eq=False)
class ModesDrawing:
    """A posture and its modes; in each mode the largest displacement is `SHOWN` of `size`."""

    links: tuple[LinkDrawing, ...]
    joints: tuple[JointDrawing, ...]
    base: tuple[Array, ...]
    """Lines (m, 3) around the joints on the base, if there are three or more."""
    tool: Array
    """(3,)."""
    tool_moved: Array
    """(n_modes, 3)."""
    tool_shares: Array
    """(n_modes,), displacement of the tool over the largest displacement of any point."""
    low: Array
    """(3,), lowest coordinates of all points at rest."""
    high: Array
    """(3,), highest ones."""
    normal: Array | None
    """(3,), axis that is normal to the plane that the mechanism lies in, if it lies in one."""
    out_of_plane: Array
    """(n_modes,), largest displacement along `normal` over the largest one; 0 without a plane."""

    @property
    def size(self) -> float:
        """The diagonal of the box around the robot at rest, m."""
        return float(np.linalg.norm(self.high - self.low))

    def plane(self, mode: int) -> tuple[int, int] | None:
        """Return the two axes (of 0, 1, 2) over which a mode is best seen, None if in space."""
        if self.normal is None or self.out_of_plane[mode] > _IN_PLANE:
            return None
        u, v = np.flatnonzero(self.normal == 0.0)
        return int(u), int(v)


def draw_modes(model: ModalModel, q: Array, modes: Modes) -> ModesDrawing:
    """Return the drawing of modes at coordinates (n,) of the tree, which `model` found there."""
    pen = _Pen(model, q, modes)
    robot = model.tree.robot
    links = [
        LinkDrawing(name, link.compliance is not None, tuple(pen.link_paths(link)))
        for name, link in robot.links.items()
    ]
    joints = [pen.joint(joint) for joint in robot.joints.values()]
    tool = pen.places.tool.position
    return _scaled(links, joints, tool, pen.point(*pen.tool_end, tool))


class _Places:
    """Frames of bodies, joints and tool at one posture, world axes."""

    def __init__(self, tree: SpanningTree, q: Array) -> None:
        robot = tree.robot
        constants = Constants()
        add_geometry(constants, robot)
        joints = list(robot.joints.values())

        def frames(q: Vector, c: Vector) -> Vector:
            located = Located(tree, constants, q, c)
            placed = [located.body(name) for name in robot.links]
            placed += [located.from_side(joint) for joint in joints]
            placed += [located.to_side(joint) for joint in joints]
            return vector(
                x for frame in [*placed, located.tool] for x in (*frame.R.ravel(), *frame.p)
            )

        kernel = Kernel("places", frames, tree.n_coordinates, constants, tree.topology)
        values = BatchFunction(kernel, "numpy")(q[:, None]).reshape(-1, 12)
        found = [Frame(row[:9].reshape(3, 3), row[9:]) for row in values]
        n, m = len(robot.links), len(joints)
        self.body: Mapping[str, Frame] = dict(zip(robot.links, found[:n], strict=True))
        self.from_side = dict(zip(robot.joints, found[n : n + m], strict=True))
        self.to_side = dict(zip(robot.joints, found[n + m : n + 2 * m], strict=True))
        self.tool = found[-1]


class _Pen:
    """Draws lines of one posture, with displacements of modes as they come."""

    def __init__(self, model: ModalModel, q: Array, modes: Modes) -> None:
        self.model = model
        self.robot = model.tree.robot
        self.places = _Places(model.tree, q)
        self.shapes = modes.shapes
        self.tool_end = (self.robot.tool.body, self.robot.tool.port)
        self._at: CoordinatesAtPosture = next(model.coordinates.at_each(q[:, None]))

    def point(self, body: str, port: str, p: Array) -> Array:
        """Return the displacement (n_modes, 3) of a point (3,) that moves with a port."""
        return self._twist(body, port, p)[:3].T

    def _twist(self, body: str, port: str, p: Array) -> Array:
        """Return the twist (6, n_modes), SI, at a point (3,) of a port's rigid cluster."""
        if body == BASE:
            return np.zeros((6, self.shapes.shape[1]))
        cluster = self.model.coordinates.network.cluster_of(body, port)
        twist = self._at.motion_of[cluster] @ self.shapes
        arm = p - self.places.tool.position
        translation = self.model.length * twist[:3] + np.cross(twist[3:].T, arm).T
        return np.concatenate([translation, twist[3:]])

    def link_paths(self, link: Link) -> list[Path]:
        """Return the lines of a link."""
        if link.compliance is None:
            return self._rigid_paths(link, [p for _, p in self._joints_of(link)])
        paths = [path for port in link.other_ports for path in self._spine(link, port)]
        ends = self._joints_of(link)
        if self.robot.tool.body == link.name:
            ends.append((self.robot.tool.port, self.places.tool.position))
        for port, p in ends:
            start = self.places.body[link.name].point(link.ports[port].position)
            paths += self._lines(link, outline([start, p], self._tolerance), port)
        return paths

    def _joints_of(self, link: Link) -> list[tuple[str, Array]]:
        """Return port and place of each joint on a link."""
        found = []
        for name, joint in self.robot.joints.items():
            if joint.from_body == link.name:
                found.append((joint.from_port, self.places.from_side[name].position))
            if joint.to_body == link.name:
                found.append((joint.to_port, self.places.to_side[name].position))
        return found

    def _rigid_paths(self, link: Link, points: list[Array]) -> list[Path]:
        """Return the outline of a rigid link, with spokes and a stem if it carries the tool."""
        lines = outline(points, self._tolerance)
        if self.robot.tool.body == link.name:
            tool = self.places.tool.position
            if not lines or len(lines[0]) < 3:
                lines = outline([*points, tool], self._tolerance)
            elif np.linalg.norm(lines[0] - tool, axis=1).min() > self._tolerance:
                corners = lines[0][:-1]
                centre = corners.mean(axis=0)
                for end in [tool, *corners]:
                    lines += outline([centre, end], self._tolerance)
        return self._lines(link, lines, "base")

    def _lines(self, link: Link, lines: list[Array], port: str) -> list[Path]:
        """Return lines that move with a port."""
        return [
            Path(line, np.stack([self.point(link.name, port, p) for p in line], axis=1))
            for line in lines
        ]

    @property
    def _tolerance(self) -> float:
        return _SAME * self.model.length

    def _spine(self, link: Link, port: str) -> list[Path]:
        """Return the line from an elastic link's base to a port, bent by its static and own modes.

        What is between the ports of a link with more than two is not known: their twists say all.
        """
        T_world_link = self.places.body[link.name]
        base, tip = (T_world_link.point(link.ports[end].position) for end in (BASE, port))
        length = float(np.linalg.norm(tip - base))
        twist_base = self._twist(link.name, BASE, base)
        twist_tip = self._twist(link.name, port, tip)
        if length <= self._tolerance:
            # A link of no length shows how far its ends part.
            return [Path(np.stack([base, tip]), np.stack([twist_base[:3].T, twist_tip[:3].T], 1))]
        element = self.model.bodies.elastic.get(link.name)
        if element is None or element.stations.size == 0:
            stations, twists = np.array([0.0, length]), np.stack([twist_base, twist_tip])
        else:
            turn = np.kron(np.eye(2), T_world_link.rotation)
            own = [i for i, name in enumerate(self._at.names) if name == f"{link.name}.mode"]
            ports = [turn.T @ twist_base, turn.T @ twist_tip]
            inside = element.shapes @ np.concatenate([*ports, self.shapes[own]])
            stations = element.stations
            twists = turn @ inside.reshape(stations.size, 6, -1)
        along = (tip - base) / length
        shares, moved = bent_line(stations, twists, along)
        return [Path(base + shares[:, None] * (tip - base), moved)]

    def joint(self, joint: Joint) -> JointDrawing:
        """Return a joint, which is drawn where its ``to`` side is."""
        near, far = self.places.from_side[joint.name], self.places.to_side[joint.name]
        start, end = near.position, far.position
        on_start = self.point(joint.from_body, joint.from_port, start)
        on_end = self.point(joint.to_body, joint.to_port, end)
        slides = joint.kind in ("prismatic", "cylindrical", "planar")
        axis = None
        if joint.kind in ("revolute", "prismatic", "cylindrical"):
            axis = near.rotation[:, "xyz".index(joint.axes[0])]
        guide = Path(np.stack([start, end]), np.stack([on_start, on_end], axis=1))
        moving_base = joint.to_body == BASE
        return JointDrawing(
            joint.name,
            joint.kind,
            Freedom.DRIVEN in joint.freedoms,
            BASE in (joint.from_body, joint.to_body),
            start if moving_base else end,
            axis,
            on_start if moving_base else on_end,
            guide if slides else None,
        )


def _scaled(
    links: list[LinkDrawing], joints: list[JointDrawing], tool: Array, tool_moved: Array
) -> ModesDrawing:
    paths = [path for link in links for path in link.paths]
    paths += [joint.guide for joint in joints if joint.guide is not None]
    marks = [*[j.position for j in joints], tool]
    points = np.concatenate([*[path.rest for path in paths], np.array(marks)])
    marks_moved = np.stack([*[j.moved for j in joints], tool_moved], axis=1)
    moved = np.concatenate([*[path.moved for path in paths], marks_moved], axis=1)
    largest = np.linalg.norm(moved, axis=2).max(axis=1)
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    unit = np.where(largest > 0.0, largest, 1.0)
    scale = (SHOWN * size / unit)[:, None]

    def scaled(path: Path) -> Path:
        return Path(path.rest, scale[..., None] * path.moved)

    grounded = [j.position for j in joints if j.grounded]
    flat = np.flatnonzero(high - low <= 0.01 * size)
    normal = np.eye(3)[flat[0]] if flat.size == 1 else None
    across = np.zeros(largest.size) if normal is None else np.abs(moved @ normal).max(axis=1) / unit
    return ModesDrawing(
        tuple(LinkDrawing(k.name, k.elastic, tuple(map(scaled, k.paths))) for k in links),
        tuple(
            JointDrawing(
                j.name, j.kind, j.driven, j.grounded, j.position, j.axis, scale * j.moved,
                None if j.guide is None else scaled(j.guide),
            )
            for j in joints
        ),
        tuple(outline(grounded, _SAME * size)) if len(grounded) > 2 else (),
        tool,
        scale * tool_moved,
        np.linalg.norm(tool_moved, axis=1) / unit,
        low,
        high,
        normal,
        across,
    )  # fmt: skip
