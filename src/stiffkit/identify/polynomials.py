"""Regression of residuals on polynomials of position."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from scipy.special import fdtrc

from stiffkit.identify.estimators import RigidFit
from stiffkit.identify.field import Field
from stiffkit.identify.residuals import residual_pieces
from stiffkit.spatial.rotation import Array

INDEPENDENT = 1e-9
"""Polynomials whose scaled Gram matrix has a smaller eigenvalue say nothing new on these nodes."""


@dataclass(frozen=True, eq=False)
class Regression:
    """Residuals of m load cases on polynomials of the second degree in the field's d coordinates.

    Coordinates are along the principal axes, in extents; a plane field has d = 2, a volume 3.
    Components of residuals are along the principal axes, too.
    """

    squares: Array
    """(m, 3), m^2: sum of w r^2, weights of mean 1."""
    linear: Array
    """(m, 3), m^2: what linear polynomials explain of that."""
    quadratic: Array
    """(m, 3), m^2: what quadratic polynomials explain beyond."""
    slopes: Array
    """(m, d, 3), m per extent: the linear polynomials' slopes, without quadratic ones beside."""
    coefficients: Array
    """(m, p, 3), m: of all p polynomials in the order of `basis`."""
    p_value: Array
    """(m,): chance that noise looks as structured as this (F-test); nan with too few nodes."""


def basis(field: Field, points: Array) -> Array:
    """Return the polynomials (c, p) at points (c, 3) in m: 1, then linear, then quadratic ones."""
    spread = field.spread
    d = spread.dimension
    q = (points - spread.centre) @ (spread.axes[:, :d] / spread.extents[:d])
    pairs = combinations_with_replacement(range(d), 2)
    return np.column_stack([np.ones(len(q)), q, *(q[:, i] * q[:, j] for i, j in pairs)])


def regress(field: Field, fitted: RigidFit) -> Regression:
    """Regress the residuals of a fit; the F-test is exact for normal noise and equal weights."""
    gram, moments, squares = _sums(field, fitted)
    first = 1 + field.spread.dimension
    slopes, linear, _ = _least_squares(gram[:first, :first], moments[:, :first])
    coefficients, explained, rank = _least_squares(gram, moments)
    # The rigid motion's 6 parameters are among those of the polynomials.
    more, left = 3 * rank - 6, 3 * (field.node_count - rank)
    if left > 0:
        gained, total = explained.sum(axis=1), squares.sum(axis=1)
        noise = np.maximum(total - gained, np.finfo(float).tiny)
        p_value = np.asarray(fdtrc(more, left, gained / more * left / noise))
    else:
        p_value = np.full(field.case_count, np.nan)
    quadratic = np.maximum(explained - linear, 0.0)
    return Regression(squares, linear, quadratic, slopes[:, 1:], coefficients, p_value)


def _sums(field: Field, fitted: RigidFit) -> tuple[Array, Array, Array]:
    """Return the Gram matrix (p, p), the moments (m, p, 3) and the squares (m, 3)."""
    size = basis(field, field.points[:1]).shape[1]
    gram, moments = np.zeros((size, size)), np.zeros((field.case_count, size, 3))
    squares = np.zeros((field.case_count, 3))
    for at, piece in residual_pieces(field, fitted):
        along = piece @ field.spread.axes
        B = basis(field, field.points[at])
        weight = field.relative_weights[at]
        weighted = (weight[:, None] * B).T
        gram += weighted @ B
        moments += weighted @ along
        squares += weight @ (along * along)
    return gram, moments, squares


def _least_squares(gram: Array, moments: Array) -> tuple[Array, Array, int]:
    """Return coefficients (m, p, 3), what they explain (m, 3), and how many are independent."""
    scale = 1.0 / np.sqrt(np.diag(gram))
    values, vectors = np.linalg.eigh(gram * np.outer(scale, scale))
    kept = values > INDEPENDENT
    root = scale[:, None] * vectors[:, kept] / np.sqrt(values[kept])
    projected = root.T @ moments
    return root @ projected, np.square(projected).sum(axis=1), int(kept.sum())
