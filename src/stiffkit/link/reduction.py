"""Reduction of a structure to its ports and modes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.spatial.rotation import Array

_MASSLESS = 1e-12
"""Modes whose squared period is below this share of the longest one have no mass but rounding."""

_EQUAL = 1e-7
"""Squared frequencies as near as this, over their size, are equal."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """A structure in coordinates of its ports (p) and of modes with the ports held (n).

    At rest the modes carry no load, so the stiffness is that of the ports beside the modes' own.
    """

    stiffness: Array
    """(p, p), of the ports."""
    mode_stiffness: Array
    """(n,), squared angular frequencies of the modes, of unit modal mass."""
    mass: Array
    """(p + n, p + n)."""
    basis: Array
    """(m, p + n), coordinates of the structure for unit coordinates of the ports and modes."""


def craig_bampton(
    K: Array, M: Array, ports: NDArray[np.intp], n_modes: int | None, ties: Array | None = None
) -> Reduced:
    """Reduce stiffness and mass (m, m) to the coordinates ``ports`` and the lowest ``n_modes``.

    All modes are kept if None. ``ties`` (c, m) are rows that the motion does not move: tie x = 0.

    R. R. Craig, M. C. C. Bampton, "Coupling of substructures for dynamic analyses", AIAA J. 6(7),
    1968.
    """
    inner = np.setdiff1d(np.arange(len(K)), ports)
    held, carried = _held_by(ties, inner, ports)
    K_inner = held.T @ K[np.ix_(inner, inner)] @ held
    M_inner = held.T @ M[np.ix_(inner, inner)] @ held
    pull = held.T @ (K[np.ix_(inner, ports)] + K[np.ix_(inner, inner)] @ carried)
    follow = carried - held @ np.linalg.solve(K_inner, pull)
    values, modes = _modes(K_inner, M_inner)
    pull_of_modes = (M[np.ix_(ports, inner)] + follow.T @ M[np.ix_(inner, inner)]) @ held @ modes
    modes = _settled(values, modes, pull_of_modes)
    values, modes = values[:n_modes], modes[:, :n_modes]
    p = ports.size
    basis = np.zeros((len(K), p + values.size))
    basis[ports, :p] = np.eye(p)
    basis[inner, :p] = follow
    basis[inner, p:] = held @ modes
    stiffness = basis[:, :p].T @ K @ basis[:, :p]
    return Reduced(stiffness, values, basis.T @ M @ basis, basis)


def _held_by(
    ties: Array | None, inner: NDArray[np.intp], ports: NDArray[np.intp]
) -> tuple[Array, Array]:
    """Return how inner coordinates can move with ports held (i, k), and must with them (i, p)."""
    if ties is None or not ties.size:
        return np.eye(inner.size), np.zeros((inner.size, ports.size))
    from scipy.linalg import null_space

    carried = -np.linalg.pinv(ties[:, inner]) @ ties[:, ports]
    return np.asarray(null_space(ties[:, inner])), np.asarray(carried)


def _modes(K: Array, M: Array) -> tuple[Array, Array]:
    """Return squared angular frequencies (n,) and modes (m, n) of unit modal mass, lowest first.

    M may be singular, as that of a line without moment of inertia about itself: what has no mass
    has no mode.
    """
    if not len(K):
        return np.zeros(0), np.zeros((0, 0))
    from scipy.linalg import eigh  # slow to import, and not needed to read most robots

    # The stiffness is the definite one of the two; the eigenvalues are 1/omega^2.
    inverses, modes = eigh(M, K)
    massive = inverses > _MASSLESS * inverses.max(initial=0.0)
    inverses, modes = inverses[massive][::-1], modes[:, massive][:, ::-1]
    return 1.0 / inverses, modes / np.sqrt(inverses)


def _settled(values: Array, modes: Array, pull: Array) -> Array:
    """Return modes (m, n), turned among each other where their frequencies are equal.

    Any mixture of modes of one frequency is a mode. Of theirs the first is made the one that alone
    pulls at the first port along x, and so on, by ``pull`` (p, n). So which ones are kept does not
    hang on rounding, and they change smoothly with the structure.
    """
    settled = modes.copy()
    starts = np.flatnonzero(np.r_[True, np.diff(values) > _EQUAL * values[:-1]])
    for start, end in itertools.pairwise([*starts, values.size]):
        own = pull[:, start:end]
        sizes = np.linalg.norm(own, axis=1)
        if end - start > 1 and sizes.any():
            Q, _ = np.linalg.qr(own[sizes > 1e-3 * sizes.max()].T, mode="complete")
            settled[:, start:end] = modes[:, start:end] @ Q
    return settled
