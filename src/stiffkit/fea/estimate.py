"""How far a compliance still is from that of the exact solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import geometric_mean

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from stiffkit.spatial.rotation import Array

_RATIOS = (0.35, 0.9)
"""Ratios of successive errors that are believed."""

_USUAL_RATIO = 0.6
"""The ratio as long as nothing is known."""

_CAUTION = 1.25
"""At the singular edges that every clamped face has, convergence slows down as it goes on."""

_BENDING = 3.0
"""The stiffness of a plate goes with this power of its thickness."""


def relative_difference(difference: Array, compliance: Array) -> float:
    """Return the largest relative difference (n, n) of a compliance (n, n), over all wrenches.

    That is the largest ``|w^T D w| / (w^T C w)``. It bounds each element against its diagonal ones,
    ``|D_ij| / sqrt(C_ii C_jj)``, and depends on no choice of axes, point or unit of length.
    """
    return float(np.abs(np.linalg.eigvalsh(whitened(difference, compliance))).max())


def whitened(matrix: Array, compliance: Array) -> Array:
    """Return a matrix (n, n) in the coordinates in which the compliance is the identity."""
    W = whitening(compliance)
    out = W.T @ matrix @ W
    return np.asarray(0.5 * (out + out.T))


def whitening(compliance: Array) -> Array:
    """Return W (n, n), whose columns are wrenches of unit work: ``W^T C W`` is the identity."""
    scale = 1.0 / np.sqrt(np.diag(compliance))
    L = cholesky(compliance * np.outer(scale, scale), lower=True)
    return np.asarray(scale[:, None] * solve_triangular(L, np.eye(len(L)), lower=True).T)


@dataclass(frozen=True)
class Convergence:
    """How successive solutions converge."""

    error: float
    """Estimated relative error of the last one, over all wrenches; inf if nothing is known."""
    ratio: float
    """Of its error to that of the solution before."""
    change: float
    """Its relative difference from the solution before, over all wrenches."""


def convergence(compliances: Sequence[Array]) -> Convergence:
    """Estimate the relative error of the last of successive compliances.

    Where each solution adds what promises most of the gain, errors fall like a geometric series
    (W. Doerfler, "A convergent adaptive algorithm for Poisson's equation", SIAM J. Numer. Anal. 33,
    1996), whose ratio is that of successive changes; the mean of the last two is taken. The first
    solution is too coarse to tell a ratio from. With two solutions a usual ratio is taken; with
    one, the error is unknown (inf). Errors are the largest over all wrenches, see
    `relative_difference`.
    """
    if len(compliances) < 2:
        return Convergence(float("inf"), _USUAL_RATIO, float("inf"))
    last = compliances[-1]
    changes = [relative_difference(b - a, last) for a, b in pairwise(compliances)]
    ratios = [b / a for a, b in pairwise(changes[1:]) if a > 0.0]
    ratio = float(np.clip(geometric_mean(ratios[-2:] or [_USUAL_RATIO]), *_RATIOS))
    error = _CAUTION * changes[-1] * ratio / (1.0 - ratio)
    return Convergence(error, ratio, changes[-1])


def geometry_error(volume_error: float, area_error: float) -> float:
    """Return an estimate of the relative error of a compliance by the mesh's shape.

    From the relative errors of volume and surface of the mesh against the part. Where the mesh is
    too thin by a share, a bent wall is too soft by three times that.
    """
    return _BENDING * abs(volume_error) + 0.25 * abs(area_error)
