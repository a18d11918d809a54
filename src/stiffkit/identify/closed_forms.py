"""The rotation's normal matrix D of special fields: Pashkevich 2009, section 3.2, cases 1 to 3.

For fields that are symmetric about their centre the sum of P^T P in equation 17 is diagonal, and
phi = D^-1 sum(p x u) needs no matrix inverse. `fit` treats every field in the same way; these forms
are what it is checked against.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.spatial.rotation import Array


def symmetric_normal(points: ArrayLike) -> Array:
    """Return the diagonal (3,) of D in m^2 for points (n, 3) in m, from their centre (case 1)."""
    p = np.asarray(points, dtype=float)
    x2, y2, z2 = ((p - p.mean(axis=0)) ** 2).sum(axis=0)
    return np.array([y2 + z2, x2 + z2, x2 + y2])


def cubic_normal(size: float, count: int) -> float:
    """Return d in m^2, D = d I, for ``count`` nodes in a regular cube of edge ``size`` in m.

    Case 2 with its ratio the right way up: d = a^2 n (N + 1) / (6 (N - 1)), N the cube root of n.
    """
    edge = np.cbrt(count)
    return float(size**2 * count * (edge + 1.0) / (6.0 * (edge - 1.0)))


def square_normal(size: float, count: int) -> Array:
    """Return the diagonal (3,) of D in m^2 for a regular square of edge ``size`` across x (case 3).

    D = diag(d, d/2, d/2) with d = a^2 n (N + 1) / (6 (N - 1)), where N is the square root of n.
    """
    edge = np.sqrt(count)
    d = size**2 * count * (edge + 1.0) / (6.0 * (edge - 1.0))
    return np.array([d, d / 2.0, d / 2.0])
