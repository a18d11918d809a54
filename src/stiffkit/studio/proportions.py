"""How big things without a size of their own are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stiffkit.kinematics import Places
from stiffkit.robot import BASE, Joint, Link, Robot
from stiffkit.spatial.rotation import Array
from stiffkit.studio.seats import Seats

_GAUGE = 0.014
"""Half the thickness of a bar, over the robot's size, where no bar is known."""
_THINNEST, _THICKEST = 0.006, 0.028
"""Bounds of it, over the robot's size."""
_WIDEST = 0.05
"""Half the thickness beyond which a joint is not drawn thicker, over the robot's size."""
_JOINT = 1.25
"""Radius of a joint over half the thickness of what it joins."""


@dataclass(frozen=True, eq=False)
class Proportions:
    """Lengths that marks of joints, rods and plates are made of, m."""

    low: Array
    """(3,), lowest coordinates of joints and tool at home, world axes."""
    high: Array
    """(3,), highest ones."""
    size: float
    """The diagonal of the box between these."""
    gauge: float
    """Half the thickness that is usual for the robot's bars."""
    radii: dict[str, float]
    """Radius of each joint."""

    @staticmethod
    def of(robot: Robot, home: Places, seats: Seats) -> Proportions:
        """Return the proportions of a robot."""
        points = np.array(
            [
                home.body[body].point(seat.point)
                for body in seats.of_body
                for seat in seats.of_body[body]
            ]
            + [home.tool.position]
        )
        low, high = points.min(axis=0), points.max(axis=0)
        size = float(np.linalg.norm(high - low)) or 1.0
        known = {name: _half(link) for name, link in robot.links.items()}
        halves = [half for half in known.values() if half is not None]
        usual = float(np.median(halves)) if halves else _GAUGE * size
        gauge = float(np.clip(usual, _THINNEST * size, _THICKEST * size))
        radii = {name: _JOINT * _fitting(j, known, gauge, size) for name, j in robot.joints.items()}
        for joint in robot.joints.values():
            if joint.kind == "prismatic" and BASE in (joint.from_body, joint.to_body):
                radii[joint.name] = max(radii[other] for other in _on_carriage(robot, joint))
        return Proportions(low, high, size, gauge, radii)


def _half(link: Link) -> float | None:
    """Return half the thickness of a beam, the mean of both, or of a part; None if not known."""
    if link.cad is not None:
        return float(np.ptp(link.cad.solved.surface.points, axis=0).min()) / 2.0
    outline = None if link.line is None else link.line.outline
    return None if outline is None else float(np.sqrt(outline.width * outline.height)) / 2.0


def _fitting(joint: Joint, known: dict[str, float | None], gauge: float, size: float) -> float:
    """Return half the thickness that a joint fits, m."""
    bodies = [body for body in (joint.from_body, joint.to_body) if body != BASE]
    halves = [half for half in map(known.get, bodies) if half is not None]
    # A ball fits the thinner of two bars, a pin or a carriage goes around the thicker.
    fits = min if joint.kind in ("universal", "spherical") else max
    return float(np.clip(fits(halves, default=gauge), _THINNEST * size, _WIDEST * size))


def _on_carriage(robot: Robot, slide: Joint) -> Iterator[str]:
    """Yield the names of the joints of the body that a slide on the base moves, its own too."""
    carriage = slide.to_body if slide.from_body == BASE else slide.from_body
    for joint in robot.joints.values():
        if carriage in (joint.from_body, joint.to_body):
            yield joint.name
