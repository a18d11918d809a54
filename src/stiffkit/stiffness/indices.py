"""Numbers that engineers read off a compliance, for batches of postures.

Translation and rotation are never mixed: each index is of one 3x3 block, in its own unit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROWS, _COLUMNS = np.tril_indices(6)


def full_matrices(lower: Array) -> Array:
    """Return symmetric matrices (6, 6, N) of their lower triangles (21, N), row by row."""
    full = np.empty((6, 6, *lower.shape[1:]))
    full[_ROWS, _COLUMNS] = lower
    full[_COLUMNS, _ROWS] = lower
    return full


def lower_triangles(full: Array) -> Array:
    """Return the lower triangles (21, N) of symmetric matrices (6, 6, N)."""
    return np.asarray(full[_ROWS, _COLUMNS])


def entry(lower: Array, i: int, j: int) -> Array:
    """Return entry (i, j) of matrices given by their lower triangles (21, N)."""
    i, j = max(i, j), min(i, j)
    return np.asarray(lower[i * (i + 1) // 2 + j])


def deflection(lower: Array, wrench: Array) -> Array:
    """Return the deflection (6, N), m and rad, under a wrench (6,) at the tool point."""
    acting = [j for j in range(6) if wrench[j] != 0.0]
    if not acting:
        return np.zeros((6, *lower.shape[1:]))
    return np.stack(
        [np.sum([entry(lower, i, j) * wrench[j] for j in acting], axis=0) for i in range(6)]
    )


@dataclass(frozen=True, eq=False)
class Extremes:
    """Stiffness along the weakest and the strongest direction of one block."""

    weakest: Array
    """(N,), one over the largest eigenvalue of the compliance block; N/m or N m/rad."""
    strongest: Array
    """(N,), one over the smallest; infinite where a direction does not yield at all."""


def translational_stiffness(lower: Array) -> Extremes:
    """Return force over deflection along it, N/m, of a pure force in the extreme directions."""
    return _extremes(lower, 0)


def rotational_stiffness(lower: Array) -> Extremes:
    """Return moment over rotation about it, N m/rad, of a pure moment, in extreme directions."""
    return _extremes(lower, 3)


def _extremes(lower: Array, first: int) -> Extremes:
    block = [entry(lower, first + i, first + j) for i, j in _SIX]
    smallest, largest = _extreme_eigenvalues(*block)
    with np.errstate(divide="ignore"):
        # Rounding leaves some 1e-16 of the largest where a direction does not yield.
        yields = smallest > 1e-12 * largest
        strongest = np.where(yields, 1.0 / np.where(yields, smallest, 1.0), np.inf)
        strongest = np.where(np.isnan(largest), np.nan, strongest)
        return Extremes(1.0 / largest, strongest)


_SIX = ((0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1))


def _extreme_eigenvalues(
    a: Array, b: Array, c: Array, d: Array, e: Array, f: Array
) -> tuple[Array, Array]:
    """Return the smallest and largest eigenvalue of [[a, d, e], [d, b, f], [e, f, c]].

    The trigonometric closed form (O. K. Smith, Communications of the ACM 4(4), 1961), many times
    faster on a batch than LAPACK; it is good to rounding of the largest eigenvalue.
    """
    mean = (a + b + c) / 3.0
    a, b, c = a - mean, b - mean, c - mean
    spread = np.sqrt((a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f)) / 6.0)
    determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(spread > 0.0, determinant / (2.0 * spread**3), 1.0)
    angle = np.arccos(np.clip(ratio, -1.0, 1.0)) / 3.0
    largest = mean + 2.0 * spread * np.cos(angle)
    smallest = mean + 2.0 * spread * np.cos(angle + 2.0 * np.pi / 3.0)
    return smallest, largest


@dataclass(frozen=True, eq=False)
class PrincipalAxes:
    """Principal stiffnesses of one block at one posture, weakest first."""

    stiffness: Array
    """(3,), N/m or N m/rad; infinite where a direction does not yield."""
    directions: Array
    """(3, 3), a unit vector in world axes in each column."""


def principal_axes(block: Array) -> PrincipalAxes:
    """Return the principal axes of a compliance block (3, 3), translational or rotational."""
    values, vectors = np.linalg.eigh(block)
    values, vectors = values[::-1], vectors[:, ::-1]
    yields = (values > 1e-12 * values[0]) & (values > 0.0)
    stiffness = np.where(yields, 1.0 / np.where(yields, values, 1.0), np.inf)
    return PrincipalAxes(stiffness, vectors)
