"""Lowest natural frequencies of many postures, with an estimate of the error that is made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction
from stiffkit.network import elements_of
from stiffkit.vibration.modes import ModalModel
from stiffkit.vibration.own_axes import basis_of, modes_in_own_axes
from stiffkit.vibration.reduced import Basis, ReducedKernel
from stiffkit.vibration.tracking import ModeVectors

Array = NDArray[np.float64]

TOLERANCE = 2e-5
"""Largest relative error of a frequency at the postures that the basis is checked at."""

SPARE_MODES = 2
"""Modes beyond those asked for that the basis is made from."""
_MASSLESS = 1e-14
"""Eigenvalues 1/omega^2 below this share of the largest are no modes."""
_BLOCK = 1 << 13
"""Postures at a time, so that their matrices do not fill the memory."""
_TRAINING = 10
"""Postures by which what the basis is made from grows."""
_CHECKED = 16
"""Postures that the basis is checked at."""
_CANDIDATES = 2000
"""Postures among which those are chosen."""
_LARGEST = 30
"""Vectors of a basis beyond which the full model is the better way."""
_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Trust:
    """How good the fast model was found to be."""

    size: int
    """Vectors of the basis."""
    error: float
    """Largest relative error of a frequency at `checked` postures that the basis had not seen."""
    checked: int
    """Number of those postures."""

    @property
    def good(self) -> bool:
        """Whether the error is within `TOLERANCE`."""
        return self.error <= TOLERANCE


class FastModes:
    """The reduced model of a robot, made from a few sample postures and proved on others."""

    def __init__(
        self, full: ModalModel, samples: Array, n: int, *, backend: Backend | None = None
    ) -> None:
        """Take the full model, postures (n_coordinates, N) to sample from, and how many modes.

        The basis grows until the frequencies at fresh samples are within `TOLERANCE`; `trust` says
        what was reached.
        """
        self.full = full
        self.n = n
        self._backend = backend
        rng = np.random.default_rng(0)
        candidates = samples[:, rng.permutation(samples.shape[1])[:_CANDIDATES]]
        check = candidates[:, :_CHECKED]
        exact = self._solve(check)[1]
        training = candidates[:, far_apart(candidates, _ROUNDS * _TRAINING)]
        snapshots = np.zeros((0, 0))
        self.trust = Trust(0, np.inf, 0)
        for start in range(0, training.shape[1], _TRAINING):
            fresh, _ = self._solve(training[:, start : start + _TRAINING])
            snapshots = np.hstack([snapshots, fresh]) if snapshots.size else fresh
            self._fit(snapshots, check, exact)
            if self.trust.good:
                break

    def _solve(self, q: Array) -> tuple[Array, Array]:
        """Return snapshots (n_energy, k) of unit energy, and frequencies (n, N); full model."""
        modes = modes_in_own_axes(self.full, q, self.n + SPARE_MODES)
        snapshots = modes.vectors.reshape(-1, modes.vectors.shape[2]).T
        return np.asarray(snapshots), modes.frequencies[: self.n]

    def _fit(self, snapshots: Array, q: Array, exact: Array) -> None:
        """Choose the smallest basis that is good enough at postures q."""
        U, values, _ = np.linalg.svd(snapshots, full_matrices=False)
        most = min(int(np.sum(values > 1e-9 * values[0])), _LARGEST)
        sizes = range(min(self.n + 4, most), most, 4)
        elements = elements_of(self.full.coordinates.network, self.full.tree.robot)
        for size in [*sizes, most]:
            self._use(basis_of(elements, self.full.bodies.mode_stiffness, U[:, :size]))
            errors = np.abs(self.frequencies(q) / exact - 1.0)[np.isfinite(exact)]
            error = float(errors.max()) if np.isfinite(errors).all() and errors.size else np.inf
            self.trust = Trust(size, error, q.shape[1])
            if self.trust.good:
                return

    def _use(self, basis: Basis) -> None:
        model = ReducedKernel(self.full.tree, self.full.length, self.full.bodies, basis)
        self._function = BatchFunction(model.kernel(), self._backend)
        self._function_with_factor = BatchFunction(model.kernel(with_factor=True), self._backend)
        self._size = basis.size

    def frequencies(self, q: Array) -> Array:
        """Return the lowest frequencies (n, N), Hz, at coordinates (n_coordinates, N).

        NaN where a posture is not defined, or where there are fewer modes.
        """
        matrices, usable = self._matrices(self._function(q))
        values = np.asarray(np.linalg.eigvalsh(matrices, UPLO="L")[:, ::-1])
        result = np.full((self.n, q.shape[1]), np.nan)
        result[:, usable] = frequencies_of(values, self.n)
        return result

    def modes(self, q: Array) -> ModeVectors:
        """Return the lowest n modes and `SPARE_MODES` more at coordinates (n_coordinates, N).

        The vectors are the modes' elastic coordinates in their own axes, of unit energy, seen on
        the basis: comparable between postures. Spare modes are there to follow modes through; their
        frequencies are not part of what `trust` says. No modes where a posture is not defined.
        """
        n, r = self.n + SPARE_MODES, self._size
        frequencies = np.full((n, q.shape[1]), np.nan)
        vectors = np.zeros((q.shape[1], n, r), dtype=np.float32)
        for start in range(0, q.shape[1], _BLOCK):
            both = self._function_with_factor(q[:, start : start + _BLOCK])
            lower, factor = np.split(both, 2)
            matrices, usable = self._matrices(lower)
            values, Y = np.linalg.eigh(matrices, UPLO="L")
            values, Y = values[:, ::-1], Y[:, :, ::-1]
            known = start + np.flatnonzero(usable)
            frequencies[:, known] = frequencies_of(values, n)
            L = lower_triangular(factor[:, usable], r)
            vectors[known, : min(n, r)] = np.swapaxes(L @ Y[:, :, :n], 1, 2)
        vectors[np.isnan(frequencies.T)] = 0.0
        return ModeVectors(frequencies, vectors)

    def _matrices(self, lower: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return lower triangles (r(r+1)/2, N) as matrices (m, r, r), and which N they are."""
        usable = np.asarray(np.isfinite(lower).all(axis=0))
        return lower_triangular(lower[:, usable], self._size), usable


def lower_triangular(lower: Array, r: int) -> Array:
    """Return matrices (N, r, r) of lower triangles (r(r+1)/2, N), zero above."""
    matrices = np.zeros((lower.shape[1], r, r))
    rows, columns = np.tril_indices(r)
    matrices[:, rows, columns] = lower.T
    return matrices


def frequencies_of(values: Array, n: int) -> Array:
    """Return frequencies (n, N), Hz, of eigenvalues 1/omega^2 (N, r), largest first."""
    result = np.full((n, values.shape[0]), np.nan)
    exists = values[:, :n] > _MASSLESS * values[:, :1]
    omega = 1.0 / np.sqrt(np.where(exists, values[:, :n], np.nan))
    result[: omega.shape[1]] = omega.T / (2.0 * np.pi)
    return result


def far_apart(q: Array, count: int) -> NDArray[np.intp]:
    """Return indices of postures (n, N) that lie as far apart as can be, extremes first."""
    spread = np.ptp(q, axis=1)
    x = q[spread > 0.0] / spread[spread > 0.0, None]
    distance = np.sum((x - x.mean(axis=1, keepdims=True)) ** 2, axis=0)
    chosen: list[int] = []
    for _ in range(min(count, q.shape[1])):
        chosen.append(int(np.argmax(distance)))
        to_chosen = np.sum((x - x[:, chosen[-1:]]) ** 2, axis=0)
        distance = to_chosen if len(chosen) == 1 else np.minimum(distance, to_chosen)
    return np.array(chosen, dtype=np.intp)
