"""Elimination in small symmetric matrices: factors, inverses, released directions.

Whether a pivot is zero is judged by its share of what the entry was before elimination. That share
(one minus the squared multiple correlation) has no unit and does not change when rows and columns
are scaled, so newtons per metre and newton metres per radian can stand in one matrix. An entry that
an earlier elimination left is no measure if it is itself rounding; then the one before that is.
"""

from __future__ import annotations

from dataclasses import dataclass

from stiffkit.smallmat.matrix import (
    Matrix,
    Vector,
    dot,
    matmul,
    outer_sum,
    symmetric,
    vector,
    zeros,
)
from stiffkit.smallmat.scalars import (
    Scalar,
    is_structural,
    multiply,
    reciprocal,
    subtract,
    where_less,
)

ZERO_SHARE = 1e-10
"""A pivot with a smaller share of its original entry is zero: two directions are then parallel to
1e-5 rad, far above rounding and far below anything a machine is built to."""


@dataclass(frozen=True)
class Factors:
    """``S = L D L^T`` of a symmetric positive definite matrix, L unit lower triangular."""

    L: Matrix
    pivots: Vector
    inverse_pivots: Vector
    shares: Vector
    """Pivot over what it is judged against; near 0 where S is singular."""

    def solve_half(self, b: Vector) -> Vector:
        """Return ``L^-1 b``."""
        x = list(b)
        for i in range(len(x)):
            for k in range(i):
                x[i] = subtract(x[i], multiply(self.L[i, k], x[k]))
        return vector(x)

    def solve(self, b: Vector) -> Vector:
        """Return ``S^-1 b``."""
        n = len(b)
        half = self.solve_half(b)
        x = [multiply(d, value) for d, value in zip(self.inverse_pivots, half, strict=True)]
        for i in reversed(range(n)):
            for k in range(i + 1, n):
                x[i] = subtract(x[i], multiply(self.L[k, i], x[k]))
        return vector(x)

    def inverse(self) -> Matrix:
        """Return ``S^-1``."""
        n = len(self.pivots)
        W = _unit_lower_inverse(self.L)
        DW = zeros(n, n)
        for i in range(n):
            for j in range(i + 1):
                DW[i, j] = multiply(self.inverse_pivots[i], W[i, j])
        return symmetric(n, lambda i, j: dot(W[i:, i], DW[i:, j]))


def factor(S: Matrix, *, scale: Vector | None = None, semidefinite: bool = False) -> Factors:
    """Return the factors of a symmetric matrix.

    Pivots are judged against ``scale`` (n,), or the diagonal of S if it is not given; give it where
    an entry of the diagonal may itself be no more than rounding. With ``semidefinite`` a zero pivot
    (see `ZERO_SHARE`) is skipped: its unknown is set to zero in `Factors.solve`, which gives one of
    the solutions where the right side is in the range of S.
    """
    n = S.shape[0]
    if scale is None:
        scale = vector(S[i, i] for i in range(n))
    L, scaled = zeros(n, n), zeros(n, n)
    pivots, inverse_pivots, shares = zeros(n), zeros(n), zeros(n)
    for j in range(n):
        for i in range(j, n):
            rest = S[i, j]
            for k in range(j):
                rest = subtract(rest, multiply(L[i, k], scaled[j, k]))
            if i == j:
                pivots[j] = rest
                shares[j] = _share(rest, scale[j])
                inverse_pivots[j] = (
                    _reciprocal_or_zero(rest, shares[j]) if semidefinite else reciprocal(rest)
                )
                L[j, j] = 1.0
            else:
                scaled[i, j] = rest
                L[i, j] = multiply(rest, inverse_pivots[j])
    return Factors(L, pivots, inverse_pivots, shares)


def release(K: Matrix, directions: list[Vector], *, scale: Vector | None = None) -> Matrix:
    """Return the stiffness K with motion along ``directions`` made free.

    ``K <- K - (K u)(K u)^T / (u^T K u)`` for each direction, skipped where ``u^T K u`` has become
    zero because the direction is already free through the others. This is the static condensation
    of passive joints: the 6x6 block of the inverse of [[S, J], [J^T, 0]] (Briot et al. 2009,
    eq. 3; Pashkevich et al. 2009, "Stiffness analysis of overconstrained parallel manipulators").

    K is positive definite; where it may have free motions of its own, give as ``scale`` (6,) the
    diagonal that it had before those were released.
    """
    if scale is None:
        before = [dot(u, matmul(K, u)) for u in directions]
    else:
        before = [dot(vector(multiply(x, x) for x in u), scale) for u in directions]
    for u, locked in zip(directions, before, strict=True):
        Ku = matmul(K, u)
        uKu = dot(u, Ku)
        weight = _reciprocal_or_zero(uKu, _share(uKu, locked))
        K = outer_sum(K, Ku, multiply(-1.0, weight))
    return K


def soften(K: Matrix, direction: Vector, compliance: Scalar) -> Matrix:
    """Return the stiffness K in series with a compliance along one direction.

    With compliance c along u this is ``K - (K u)(K u)^T / (u^T K u + 1/c)``, written so that c may
    be zero.
    """
    Ku = matmul(K, direction)
    uKu = dot(direction, Ku)
    weight = multiply(compliance, reciprocal(1.0 + multiply(compliance, uKu)))
    return outer_sum(K, Ku, multiply(-1.0, weight))


def series(K1: Matrix, K2: Matrix, scale: Vector) -> Matrix:
    """Return the stiffness of two stiffnesses in series, ``K1 - K1 (K1 + K2)^+ K1``.

    Give the one with free motions first: its free motions stay free exactly. ``scale`` (6,) is the
    diagonal of their sum before any free motions were released.
    """
    total = symmetric(6, lambda i, j: K1[i, j] + K2[i, j])
    factors = factor(total, scale=scale, semidefinite=True)
    columns = [factors.solve(K1[:, j]) for j in range(6)]
    return symmetric(6, lambda i, j: subtract(K1[i, j], dot(K1[i], columns[j])))


def _share(rest: Scalar, before: Scalar) -> Scalar:
    if is_structural(before, 0.0):
        return 0.0
    empty = where_less(0.0, before, 0.0, 1.0)
    return (1.0 - empty) * rest / (before + empty)


def _reciprocal_or_zero(pivot: Scalar, share: Scalar) -> Scalar:
    if is_structural(share, 0.0):
        return 0.0
    zero = where_less(ZERO_SHARE, share, 0.0, 1.0)
    return (1.0 - zero) / (pivot + zero * (1.0 - pivot))


def _unit_lower_inverse(L: Matrix) -> Matrix:
    n = L.shape[0]
    W = zeros(n, n)
    for j in range(n):
        W[j, j] = 1.0
        for i in range(j + 1, n):
            W[i, j] = multiply(-1.0, dot(L[i, j:i], W[j:i, j]))
    return W
