"""How far a compliance still is from that of the exact solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import brentq

from stiffkit.spatial.rotation import Array

_RATES = (0.25, 1.25)
"""Orders of convergence in the number of unknowns that are believed. As the order rises the error
first falls much faster, and then at the slow rate of the singular edges that every clamped face
has: seen too late, that made estimates two times too small."""

_USUAL_RATE = 0.85
"""The order of convergence that is expected as long as nothing is known; real parts of thin walls
were seen to begin with 0.9 to 1.2."""

_LARGEST_DROP = 40.0
"""From one solution to the next the change falls by no more than this."""

_GROWTH = 1.2
"""Steps that add fewer unknowns tell nothing of convergence."""

_SIZE_POWER = 0.35
"""The size goes with this power of the error that an element may have: between 1/2, right at edges
as singular as a crack, and the 1/(2 p + 3) of smooth solutions."""

_FINEST = 4.0
"""How many times smaller elements may become at once."""

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
    rate: float
    """The error falls with the number of unknowns to this power."""

    def predict(self, growth: float) -> float:
        """Return the error to expect with so many times the unknowns."""
        return float(self.error * growth**-self.rate)


def convergence(unknowns: Sequence[int], compliances: Sequence[Array]) -> Convergence:
    """Estimate the relative error of the last of successive compliances.

    The error of a Galerkin solution falls with a power of the number of unknowns N, and from three
    solutions power and limit follow (B. Szabo, I. Babuska, Finite Element Analysis, 1991, section
    4.3). With two, a usual power is taken; with one, the error is unknown (inf). The error is the
    largest over all wrenches, see `relative_difference`.
    """
    if len(compliances) < 2:
        return Convergence(float("inf"), _USUAL_RATE)
    last = compliances[-1]
    change = relative_difference(last - compliances[-2], last)
    n1, n2 = float(unknowns[-2]), float(unknowns[-1])
    if n2 < _GROWTH * n1:
        return Convergence(change, _USUAL_RATE)
    rate = _USUAL_RATE
    if len(compliances) > 2 and n1 >= _GROWTH * unknowns[-3]:
        before = relative_difference(compliances[-2] - compliances[-3], last)
        if before > 0.0:
            # A change that happened to be small is no proof of convergence.
            change = max(change, before / _LARGEST_DROP)
            rate = _rate(float(unknowns[-3]), n1, n2, change / before)
    return Convergence(change / ((n2 / n1) ** rate - 1.0), rate)


def _rate(n0: float, n1: float, n2: float, ratio: float) -> float:
    """Return the order of convergence that makes successive changes have the given ratio."""
    low, high = _RATES

    def excess(rate: float) -> float:
        return float((n1**-rate - n2**-rate) / (n0**-rate - n1**-rate) - ratio)

    if excess(low) <= 0.0:
        return low
    if excess(high) >= 0.0:
        return high
    return float(brentq(excess, low, high))


def geometry_error(volume_error: float, area_error: float) -> float:
    """Return an estimate of the relative error of a compliance by the mesh's shape.

    From the relative errors of volume and surface of the mesh against the part. Where the mesh is
    too thin by a share, a bent wall is too soft by three times that.
    """
    return _BENDING * abs(volume_error) + 0.25 * abs(area_error)


def wanted_sizes(sizes: Array, energies: Array, growth: float) -> Array:
    """Return the element sizes (e,) that spread the error evenly over the elements.

    From the elements' sizes (e,) and the energies (e,) of their errors. The more an element has
    than its share, the smaller its successors, down to a quarter; none becomes larger. The share is
    chosen so that about ``growth`` times as many elements result. O. C. Zienkiewicz, J. Z. Zhu, "A
    simple error estimator and adaptive procedure", Int. J. Numer. Meth. Eng. 24, 1987.
    """
    energies = np.maximum(energies, energies.max() * 1e-12)

    def finer(share: float) -> Array:
        return np.asarray(np.clip((energies / share) ** _SIZE_POWER, 1.0, _FINEST))

    low, high = np.log(energies.min()), np.log(energies.max())
    for _ in range(60):
        middle = 0.5 * (low + high)
        if np.mean(finer(np.exp(middle)) ** 3) > growth:
            low = middle
        else:
            high = middle
    return np.asarray(sizes / finer(np.exp(high)))
