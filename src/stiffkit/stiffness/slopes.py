"""Derivatives of what is read off a compliance; see `stiffkit.stiffness.readings`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.smallmat import Tape, vector
from stiffkit.stiffness.indices import full_matrices
from stiffkit.stiffness.readings import DEFLECTIONS, STIFFNESSES

Array = NDArray[np.float64]

_BLOCKS = {
    "stiffness_translation_min": (0, 2),
    "stiffness_translation_max": (0, 0),
    "stiffness_rotation_min": (3, 2),
    "stiffness_rotation_max": (3, 0),
}
"""First row of the block of the compliance, and which of its ascending eigenvalues is meant."""


def by_compliance(name: str, lower: Array) -> Array:
    """Return the derivatives (21, N) of one of `STIFFNESSES` by the compliance's lower triangle.

    ``lower`` is (21, N), SI. A stiffness is one over an eigenvalue of a block, which changes with
    the block along its eigenvector. Where two are equal the derivative is that of one of them.
    """
    if name not in STIFFNESSES:
        raise ValueError(f"'{name}' is not read off the compliance")
    first, which = _BLOCKS[name]
    block = slice(first, first + 3)
    matrices = np.moveaxis(full_matrices(lower)[block, block], 2, 0)
    values, vectors = np.linalg.eigh(matrices)
    v = vectors[:, :, which].T
    whole = np.zeros((6, 6, lower.shape[1]))
    whole[block, block] = -v[:, None] * v[None, :] / values[:, which] ** 2
    return as_lower(whole)


def by_deflection(name: str, deflection: Array) -> Array:
    """Return the derivatives (6, N) of one of `DEFLECTIONS` by the deflections (6, N), SI.

    They are zero where the deflection is.
    """
    tape = Tape()
    d = [tape.variable(row) for row in deflection]
    with np.errstate(all="ignore"):
        size = DEFLECTIONS[name](vector(d))
    slopes = tape.gradient([(size, np.ones(deflection.shape[1]))], d)
    # The size of nothing has no slope; its root has left a NaN.
    return np.where(np.isfinite(deflection).all(axis=0), np.nan_to_num(slopes, nan=0.0), np.nan)


def as_lower(matrices: Array) -> Array:
    """Return derivatives (6, 6, N) by all entries as those (21, N) by a lower triangle's."""
    rows, columns = np.tril_indices(6)
    both = matrices[rows, columns] + matrices[columns, rows]
    return np.asarray(np.where((rows == columns)[:, None], 0.5 * both, both))
