"""The lowest natural frequencies of a whole robot."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator, eigsh

from stiffkit.spatial.rotation import Array
from stiffkit.verify.whole import Whole

_MASSLESS = 1e-12
"""Free motions whose mass is below this share of the largest move nothing that has any."""

_ERROR = 1e-8
"""Relative error of each solution, and of the squared frequencies."""


def lowest_frequencies(whole: Whole, n: int) -> Array:
    """Return the ``n`` lowest natural frequencies (n,), Hz, of what springs hold.

    Lanczos' method on the inverse of the stiffness. Free motions, such as a rod's spin, are of
    frequency zero and left out: every shape is orthogonal to them by the mass, so that it has no
    momentum along them. Raises `CadError` if the equations cannot be solved.
    """
    free = _of_unit_mass(whole, whole.free_motions())
    momentum = np.column_stack(
        [whole.apply_mass(z) for z in free.T] or [np.zeros((free.shape[0], 0))]
    )

    def response(load: Array) -> Array:
        x = whole.solve(load - momentum @ (free.T @ load), _ERROR)
        return np.asarray(x - free @ (momentum.T @ x))

    size = (whole.n_coordinates, whole.n_coordinates)
    start = response(whole.apply_mass(np.random.default_rng(0).standard_normal(size[0])))
    values = eigsh(
        LinearOperator(size, matvec=lambda x: x, dtype=float),
        k=n,
        M=LinearOperator(size, matvec=whole.apply_mass, dtype=float),
        sigma=0.0,
        OPinv=LinearOperator(size, matvec=response, dtype=float),
        v0=start,
        ncv=max(2 * n + 1, 12),
        tol=_ERROR,
        return_eigenvectors=False,
    )
    return np.asarray(np.sqrt(np.sort(values)) / (2.0 * np.pi))


def _of_unit_mass(whole: Whole, free: Array) -> Array:
    """Return motions (n, k) that span the massive ones of ``free``, orthonormal by the mass."""
    if not free.shape[1]:
        return free
    gram = free.T @ np.column_stack([whole.apply_mass(z) for z in free.T])
    values, vectors = eigh(gram)
    kept = values > _MASSLESS * values[-1]
    return np.asarray(free @ (vectors[:, kept] / np.sqrt(values[kept])))
