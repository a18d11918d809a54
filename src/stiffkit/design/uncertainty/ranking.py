"""Which part to stiffen first.

Scaling all compliances of a robot by one factor scales its deflections by the same and its
stiffnesses by one over it. So each part has a share in what is asked, and the shares add up to one.
A part whose walls grow thicker in proportion yields less by one part in its mass for each kilogram
that is added.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.uncertainty.first_order import FirstOrder
from stiffkit.design.uncertainty.spec import Asked
from stiffkit.network.parts import joint_compliance
from stiffkit.robot import Freedom, Joint
from stiffkit.study.quantities import QUANTITIES

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Part:
    """A link or a joint, and its share in what is asked."""

    name: str
    kind: str
    """link, drive, or joint where it is elastic and not driven."""
    mass: float
    """kg; NaN where there is none, or it is not known."""
    share: float
    """Mean over the workspace, 0 to 1."""
    share_at_worst: float
    """At the posture where the quantity is the worst."""

    @property
    def gain_per_kg(self) -> float:
        """Share of what is asked that is gained by each kilogram added to the part, 1/kg."""
        return self.share / self.mass


def ranking(first_order: FirstOrder, asked: Asked) -> list[Part]:
    """Return links and elastic joints with their share in a quantity.

    Of the refined model only: nothing but drives yields in the other. None where no posture has an
    answer.
    """
    postures = first_order.postures
    lower, values = first_order.nominal(asked, "refined")
    at = np.flatnonzero(np.isfinite(values) & (values > 0.0))
    if not at.size:
        return []
    quantity = QUANTITIES[asked.quantity]
    worst = int((np.argmax if quantity.worst_is_largest else np.argmin)(values[at]))
    following = postures.traced(asked.quantity, asked.load, "refined", at, lower[:, at]).following
    constants = postures.geometry.constants
    sign = 1.0 if quantity.worst_is_largest else -1.0
    robot = postures.geometry.robot

    def part(name: str, kind: str, block: str, mass: float | None) -> Part:
        where = postures.geometry.elasticity.where(block)
        shares = sign * (constants[where] @ following.constants[where]) / values[at]
        known = float(mass) if mass else float("nan")
        return Part(name, kind, known, float(shares.mean()), float(shares[worst]))

    links = [
        part(name, "link", f"compliance:{name}", link.mass)
        for name, link in robot.links.items()
        if link.compliance is not None
    ]
    joints = [
        part(name, _kind(joint), f"compliance of joint:{name}", None)
        for name, joint in robot.joints.items()
        if joint_compliance(joint).any()
    ]
    return [*links, *joints]


def _kind(joint: Joint) -> str:
    return "drive" if Freedom.DRIVEN in joint.freedoms else "joint"
