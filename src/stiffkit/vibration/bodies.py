"""The masses of a robot: rigid bodies, and elastic links with mass along them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import LinkError
from stiffkit.link.line import Line, equivalent_line
from stiffkit.link.superelement import (
    Superelement,
    consistent_superelement,
    lumped_superelement,
    rigid_mass,
)
from stiffkit.robot import Link, Robot

Array = NDArray[np.float64]

LinkModel = Literal["consistent", "lumped"]


@dataclass(frozen=True)
class Discretisation:
    """How elastic links with mass are cut up."""

    model: LinkModel = "consistent"
    """consistent: beam elements; lumped: rigid elements joined by springs, as in Briot 2009."""
    n_elements: int = 8
    """Elements of each link."""
    n_modes: int | None = 6
    """Modes with both ports held that are kept of each link, all if None."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """What moves with mass."""

    rigid: Mapping[str, Array]
    """Mass matrix (6, 6), SI, of each rigid body, for the twist at its link's origin."""
    elastic: Mapping[str, Superelement]
    """Of each elastic link with mass."""
    tool_mass: float
    """kg, a point mass at the tool point."""

    @property
    def rules(self) -> dict[str, str]:
        """How mass and elasticity of each elastic link were distributed."""
        return {name: element.rule for name, element in self.elastic.items()}

    @property
    def mode_stiffness(self) -> dict[str, Array]:
        """Squared angular frequencies (n,) of the internal modes of each elastic link."""
        return {name: element.mode_stiffness for name, element in self.elastic.items()}


def make_bodies(robot: Robot, how: Discretisation) -> Bodies:
    """Return the masses of a robot. Raises LinkError where a link's mass cannot be distributed."""
    found = {name: _body(link, how) for name, link in robot.links.items()}
    return Bodies(
        {name: body for name, body in found.items() if isinstance(body, np.ndarray)},
        {name: body for name, body in found.items() if isinstance(body, Superelement)},
        robot.tool.mass or 0.0,
    )


@lru_cache(maxsize=1000)
def _body(link: Link, how: Discretisation) -> Array | Superelement | None:
    """Return the mass matrix (6, 6) of a rigid link, the superelement of an elastic one.

    Robots that differ in a few parameters have most of their links in common.
    """
    if link.superelement is not None:
        return link.superelement.lowest(how.n_modes)
    if not link.mass:
        return None
    line = link_line(link) if link.compliance is not None else None
    if line is None:
        center = np.zeros(3) if link.center_of_mass is None else link.center_of_mass
        return rigid_mass(link.mass, center, link.inertia)
    # What the link yields at its tip is its own compliance, whatever the line's is.
    return _superelement(line, how)


def link_line(link: Link) -> Line | None:
    """Return an elastic link as a line; None where its mass goes along with its base.

    That is so where the link has more than two ports, where the tip lies at the base, or the centre
    of mass so near to it that no mass spread along the link could have it there.
    """
    if link.line is not None or len(link.other_ports) != 1:
        return link.line
    tip = link.ports[link.other_ports[0]].position
    if link.compliance is None or link.mass is None or not np.any(tip):
        return None
    if link.center_of_mass is not None and link.center_of_mass @ tip < tip @ tip / 3.0:
        return None
    try:
        return equivalent_line(link.compliance, tip, link.mass, link.center_of_mass, link.inertia)
    except LinkError as error:
        raise LinkError(f"links.{link.name}: {error.what}", mend=error.mend) from None


def _superelement(line: Line, how: Discretisation) -> Superelement:
    make = consistent_superelement if how.model == "consistent" else lumped_superelement
    return make(line, how.n_elements, how.n_modes)
