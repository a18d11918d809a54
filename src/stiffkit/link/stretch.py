"""Links that are given at one length and used at another.

A link is drawn out along the line from its base to its tip, as a bar of one section that is cut
longer: its sections, and its mass per metre, stay as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from stiffkit.files.entry import Entry
from stiffkit.link.line import equivalent_line
from stiffkit.link.ports import in_words
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array
from stiffkit.units import LENGTH

Rule = Literal["equivalent-beam", "constant-section"]
"""equivalent-beam: the link is replaced by the beam of constant section that has the first four
diagonal elements of its compliance (Briot et al. 2009, section 2.3). constant-section: every
element of its own compliance changes as that of a slender beam does."""

_SAME = 1e-9
"""Lengths that differ by less than this share are equal."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """How a link follows its length: what holds at the reference length becomes the link's."""

    tip: Array
    """(3,), m, tip from base."""
    reference: float
    """m, the length at which the data hold."""
    rule: Rule

    @property
    def length(self) -> float:
        """m, from base to tip."""
        return float(np.linalg.norm(self.tip))

    @property
    def ratio(self) -> float:
        """The link's length over the reference length."""
        return self.length / self.reference

    @property
    def is_none(self) -> bool:
        """Whether the link stays exactly as it is given."""
        return self.rule == "constant-section" and abs(self.ratio - 1.0) < _SAME

    @property
    def _across(self) -> Array:
        """(3, 3), the projection on the plane across the line."""
        along = self.tip / self.length
        return np.asarray(np.eye(3) - np.outer(along, along))

    def compliance(self, given: Array) -> Array:
        """Return the compliance (6, 6) at the tip, link axes, from that at the reference length.

        A slender beam of constant section extends, twists and turns with its length, its tip moves
        across with the cube of it, and by a moment with the square: on both sides of the matrix a
        load or a motion counts with the root of these. So a definite matrix stays definite.
        """
        if self.rule == "equivalent-beam":
            start = self.tip / self.ratio
            given = equivalent_line(given, start, 0.0, None, None).compliance(self.reference)
        counts = np.eye(6) * np.sqrt(self.ratio)
        counts[:3, :3] += np.sqrt(self.ratio) * (self.ratio - 1.0) * self._across
        return np.asarray(counts @ given @ counts)

    def mass(self, given: float) -> float:
        """Return the mass, kg, from that at the reference length."""
        return given * self.ratio

    def point(self, given: Array) -> Array:
        """Return where a point (3,) of the link comes to, m, link axes."""
        across = self._across @ given
        return np.asarray(across + self.ratio * (given - across))

    def inertia(self, given: Array) -> Array:
        """Return the inertia (3, 3), kg m^2, about the centre of mass, of the link drawn out.

        It is that of the same mass per metre with every point moved as by `point`, so that of a
        body it is that of a body.
        """
        second = np.trace(given) / 2.0 * np.eye(3) - given
        move = self._across + self.ratio * (np.eye(3) - self._across)
        second = self.ratio * move @ second @ move
        return np.asarray(np.trace(second) * np.eye(3) - second)

    @property
    def words(self) -> str:
        """What was done, for the notes of a robot."""
        how = {
            "equivalent-beam": "replaced by its equivalent beam of constant section",
            "constant-section": "drawn out with constant section",
        }[self.rule]
        return f"given at {self.reference:.6g} m, {how}, {self.length:.6g} m long"


def read_stretch(entry: Entry, ports: Mapping[str, Frame]) -> Stretch:
    """Return what the ``scale`` of a compliance says. ``ports`` are those that are not held.

    Raises FileError where there are several, or the only one lies at the base.
    """
    if len(ports) > 1:
        raise entry.error(
            f"a link with the ports {in_words(list(ports))} has no one length to follow",
            "scale links with a tip only: give 'tip' or 'length', or leave 'scale' out",
        )
    (port,) = ports.values()
    if not np.any(port.position):
        raise entry.error(
            "the tip lies at the base, so the link has no length to follow",
            "give the place of the tip, or leave 'scale' out",
        )
    reference = entry["reference"].positive(LENGTH)
    rule: Rule = next(name for name in get_args(Rule) if entry["rule"].is_text(name))
    return Stretch(port.position, reference, rule)
