"""Mode shapes as geometry: where a mechanism's lines are at rest, and how each mode moves them.

Nothing here draws; figures and pages do, from the same lines. All lengths are in metres, world
axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Locator
from stiffkit.robot import BASE, Freedom, Joint, Link
from stiffkit.vibration.curve import bent_line, outline
from stiffkit.vibration.modes import ModalModel, Modes
from stiffkit.vibration.moving import SAME, Moving

Array = NDArray[np.float64]

SHOWN = 0.1
"""Largest displacement that a drawing shows, over the robot's size."""

_IN_PLANE = 0.2
"""A mode that leaves a flat mechanism's plane by less than this share of its largest displacement
is best seen in that plane."""


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


class _Pen:
    """Draws lines of one posture, with displacements of modes as they come."""

    def __init__(self, model: ModalModel, q: Array, modes: Modes) -> None:
        self.robot = model.tree.robot
        self.places = Locator(model.tree).at(q)
        self.moving = Moving(model, self.places, q, modes.shapes)
        self.tool_end = (self.robot.tool.body, self.robot.tool.port)
        self._tolerance = self.moving.tolerance

    def point(self, body: str, port: str, p: Array) -> Array:
        """Return the displacement (n_modes, 3) of a point (3,) that moves with a port."""
        return self.moving.twist(body, port, p)[:3].T

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
        for joint in self.robot.joints.values():
            if joint.from_body == link.name:
                found.append((joint.from_port, self.places.from_side(joint).position))
            if joint.to_body == link.name:
                found.append((joint.to_port, self.places.to_side(joint).position))
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

    def _spine(self, link: Link, port: str) -> list[Path]:
        """Return the line from an elastic link's base to a port."""
        spine = self.moving.spine(link, port)
        if spine is None:
            # A link of no length shows how far its ends part.
            base = self.places.body[link.name].position
            ends = [self.point(link.name, end, base) for end in (BASE, port)]
            return [Path(np.stack([base, base]), np.stack(ends, axis=1))]
        shares, moved = bent_line(spine.stations, spine.twists, spine.along)
        return [Path(spine.base + shares[:, None] * (spine.tip - spine.base), moved)]

    def joint(self, joint: Joint) -> JointDrawing:
        """Return a joint, which is drawn where its ``to`` side is."""
        near, far = self.places.from_side(joint), self.places.to_side(joint)
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
        tuple(outline(grounded, SAME * size)) if len(grounded) > 2 else (),
        tool,
        scale * tool_moved,
        np.linalg.norm(tool_moved, axis=1) / unit,
        low,
        high,
        normal,
        across,
    )  # fmt: skip
