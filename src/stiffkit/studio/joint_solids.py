"""Joints and drives as solids, drawn by kind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stiffkit.link import Outline
from stiffkit.robot import BASE, Freedom, Joint
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array
from stiffkit.studio.mesh import Mesh, ball, bar, block, cylinder, frame_along
from stiffkit.studio.solid import Ride, Role, Solid
from stiffkit.studio.strokes import Stroke

_DRIVEN = 1.25
"""Size of a drive over that of a passive joint."""

_LONG = 2.6
"""Length of a pin over the joint's radius."""

_CROSS = 3.2
"""Length of the pins of a universal joint over its radius."""


def joint_solids(
    joint: Joint, offset: Array, radius: float, stroke: Stroke | None
) -> Iterator[Solid]:
    """Yield the solids of a joint.

    ``offset`` (3,), m, in the joint frame, is where it is drawn; ``stroke`` (m) are the lowest and
    the highest coordinate of a prismatic or cylindrical joint, None if it stays where it is.
    """
    driven = Freedom.DRIVEN in joint.freedoms
    r = radius * (_DRIVEN if driven else 1.0)
    drawing = _Joint(joint, offset, "drive" if driven else "joint", r)
    match joint.kind:
        case "revolute":
            yield drawing.on_from(cylinder(r, _LONG * r, drawing.along(joint.axes[0])))
        case "cylindrical":
            yield drawing.on_to(cylinder(1.2 * r, _LONG * r, drawing.along(joint.axes[0])))
            yield from drawing.guide(_round(0.6 * r), stroke, _LONG * r)
        case "prismatic":
            yield from _slide(drawing, stroke)
        case "universal":
            first, second = joint.axes
            yield drawing.on_from(cylinder(0.6 * r, _CROSS * r, drawing.along(first)))
            pin = cylinder(0.6 * r, _CROSS * r, drawing.along(second))
            yield drawing.on_to(pin, " inner")
        case "spherical":
            yield drawing.on_from(ball(1.2 * r, offset))
        case "planar":
            frame = drawing.along(joint.axes[0])
            yield drawing.on_from(block([0.4 * r, 5.0 * r, 5.0 * r], frame), " plane")
            yield drawing.on_to(block([1.2 * r, 2.2 * r, 2.2 * r], frame))


class _Joint:
    """Makes solids of what is drawn in a joint's frame."""

    def __init__(self, joint: Joint, offset: Array, role: Role, radius: float) -> None:
        self.joint = joint
        self.offset = offset
        self.role: Role = role
        self.radius = radius
        self.grounded = BASE in (joint.from_body, joint.to_body)

    def along(self, axis: str) -> Frame:
        """Return the frame, in the joint's, at its place with x along one of the joint's axes."""
        return frame_along(self.offset, np.eye(3)["xyz".index(axis)])

    def on_from(self, mesh: Mesh, suffix: str = "") -> Solid:
        """Return the solid of a mesh in the joint frame of the ``from`` side."""
        joint = self.joint
        return self._solid(mesh, joint.from_body, joint.from_port, joint.T_from_joint, suffix)

    def on_to(self, mesh: Mesh, suffix: str = "") -> Solid:
        """Return the solid of a mesh in the joint frame of the ``to`` side."""
        joint = self.joint
        return self._solid(mesh, joint.to_body, joint.to_port, joint.T_to_joint, suffix)

    def _solid(self, mesh: Mesh, body: str, port: str, frame: Frame, suffix: str) -> Solid:
        role: Role = self.role if suffix != " guide" else "base" if body == BASE else "joint"
        name = f"{self.role} {self.joint.name}{suffix}"
        return Solid(name, role, body, mesh.placed(frame), Ride(port))

    def guide(self, outline: Outline, stroke: Stroke | None, over: float) -> Iterator[Solid]:
        """Yield what the joint slides along, if it slides: a bar.

        It is longer by ``over`` (m) than the stroke. On a body that moves it begins where the
        joint's coordinate is zero, where it is attached.
        """
        if stroke is None:
            return
        low, high = stroke
        on_to = self.joint.to_body == BASE
        if on_to:
            low, high = -high, -low
        if not self.grounded:
            low, high = min(low, 0.0), max(high, 0.0)
        frame = self.along(self.joint.axes[0])
        middle = Frame.at((low + high) / 2.0)
        length = high - low + over
        if length <= 0.0:
            return
        mesh = bar(outline, length, frame @ middle)
        yield self.on_to(mesh, " guide") if on_to else self.on_from(mesh, " guide")


def _round(radius: float) -> Outline:
    return Outline("ellipse", 2.0 * radius, 2.0 * radius)


def _slide(drawing: _Joint, stroke: Stroke | None) -> Iterator[Solid]:
    """Yield a carriage on a guide, or the gland of a telescope with what slides in it."""
    r, frame = drawing.radius, drawing.along(drawing.joint.axes[0])
    if not drawing.grounded:
        yield drawing.on_from(cylinder(1.15 * r, 1.6 * r, frame))
        yield from drawing.guide(_round(0.2 * r), stroke, 0.0)
        return
    # Small enough for a pin of the same joint radius to stick out of it.
    carriage = block([2.0 * r, 1.9 * r, 1.9 * r], frame)
    moves_to = drawing.joint.to_body != BASE
    yield drawing.on_to(carriage) if moves_to else drawing.on_from(carriage)
    yield from drawing.guide(Outline("rectangle", r, r), stroke, 3.2 * r)
