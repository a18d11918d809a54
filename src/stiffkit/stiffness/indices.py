"""Numbers that engineers read off a compliance, for batches of postures.

Translation and rotation are never mixed: each index is of one 3x3 block, in its own unit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.smallmat import Scalar, Vector, arccos, cos, reciprocal, sqrt, where_less

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
    return np.asarray(lower[_place(i, j)])


def _place(i: int, j: int) -> int:
    """Return where entry (i, j) stands in a lower triangle."""
    i, j = max(i, j), min(i, j)
    return i * (i + 1) // 2 + j


def deflection(lower: Array, wrench: Array) -> Array:
    """Return the deflection (6, N), m and rad, under a wrench (6,) at the tool point."""
    acting = [j for j in range(6) if wrench[j] != 0.0]
    if not acting:
        return np.zeros((6, *lower.shape[1:]))
    return np.stack(
        [np.sum([entry(lower, i, j) * wrench[j] for j in acting], axis=0) for i in range(6)]
    )


def extreme_stiffnesses(lower: Vector, first: int) -> tuple[Scalar, Scalar]:
    """Return the stiffness along the weakest and the strongest direction of a diagonal block.

    It is force over deflection along it, N/m, of a pure force, or moment over rotation about it,
    N m/rad, of a pure moment: one over the extreme eigenvalues of the block, infinite where a
    direction does not yield at all. ``lower`` is the compliance's lower triangle (21); ``first`` is
    the block's first row, 0 for translation and 3 for rotation.
    """
    smallest, largest = _extreme_eigenvalues(
        *(lower[_place(first + i, first + j)] for i, j in _SIX)
    )
    # Rounding leaves some 1e-16 of the largest where a direction does not yield.
    strongest = where_less(smallest, 1e-12 * largest, math.inf, reciprocal(smallest))
    return reciprocal(largest), strongest


_SIX = ((0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1))


def _extreme_eigenvalues(
    a: Scalar, b: Scalar, c: Scalar, d: Scalar, e: Scalar, f: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the smallest and largest eigenvalue of [[a, d, e], [d, b, f], [e, f, c]].

    The trigonometric closed form (O. K. Smith, Communications of the ACM 4(4), 1961), many times
    faster on a batch than LAPACK; it is good to rounding of the largest eigenvalue.
    """
    mean = (a + b + c) / 3.0
    a, b, c = a - mean, b - mean, c - mean
    spread = sqrt((a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f)) / 6.0)
    determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    # In shares of the spread, as its cube may be smaller than any number.
    unit = reciprocal(spread)
    ratio = where_less(0.0, spread, 0.5 * (determinant * unit) * unit * unit, 1.0)
    ratio = where_less(ratio, -1.0, -1.0, where_less(1.0, ratio, 1.0, ratio))
    angle = arccos(ratio) / 3.0
    largest = mean + 2.0 * spread * cos(angle)
    smallest = mean + 2.0 * spread * cos(angle + 2.0 * math.pi / 3.0)
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
