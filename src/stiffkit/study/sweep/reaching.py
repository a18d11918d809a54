"""Reaching postures from others of the same geometry, for many geometries at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import GeometriesFunction
from stiffkit.kinematics.tracking import SMALLEST_PIECE, Tracker
from stiffkit.study.sweep.group import Group

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Care:
    """How hard it is tried to reach what an anchor does not lead to."""

    smallest_piece: float = SMALLEST_PIECE
    """Share of the way from a neighbour, below which it is not halved any more."""
    most_from_home: int | None = None
    """How many postures, spread evenly over what is missing, are tried from home; all if None."""


THOROUGH = Care()


class Reaching:
    """Postures that the nearest anchor does not lead to, of a few geometries."""

    def __init__(
        self,
        group: Group,
        neighbours: NDArray[np.intp],
        constants: Array,
        asked: Array,
        care: Care = THOROUGH,
    ) -> None:
        """Take G geometries: constants (m, G), and tool coordinates asked for (k, G, P).

        ``neighbours`` (P, j) are the postures beside each one, -1 where there is none.
        """
        self.neighbours = neighbours
        self.asked = asked
        turns = [d.startswith("r") for d in group.family.asked]
        step = _StepOfGeometry(group.step, constants)
        self.care = care
        self.far = Tracker(step, group.closure.n_unknowns, np.array([*turns, False]))
        self.near = replace(self.far, smallest_piece=care.smallest_piece)

    def find(self, q: Array, reached: Mask, wanted: Mask, home: Array, home_pose: Array) -> None:
        """Fill in what is missing of q (n, G, P) and ``reached`` (G, P)."""
        self.grow(q, reached, wanted, reached.copy())
        g, i = self._from_home(wanted & ~reached)
        leads_on = np.zeros_like(reached)
        self.follow(self.far, q, reached, leads_on, (g, i), home[:, g], home_pose[:, g])
        self.grow(q, reached, wanted, leads_on)

    def _from_home(self, missing: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return which of what is missing (geometry, posture) is tried from home."""
        g, i = np.nonzero(missing)
        most = self.care.most_from_home
        if most is None or g.size <= most:
            return g, i
        few = np.unique(np.linspace(0, g.size - 1, most).astype(np.intp))
        return g[few], i[few]

    def grow(self, q: Array, reached: Mask, wanted: Mask, sources: Mask) -> None:
        """Reach postures from neighbours among the sources, and then from those, layer by layer."""
        while sources.any():
            leads_on = np.zeros_like(reached)
            for column in self.neighbours.T:
                g, i = np.nonzero(wanted & ~reached & sources[:, column] & (column >= 0))
                beside = column[i]
                start = q[:, g, beside], self.asked[:, g, beside]
                self.follow(self.near, q, reached, leads_on, (g, i), *start)
            sources = leads_on

    def follow(
        self,
        tracker: Tracker,
        q: Array,
        reached: Mask,
        leads_on: Mask,
        ends: tuple[NDArray[np.intp], NDArray[np.intp]],
        start: Array,
        start_pose: Array,
    ) -> None:
        """Follow postures to some ends (geometry, posture), and keep those that are reached."""
        g, i = ends
        if g.size == 0:
            return
        number = g[None].astype(float)
        found = tracker.follow(
            start,
            np.concatenate([start_pose, number]),
            np.concatenate([self.asked[:, g, i], number]),
        )
        q[:, g, i] = found.q
        reached[g, i] = found.reached
        leads_on[g, i] = found.reached & ~found.at_limit


class _StepOfGeometry:
    """Newton's step where the last coordinate that is asked for is the number of the geometry."""

    def __init__(self, function: GeometriesFunction, constants: Array) -> None:
        self.function = function
        self.constants = constants

    def __call__(self, inputs: Array) -> Array:
        number = inputs[-1].astype(np.intp)
        return self.function.at(self.constants, number)(inputs[:-1])
