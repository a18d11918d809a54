"""The lowest modes of a large system, found by Lanczos' method from its response to loads."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from stiffkit.spatial.rotation import Array

Operator = Callable[[Array], Array]
"""What takes coordinates (n,) to loads, or loads to coordinates."""


def lowest_modes(
    mass: Operator,
    response: Operator,
    size: int,
    n_modes: int,
    *,
    n_vectors: int | None = None,
    error: float = 0.0,
) -> tuple[Array, Array]:
    """Return squared angular frequencies (k,), ascending, and shapes (size, k) of unit modal mass.

    ``response`` is the inverse of the stiffness, where need be on a subspace: the search starts in
    its range and never leaves it. ``n_vectors`` is how many Lanczos vectors are kept, more than
    ``n_modes``, SciPy's choice if None; ``error`` the relative one of the squared frequencies, that
    of rounding if 0.
    """
    shape = (size, size)
    start = response(mass(np.random.default_rng(0).standard_normal(size)))
    values, shapes = eigsh(
        # Only the inverse is applied, but the size is read from here.
        LinearOperator(shape, matvec=lambda x: x, dtype=float),
        k=n_modes,
        M=LinearOperator(shape, matvec=mass, dtype=float),
        sigma=0.0,
        OPinv=LinearOperator(shape, matvec=response, dtype=float),
        v0=start,
        ncv=n_vectors,
        tol=error,
    )
    order = np.argsort(values)
    return values[order], shapes[:, order]
