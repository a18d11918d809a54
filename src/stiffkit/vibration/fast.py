"""Lowest natural frequencies of many postures, with an estimate of the error that is made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction
from stiffkit.kinematics import Located
from stiffkit.network import JointPart, LinkPart, loose_directions
from stiffkit.robot import Freedom
from stiffkit.smallmat import as_objects
from stiffkit.spatial import twist_shift
from stiffkit.vibration.modes import ModalModel
from stiffkit.vibration.reduced import Basis, ReducedKernel

Array = NDArray[np.float64]

TOLERANCE = 2e-5
"""Largest relative error of a frequency at the postures that the basis is checked at."""

_SPARE_MODES = 2
"""Modes beyond those asked for that the basis is made from."""
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
        training = candidates[:, _far_apart(candidates, _ROUNDS * _TRAINING)]
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
        snapshots, frequencies = [], []
        for i, modes in enumerate(self.full.at_each(q, self.n + _SPARE_MODES)):
            shapes = modes.shapes / (2.0 * np.pi * modes.frequencies_hz)
            snapshots.append(self._to_own_axes(q[:, i], shapes))
            padded = np.full(self.n, np.nan)
            found = modes.frequencies_hz[: self.n]
            padded[: found.size] = found
            frequencies.append(padded)
        return np.hstack(snapshots), np.array(frequencies).T

    def _fit(self, snapshots: Array, q: Array, exact: Array) -> None:
        """Choose the smallest basis that is good enough at postures q."""
        U, values, _ = np.linalg.svd(snapshots, full_matrices=False)
        most = min(int(np.sum(values > 1e-9 * values[0])), _LARGEST)
        sizes = range(min(self.n + 4, most), most, 4)
        for size in [*sizes, most]:
            self._use(self._basis(U[:, :size]))
            errors = np.abs(self.frequencies(q) / exact - 1.0)[np.isfinite(exact)]
            error = float(errors.max()) if np.isfinite(errors).all() and errors.size else np.inf
            self.trust = Trust(size, error, q.shape[1])
            if self.trust.good:
                return

    def _use(self, basis: Basis) -> None:
        model = ReducedKernel(self.full.tree, self.full.length, self.full.bodies, basis)
        self._function = BatchFunction(model.kernel(), self._backend)
        self._size = basis.size

    def frequencies(self, q: Array) -> Array:
        """Return the lowest frequencies (n, N), Hz, at coordinates (n_coordinates, N).

        NaN where a posture is not defined, or where there are fewer modes.
        """
        lower = self._function(q)
        r = self._size
        matrices = np.zeros((q.shape[1], r, r))
        rows, columns = np.tril_indices(r)
        matrices[:, rows, columns] = lower.T
        usable = np.isfinite(lower).all(axis=0)
        result = np.full((self.n, q.shape[1]), np.nan)
        values = np.linalg.eigvalsh(matrices[usable], UPLO="L")[:, ::-1][:, : self.n]
        with np.errstate(divide="ignore", invalid="ignore"):
            result[: values.shape[1], usable] = (1.0 / (2.0 * np.pi * np.sqrt(values))).T
        return result

    def _to_own_axes(self, q: Array, shapes: Array) -> Array:
        """Return elastic coordinates (n_energy, k) in their own axes, of unit stiffness."""
        coordinates, robot = self.full.coordinates, self.full.tree.robot
        located = Located(
            self.full.tree,
            coordinates.constants,
            as_objects(q),
            as_objects(coordinates.constants.values),
        )
        tool = np.array(located.tool.p, dtype=float)
        to_si = np.diag([self.full.length] * 3 + [1.0] * 3)
        rows, start = [], 0
        for edge in coordinates.network.edges:
            if isinstance(edge.part, LinkPart):
                link = robot.links[edge.part.name]
                frame = located.body(link.name)
                R = np.array(frame.R, dtype=float)
                tip = R @ link.ports["tip"].position + np.array(frame.p, dtype=float)
                to_tip = np.kron(np.eye(2), R.T) @ twist_shift(tip - tool) @ to_si
                roots = np.sqrt(self.full.bodies.mode_stiffness.get(link.name, np.zeros(0)))
                end = start + 6 + roots.size
                rows.append(_root_stiffness(link.compliance) @ to_tip @ shapes[start : start + 6])
                rows.append(roots[:, None] * shapes[start + 6 : end])
                start = end
            elif isinstance(edge.part, JointPart):
                joint = robot.joints[edge.part.name]
                for direction in loose_directions(joint):
                    unit = 1.0 if direction.turns else self.full.length
                    if direction.freedom is not Freedom.PASSIVE:
                        root = np.sqrt(joint.stiffness[direction.index])
                        rows.append(root * unit * shapes[start : start + 1])
                    start += 1
        return np.concatenate(rows)

    def _basis(self, U: Array) -> Basis:
        """Return the basis of orthonormal columns (n_energy, r) of unit stiffness."""
        coordinates, robot = self.full.coordinates, self.full.tree.robot
        blocks: dict[int, Array] = {}
        start = 0
        for i, edge in enumerate(coordinates.network.edges):
            if isinstance(edge.part, LinkPart):
                link = robot.links[edge.part.name]
                roots = np.sqrt(self.full.bodies.mode_stiffness.get(link.name, np.zeros(0)))
                end = start + 6 + roots.size
                bending = np.linalg.solve(_root_stiffness(link.compliance), U[start : start + 6])
                blocks[i] = np.vstack([bending, U[start + 6 : end] / roots[:, None]])
                start = end
            elif isinstance(edge.part, JointPart):
                joint = robot.joints[edge.part.name]
                directions = loose_directions(joint)
                blocks[i] = np.zeros((len(directions), U.shape[1]))
                for j, direction in enumerate(directions):
                    if direction.freedom is not Freedom.PASSIVE:
                        blocks[i][j] = U[start] / np.sqrt(joint.stiffness[direction.index])
                        start += 1
        return Basis(blocks)


def _far_apart(q: Array, count: int) -> NDArray[np.intp]:
    """Return indices of postures (n, N) that lie as far apart as can be, extremes first."""
    spread = np.ptp(q, axis=1)
    x = q[spread > 0.0] / spread[spread > 0.0, None]
    distance = np.sum((x - x.mean(axis=1, keepdims=True)) ** 2, axis=0)
    chosen: list[int] = []
    for _ in range(min(count, q.shape[1])):
        chosen.append(int(np.argmax(distance)))
        to_chosen = np.sum((x - x[:, chosen[-1:]]) ** 2, axis=0)
        distance = to_chosen if len(chosen) == 1 else np.minimum(distance, to_chosen)
    return np.array(chosen)


def _root_stiffness(compliance: Array | None) -> Array:
    """Return E with E^T E the inverse of a compliance (6, 6)."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(np.asarray(compliance))))
