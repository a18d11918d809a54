"""Reaching postures from others of the same geometry, for many geometries at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import GeometriesFunction
from stiffkit.kinematics.tracking import Tracker
from stiffkit.study.sweep.group import Group

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Reaching:
    """Postures that the nearest anchor does not lead to, of a few geometries."""

    def __init__(
        self, group: Group, neighbours: NDArray[np.intp], constants: Array, asked: Array
    ) -> None:
        """Take G geometries: constants (m, G), and tool coordinates asked for (k, G, P).

        ``neighbours`` (P, j) are the postures beside each one, -1 where there is none.
        """
        self.neighbours = neighbours
        self.asked = asked
        turns = [d.startswith("r") for d in group.family.asked]
        step = _StepOfGeometry(group.step, constants)
        self.tracker = Tracker(step, group.closure.n_unknowns, np.array([*turns, False]))

    def find(self, q: Array, reached: Mask, wanted: Mask, home: Array, home_pose: Array) -> None:
        """Fill in what is missing of q (n, G, P) and ``reached`` (G, P)."""
        self.grow(q, reached, wanted, reached.copy())
        g, i = np.nonzero(wanted & ~reached)
        leads_on = np.zeros_like(reached)
        self.follow(q, reached, leads_on, (g, i), home[:, g], home_pose[:, g])
        self.grow(q, reached, wanted, leads_on)

    def grow(self, q: Array, reached: Mask, wanted: Mask, sources: Mask) -> None:
        """Reach postures from neighbours among the sources, and then from those, layer by layer."""
        while sources.any():
            leads_on = np.zeros_like(reached)
            for column in self.neighbours.T:
                g, i = np.nonzero(wanted & ~reached & sources[:, column] & (column >= 0))
                beside = column[i]
                self.follow(q, reached, leads_on, (g, i), q[:, g, beside], self.asked[:, g, beside])
            sources = leads_on

    def follow(
        self,
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
        found = self.tracker.follow(
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
