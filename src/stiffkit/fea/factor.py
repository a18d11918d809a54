"""Sparse symmetric systems, factorised."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import coo_array

from stiffkit.fea.threads import idle_cores, threads
from stiffkit.spatial.rotation import Array


class Factor:
    """The factorisation L D L^T of a symmetric matrix, without pivoting.

    For that the matrix must be quasi-definite: a positive definite block of some unknowns, a
    negative definite one of the others, and anything between the two. R. J. Vanderbei, "Symmetric
    quasidefinite matrices", SIAM J. Optim. 5(1), 1995.
    """

    def __init__(self, lower: coo_array) -> None:
        """Factorise the matrix (n, n) of which ``lower`` is the lower triangle."""
        from ngsolve.la import SparseMatrixd

        n = lower.shape[0]
        self._n_threads = idle_cores()
        self._matrix: Any = SparseMatrixd.CreateFromCOO(
            indi=lower.row.astype(np.int32),
            indj=lower.col.astype(np.int32),
            values=lower.data,
            h=n,
            w=n,
        )
        with threads(self._n_threads):
            self._inverse: Any = self._matrix.Inverse(inverse="sparsecholesky")

    def solve(self, load: Array) -> Array:
        """Return the solution (n,) for a right-hand side (n,)."""
        vector = self._matrix.CreateColVector()
        vector.FV().NumPy()[:] = load
        with threads(self._n_threads):
            found = (self._inverse * vector).Evaluate()
        return np.array(found.FV().NumPy())
