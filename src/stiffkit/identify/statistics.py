"""How well a rigid fit is known: Pashkevich 2009, section 3.4, for any weighted field.

The noise is taken as independent, of the same standard deviation sigma at every node and along
every axis. A weight says how much a node counts, not how noisy it is. With equal weights all of
this is the paper's: 3n - 6 degrees of freedom (equation 21), and the covariance of equation 20.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffkit.identify.field import Field
from stiffkit.identify.moments import chunks, gyration, homogeneous
from stiffkit.spatial import skew, twist_shift
from stiffkit.spatial.rotation import Array

ROUNDING = 4.0 * np.finfo(float).eps
"""What sums of double-precision numbers can be trusted to, relative to the largest."""


@dataclass(frozen=True, eq=False)
class Precision:
    """What the layout of a field makes of noise of sigma = 1 m."""

    unit_covariance: Array
    """(6, 6), covariance of (translation at the reference point; rotation)."""
    squares_per_variance: float
    """Expected sum of w |r|^2 of the residuals (weights of mean 1); 3n - 6 for equal weights."""
    degrees_of_freedom: float
    """Of the sigma from these residuals (Satterthwaite); 3n - 6 for equal weights."""
    rounding: Array
    """(6, 6), covariance that the rounding of displacements of 1 m would make up."""


def precision(field: Field, reference: Array) -> Precision:
    """Return the precision of a rigid fit to a field, reported at ``reference`` (3,) in m."""
    spread = field.spread
    # In lengths of the field's radius the matrices are well scaled.
    first, second, third = normal_matrices(field)
    inverse = np.linalg.inv(first)
    unit = inverse @ second @ inverse
    total = 3.0 * field.node_count
    squared = 3.0 * float(np.square(field.relative_weights).sum())
    squares = total - float(np.trace(inverse @ second))
    spread_of_squares = (
        squared
        - 2.0 * float(np.trace(inverse @ third))
        + float(np.trace(np.linalg.matrix_power(inverse @ second, 2)))
    )
    scale = np.repeat([1.0, 1.0 / spread.radius], 3)
    X = twist_shift(reference - spread.centre) * scale
    return Precision(X @ unit @ X.T, squares, squares**2 / spread_of_squares, ROUNDING**2 * X @ X.T)


def normal_matrices(field: Field) -> list[Array]:
    """Return the sums of w X^T X, w^2 X^T X and w^3 X^T X, each 6x6.

    A node moves by X (translation; rotation) about the field's centre, the weights have the mean 1,
    and lengths are in radii of the field. The first is the inverse of the matrix in equation 17.
    """
    spread = field.spread
    grams = np.zeros((3, 4, 4))
    for at in chunks(field.node_count):
        X = homogeneous(field.points[at], spread.centre)
        weighted = X
        for gram in grams:
            weighted = field.relative_weights[at, None] * weighted
            gram += X.T @ weighted
    return [_normal_matrix(gram, spread.radius) for gram in grams]


def _normal_matrix(gram: Array, radius: float) -> Array:
    """Return the sum of w X^T X (6, 6) from that of w (1, p)^T (1, p), (4, 4)."""
    first, second = gram[0, 1:] / radius, gram[1:, 1:] / radius**2
    return np.block([[gram[0, 0] * np.eye(3), -skew(first)], [skew(first), gyration(second)]])


def noise(squares: Array, known: Precision) -> Array:
    """Return sigma (m,) in m of each load case from its sum of squared residuals (equation 21)."""
    return np.asarray(np.sqrt(squares / known.squares_per_variance))


def compliance_covariance(deflection_covariances: Array, load_inverse: Array) -> Array:
    """Return the covariance (36, 36) of k = D L^+, its elements taken row by row.

    ``deflection_covariances`` (m, 6, 6) are those of the columns of D, which are independent;
    ``load_inverse`` (m, 6) is L^+.
    """
    Q, P = deflection_covariances, load_inverse
    return np.asarray(np.einsum("jil,ja,jb->ialb", Q, P, P)).reshape(36, 36)


def symmetric_covariance(covariance: Array) -> Array:
    """Return the covariance (36, 36) of (k + k^T) / 2 from that of k."""
    C = covariance.reshape(6, 6, 6, 6)
    half = (C + C.transpose(1, 0, 2, 3)) / 2.0
    return np.asarray((half + half.transpose(0, 1, 3, 2)) / 2.0).reshape(36, 36)


def standard_errors(covariance: Array) -> Array:
    """Return the standard deviations (6, 6) of 36 elements from their covariance (36, 36)."""
    return np.sqrt(np.diag(covariance)).reshape(6, 6)
