"""The lowest frequency at a few postures of each geometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, Constants
from stiffkit.errors import LinkError
from stiffkit.kinematics import SpanningTree
from stiffkit.study.sweep.family import Geometry
from stiffkit.study.sweep.group import Group
from stiffkit.vibration import FastGeometries, ModalModel

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Basis:
    """What the fast model of all geometries is made of."""

    U: Array
    """(n_energy, r); r = 0 if no basis is good enough, and the full model is to be used."""
    limit: float
    """Change of a frequency without the last vectors, beyond which the full model is used."""
    error: float
    """Largest relative error of a frequency at geometries and postures it was not made from."""
    checked: int
    """Number of those."""

    def arrays(self) -> dict[str, Array]:
        """Return everything by name, to be written."""
        return {"U": self.U, "trust": np.array([self.limit, self.error, float(self.checked)])}

    @staticmethod
    def of(arrays: dict[str, Array]) -> Basis:
        """Return the basis that `arrays` was made from."""
        limit, error, checked = arrays["trust"].tolist()
        return Basis(arrays["U"], limit, error, int(checked))


@dataclass(frozen=True, eq=False)
class Lowest:
    """The lowest frequencies at F postures of each of G geometries."""

    lowest: Array
    """(G, F), Hz; NaN where there is no answer."""
    error: Array
    """(G, F), estimate of the relative error; 0 where the full model was used."""
    reasons: list[str]
    """Why a geometry has no frequencies, "" where it has."""


class LowestFrequencies:
    """Computes them with the fast model, and with the full one where that is not good enough."""

    def __init__(self, basis: Basis, backend: Backend) -> None:
        """Take the basis of the study."""
        self.basis = basis
        self._backend = backend
        self._fast: dict[Group, FastGeometries] = {}

    def at(self, group: Group, geometries: Sequence[Geometry], q: Array, known: Mask) -> Lowest:
        """Return the lowest frequencies at postures q (n, G, F); only at those ``known`` (G, F)."""
        q = np.where(known, q[: group.tree.n_coordinates], np.nan)
        found, error = np.full((2, *known.shape), np.nan)
        reasons = [""] * len(geometries)
        if self.basis.U.shape[1]:
            fast = self._fast_of(group)
            constants: list[Constants] = []
            fit: list[int] = []
            for g, own in enumerate(geometries):
                try:
                    constants.append(fast.constants(own.robot, own.length, own.elasticity))
                    fit.append(g)
                except LinkError as fault:
                    reasons[g] = fault.what
            found[fit], error[fit] = fast.lowest(constants, q[:, fit])
        with np.errstate(invalid="ignore"):
            doubtful = known & ~(error <= self.basis.limit)
        for g in np.flatnonzero(doubtful.any(axis=1)):
            if not reasons[g]:
                at = doubtful[g]
                found[g, at], reasons[g] = _by_full_model(geometries[g], q[:, g, at])
                error[g, at] = 0.0
        return Lowest(found, error, reasons)

    def _fast_of(self, group: Group) -> FastGeometries:
        if group not in self._fast:
            self._fast[group] = FastGeometries(
                group.tree, group.length, self.basis.U, self._backend
            )
        return self._fast[group]


def _by_full_model(geometry: Geometry, q: Array) -> tuple[Array, str]:
    """Return the lowest frequency (N,), Hz, at coordinates (n, N), and why there is none."""
    try:
        modal = ModalModel(SpanningTree.of(geometry.robot), geometry.length)
    except LinkError as fault:
        return np.full(q.shape[1], np.nan), fault.what
    found = [modes.frequencies_hz for modes in modal.at_each(q, 1)]
    return np.array([f[0] if f.size else np.nan for f in found]), ""
