"""The closure's matrices at one posture, as plain arrays."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrcon
from threadpoolctl import ThreadpoolController

from stiffkit.kinematics.closure import ClosureEquations
from stiffkit.smallmat import as_objects

Array = NDArray[np.float64]

RANK_TOLERANCE = 1e-5
"""Singular values below this share of the largest are zero; all rows and columns are unit-free.

It is the root of `stiffkit.smallmat.ZERO_SHARE`, so that fast path and assembly call the same
postures singular: directions are parallel when they are so to 1e-5 rad. At a limit of reach loops
close to about 1e-7 rad only."""


@dataclass(frozen=True, eq=False)
class NumericEquations:
    """Residuals and derivatives at one posture, with lengths over the robot's size."""

    residuals: Array
    """(m,), unit-free."""
    jacobian: Array
    """(m, n), unit-free."""


@cache
def _blas() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Return a context in which linear algebra runs on one thread.

    On matrices of a hundred rows threads gain nothing, and lose a factor of ten where other
    processes want the cores too.
    """
    limits: AbstractContextManager[object] = _blas().limit(limits=1, user_api="blas")
    return limits


def evaluate(closure: ClosureEquations, unknowns: Array, asked: Array) -> NumericEquations:
    """Return the equations at unknowns (n,) and tool coordinates asked for (m,), both SI."""
    inputs = as_objects(np.concatenate([unknowns, asked]))
    eq = closure.equations(inputs, as_objects(closure.constants.values))
    scales = np.where(closure.translates, closure.length, 1.0)
    residuals = np.array(eq.residuals, dtype=float)
    jacobian = np.array(eq.jacobian, dtype=float).reshape(residuals.size, closure.n_unknowns)
    return NumericEquations(residuals, jacobian * scales)


def null_space(A: Array) -> Array:
    """Return an orthonormal basis (n, k) of the null space of A (m, n)."""
    m, n = A.shape
    if m == 0 or n == 0:
        return np.eye(n)
    # A QR factorisation costs a fraction of the singular values, which are looked at only where the
    # triangle's condition leaves the rank in doubt.
    Q, R = np.linalg.qr(A.T if m < n else A, mode="complete" if m < n else "reduced")
    if _surely_regular(R[: min(m, n)]):
        return np.asarray(Q[:, m:]) if m < n else np.zeros((n, 0))
    _, values, Vt = np.linalg.svd(A)
    return np.asarray(Vt[rank_of(values) :].T)


def _surely_regular(R: Array) -> bool:
    """Tell whether an upper triangular matrix is far from singular."""
    reciprocal_condition, _ = dtrcon(R)
    return bool(reciprocal_condition > 100.0 * RANK_TOLERANCE)


def rank_of(singular_values: Array) -> int:
    """Return the number of singular values that are not zero."""
    if singular_values.size == 0 or singular_values[0] == 0.0:
        return 0
    return int(np.sum(singular_values > RANK_TOLERANCE * max(singular_values[0], 1e-3)))


def rank(A: Array) -> int:
    """Return the numeric rank of a matrix."""
    return rank_of(np.asarray(np.linalg.svd(A, compute_uv=False))) if A.size else 0
