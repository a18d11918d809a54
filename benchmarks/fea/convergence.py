"""Errors against a reference, and what a method of known convergence takes to reach one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffkit.fea import relative_difference
from stiffkit.spatial.rotation import Array

_FITTED = 3
"""Of the finest meshes, those that a rate of convergence is taken from."""

_GROWTH = (1.0, 2.0)
"""Powers of the unknowns that the time of a direct solution goes with, at least and at most: the
square is what nested dissection takes in three dimensions (A. George, "Nested dissection of a
regular finite element mesh", SIAM J. Numer. Anal. 10(2), 1973)."""


@dataclass(frozen=True)
class Errors:
    """Relative errors of a compliance."""

    wrenches: float
    """The largest over all wrenches, which is what the adaptive loop estimates."""
    elements: float
    """The largest of the elements, |D_ij| / sqrt(C_ii C_jj); never larger than the other."""


def errors(compliance: Array, reference: Array) -> Errors:
    """Return the errors of a compliance (6, 6)."""
    D = compliance - reference
    scale = np.sqrt(np.diag(reference))
    return Errors(
        relative_difference(0.5 * (D + D.T), reference),
        float(np.max(np.abs(D) / np.outer(scale, scale))),
    )


@dataclass(frozen=True)
class Reached:
    """What it takes to reach an error."""

    unknowns: float
    cpu: float
    """s of processors."""
    extrapolated: bool
    """Whether no mesh that was solved is that fine."""


def reach(unknowns: Array, errors: Array, cpu: Array, target: float) -> Reached:
    """Return what it takes to reach an error, from meshes (m,), the coarsest first.

    Between two meshes it is interpolated, beyond the finest extrapolated, both as powers: error and
    processor seconds over unknowns. If the coarsest mesh will do, that is taken.
    """
    n, e, t = np.log(unknowns), np.log(errors), np.log(cpu)
    good = np.flatnonzero(e <= np.log(target))
    if len(good) and good[0] == 0:
        return Reached(float(unknowns[0]), float(cpu[0]), extrapolated=False)
    if len(good):
        pair = slice(good[0] - 1, good[0] + 1)
        share = (np.log(target) - e[pair][0]) / (e[pair][1] - e[pair][0])
        at_n, at_t = (float(x[pair][0] + share * (x[pair][1] - x[pair][0])) for x in (n, t))
        return Reached(float(np.exp(at_n)), float(np.exp(at_t)), extrapolated=False)
    rate = np.polyfit(n[-_FITTED:], e[-_FITTED:], 1)[0]
    growth = float(np.clip(np.polyfit(n, t, 1)[0], *_GROWTH))
    if rate >= 0.0:
        return Reached(float("inf"), float("inf"), extrapolated=True)
    further = (np.log(target) - e[-1]) / rate
    return Reached(
        float(np.exp(n[-1] + further)), float(np.exp(t[-1] + growth * further)), extrapolated=True
    )
