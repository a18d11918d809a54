"""A rigid fit that outliers do not pull: an M-estimator by `scipy.optimize.least_squares`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from stiffkit.identify.estimators import RigidFit, fit, reference_point
from stiffkit.identify.field import Field
from stiffkit.identify.moments import skew_matrices
from stiffkit.identify.residuals import residuals
from stiffkit.identify.statistics import ROUNDING
from stiffkit.spatial.rotation import Array

MAD_TO_SIGMA = 1.4826
"""Standard deviation of a normal variable over its median absolute value."""
SOFT_L1_TUNING = 1.345
"""Standard deviations at which the first loss bends from squares to absolute values."""
BISQUARE_TUNING = 4.685
"""Standard deviations from which a residual counts for nothing; 95 % efficient for normal noise."""
OUTLIER = 4.0
"""Residuals beyond this many standard deviations count as outliers."""
LEAST_SCALE = 1e-3
"""Least scale of the residuals, over their root mean square."""


Loss = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class RobustFit:
    """A robust rigid motion of each of m load cases."""

    fitted: RigidFit
    sigma: Array
    """(m,), m: standard deviation of normal noise that would leave the estimate as uncertain."""
    outliers: NDArray[np.bool_]
    """(m, n), nodes with a residual beyond four standard deviations."""


def robust_fit(field: Field, reference: ArrayLike) -> RobustFit:
    """Return the robust LIN fit of every load case, reported at ``reference`` (3,) in m.

    Each of a node's three residuals counts by Tukey's bisquare loss, which outliers far off do not
    pull at all. It starts from, and takes its scale from the median residual of, a first fit with
    the convex soft-l1 loss. See P. Huber, E. Ronchetti, "Robust Statistics", 2nd edition, 2009,
    chapters 4 and 7. Each load case of a million nodes takes about 15 s and 1 GB.
    """
    point = reference_point(reference)
    start = fit(field, point)
    found = [_robust_case(field, start, j) for j in range(field.case_count)]
    twists = np.stack([correction for correction, _, _ in found])
    mean, rotation = start.mean + twists[:, :3], start.rotation + twists[:, 3:]
    gradient = skew_matrices(rotation)
    translation = mean + gradient @ (point - start.centre)
    return RobustFit(
        RigidFit("LIN", point, translation, rotation, start.centre, mean, gradient),
        np.array([sigma for _, sigma, _ in found]),
        np.stack([outliers for _, _, outliers in found]),
    )


def _robust_case(field: Field, start: RigidFit, j: int) -> tuple[Array, float, NDArray[np.bool_]]:
    """Return the correction (6,) at the centre, sigma and the outliers (n,) of one load case."""
    one = field.case(j)
    r = residuals(one, start.case(j))[0]
    moved = float(np.linalg.norm(start.mean[j]) + np.linalg.norm(start.gradient[j]))
    rms = float(np.sqrt(np.mean(r * r)))
    if rms <= ROUNDING * moved:
        return np.zeros(6), rms, np.zeros(field.node_count, dtype=bool)
    J = _jacobian(field)
    weights = np.repeat(field.relative_weights, 3)
    scale = _scale(r.ravel(), rms)
    x = np.zeros(6)
    for loss, tuning in ((_soft_l1, SOFT_L1_TUNING), (_bisquare, BISQUARE_TUNING)):
        c = tuning * scale
        x = _minimise(J, r.ravel(), x, weights, loss, c)
        left = r.ravel() - J @ x
        scale = _scale(left, rms)
    correction = x / np.repeat([1.0, field.spread.radius], 3)
    outliers = (np.abs(left) > OUTLIER * scale).reshape(-1, 3).any(axis=1)
    return correction, _equivalent_sigma(left, c), outliers


def _minimise(J: Array, r: Array, start: Array, weights: Array, loss: Loss, c: float) -> Array:
    """Return x (6,) of least weighted loss of (r - J x) / c."""

    def misfit(x: Array) -> Array:
        return (r - J @ x) / c

    def slope(_: Array) -> Array:
        return J / -c

    def weighted(z: Array) -> Array:
        return weights * loss(z)

    return np.asarray(least_squares(misfit, start, slope, loss=weighted, x_scale=c).x)


def _jacobian(field: Field) -> Array:
    """Return displacements (3n, 6) by a translation and by a rotation times the field's radius."""
    p = (field.points - field.spread.centre) / field.spread.radius
    J = np.zeros((len(p), 3, 6))
    J[:, :, :3] = np.eye(3)
    J[:, :, 3:] = skew_matrices(p).mT
    return J.reshape(-1, 6)


def _scale(values: Array, rms: float) -> float:
    """Return the standard deviation of the bulk of the values."""
    return max(MAD_TO_SIGMA * float(np.median(np.abs(values))), LEAST_SCALE * rms)


def _soft_l1(z: Array) -> Array:
    """Return 2 (sqrt(1 + z) - 1) and its first two derivatives: (3, k)."""
    root = np.sqrt(1.0 + z)
    return np.stack([2.0 * (root - 1.0), 1.0 / root, -0.5 / root**3])


def _bisquare(z: Array) -> Array:
    """Return (1 - (1 - z)^3) / 3, constant from z = 1, and its first two derivatives: (3, k)."""
    inside = np.maximum(1.0 - z, 0.0)
    return np.stack([(1.0 - inside**3) / 3.0, inside**2, -2.0 * inside])


def _equivalent_sigma(values: Array, c: float) -> float:
    """Return the sigma that the bisquare estimate amounts to (Huber and Ronchetti, 7.6)."""
    z = np.square(values / c)
    inside = np.maximum(1.0 - z, 0.0)
    influence, slope = values * inside**2, inside * (1.0 - 5.0 * z)
    freedom = len(values) / (len(values) - 6.0)
    return float(np.sqrt(freedom * np.mean(influence**2)) / np.mean(slope))
