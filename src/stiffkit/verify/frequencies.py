"""The lowest natural frequencies of a whole robot."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from stiffkit.fea.lanczos import lowest_modes
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
    free, momentum = _of_unit_mass(whole)

    def response(load: Array) -> Array:
        x = whole.solve(load - momentum @ (free.T @ load), _ERROR)
        return np.asarray(x - free @ (momentum.T @ x))

    values, _ = lowest_modes(
        whole.apply_mass,
        response,
        whole.n_coordinates,
        n,
        n_vectors=max(2 * n + 1, 12),
        error=_ERROR,
    )
    return np.asarray(np.sqrt(values) / (2.0 * np.pi))


def _of_unit_mass(whole: Whole) -> tuple[Array, Array]:
    """Return free motions (n, k), orthonormal by the mass, and their momenta (n, k).

    They span all free motions but those that move no mass.
    """
    free = whole.free_motions
    if not free.shape[1]:
        return free, free
    momentum = np.column_stack([whole.apply_mass(z) for z in free.T])
    values, vectors = eigh(free.T @ momentum)
    kept = values > _MASSLESS * values[-1]
    unit = vectors[:, kept] / np.sqrt(values[kept])
    return free @ unit, momentum @ unit
