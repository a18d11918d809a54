"""Variants that others are reached from, so that a slider can be drawn as far as it goes.

The loops of a variant are closed from postures of another one near by. Which one that is follows
from the variant's own values and not from where the slider was before: the values are rounded to a
coarse grid around the robot file's own, and the variant there, the station, is reached in the same
way from the next station on the way to the file's own geometry. So a variant is the same, bit for
bit, however it was come by.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import AssemblyError, StiffkitError
from stiffkit.studio.sliders import Slider
from stiffkit.study.sweep.anchors import Anchors
from stiffkit.study.sweep.closing import Closing, Homes
from stiffkit.study.sweep.family import Geometry
from stiffkit.study.sweep.group import Group, Groups
from stiffkit.study.sweep.prepare import anchor_of, own_anchor
from stiffkit.study.sweep.reaching import Care

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SPACES = 16
"""Distances between stations along a slider."""
_MOST_KEPT = 24
"""Stations whose postures are kept; those that are not are made again, and come out the same."""

_CARE = Care(smallest_piece=1.0 / 8.0, most_from_home=128)
"""What is out of reach must not take long to be found so: neighbours in the workspace are near, and
what lies apart from everything reached is seen from a few places."""

_ONE = np.zeros(1, dtype=np.intp)
"""The number of the only geometry."""

Key = tuple[int, ...]
"""Where a station stands: in distances from the file's own value of each parameter."""


@dataclass(frozen=True, eq=False)
class Closed:
    """A geometry whose loops are closed over its workspace."""

    geometry: Geometry
    group: Group
    closing: Closing
    homes: Homes
    home_unknowns: Array
    """(n,), unknowns of the closure at home."""
    q: Array
    """(n, P), unknowns of the closure, NaN where a posture is not reached."""
    reached: Mask
    """(P,)."""
    asked: Array
    """(m, P), tool coordinates that are asked for."""

    def observe(self, q: Array) -> tuple[Array, Array]:
        """Return tool poses (6, N) and joint coordinates, in the file's order, of unknowns."""
        n = self.group.tree.n_coordinates
        return self.closing.observe(q[:n], np.zeros(q.shape[1], dtype=np.intp))


class Stations:
    """The stations of a robot, each made when it is first needed."""

    def __init__(self, groups: Groups, moved: Sequence[Slider]) -> None:
        """Take the parameters that move loops, among those that the family varies."""
        self._groups = groups
        self._family = groups.family
        self._moved = tuple(moved)
        self.own = own_anchor(groups)
        """The file's own geometry, from which all others are reached in the end."""
        self._kept: OrderedDict[Key, Anchors] = OrderedDict()

    def closed(self, geometry: Geometry, values: Mapping[str, float]) -> Closed:
        """Return a geometry with these parameters (SI), its loops closed over its workspace.

        Raises AssemblyError if it cannot be put together.
        """
        key = tuple(_place(one, values.get(one.name, one.value)) for one in self._moved)
        return self._closed(geometry, self._station(key))

    def anchor(self, values: Mapping[str, float]) -> Anchors:
        """Return the variant with these values (SI) of parameters that the family varies.

        Raises StiffkitError where there can be no such robot.
        """
        key = tuple(_place(one, values.get(one.name, one.value)) for one in self._moved)
        return self._reached(values, self._station(key))

    def _station(self, key: Key) -> Anchors:
        if not any(key):
            return self.own
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        before = self._station(tuple(_nearer(place) for place in key))
        values = {
            one.name: one.value + place * _distance(one)
            for one, place in zip(self._moved, key, strict=True)
        }
        try:
            station = self._reached(values, before)
        except StiffkitError:
            # There can be no robot here: what lies beyond is reached from the one before.
            station = before
        self._kept[key] = station
        while len(self._kept) > _MOST_KEPT:
            self._kept.popitem(last=False)
        return station

    def _reached(self, values: Mapping[str, float], before: Anchors) -> Anchors:
        """Return the variant with these values as one to reach others from."""
        varied = self._family.spec.varied
        own = zip(varied, self._family.own_values(), strict=True)
        numbers = np.array([values.get(one.name, value) for one, value in own])
        closed = self._closed(self._family.geometry(numbers), before)
        tool = np.repeat(closed.homes.tool, closed.q.shape[1], axis=1)
        home = closed.homes.unknowns[:, 0]
        return anchor_of(self._groups, closed.geometry, numbers, home, closed.q, tool)

    def _closed(self, geometry: Geometry, station: Anchors) -> Closed:
        group = self._groups.of(geometry)
        closing = Closing(group, [geometry], station, _ONE[:, None], _CARE)
        homes = closing.homes()
        if homes.reasons[0]:
            raise AssemblyError(
                "with these values the mechanism cannot be put together at its home posture:"
                f" {homes.reasons[0]}",
                mend="move the parameters back towards those of the robot file",
            )
        q, reached = closing.postures(_ONE, homes)
        asked = closing.asked(_ONE, homes)
        home, _ = closing.home(_ONE, homes)
        return Closed(geometry, group, closing, homes, home[:, 0], q[:, 0], reached[0], asked[:, 0])


def _distance(one: Slider) -> float:
    return (one.high - one.low) / _SPACES


def _place(one: Slider, value: float) -> int:
    distance = _distance(one)
    inside = min(max(value, one.low), one.high)
    return round((inside - one.value) / distance) if distance > 0.0 else 0


def _nearer(place: int) -> int:
    """Return the place one nearer to the file's own value."""
    return place - (place > 0) + (place < 0)
