"""What a mechanism's coordinates can do: motions that nothing holds, and those held by springs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics.numeric import RANK_TOLERANCE, null_space
from stiffkit.network.coordinates import CoordinatesAtPosture

Array = NDArray[np.float64]

_MOVES_TOOL = 10.0 * RANK_TOLERANCE
"""Twist of the tool, for a unit of a free motion's coordinates, below which the motion is idle.

Free motions themselves are known to `RANK_TOLERANCE` only."""


@dataclass(frozen=True, eq=False)
class FreeMotion:
    """A motion that no drive and no elasticity holds."""

    twist: Array
    """(6,), of the tool, SI, at the tool point, world axes; zero if only inner parts move."""
    moving: tuple[str, ...]
    """Names of the passive joint directions that take part."""

    @property
    def joints(self) -> list[str]:
        """Names of the joints that take part, each once."""
        return list(dict.fromkeys(name.rpartition(".")[0] for name in self.moving))


@dataclass(frozen=True, eq=False)
class Motions:
    """All motions that the loops allow, split into free and held ones."""

    at: CoordinatesAtPosture
    free: Array
    """(n, k), orthonormal: coordinates of motions without energy."""
    held: Array
    """(n, m), orthonormal: coordinates of the other motions."""

    @staticmethod
    def of(at: CoordinatesAtPosture) -> Motions:
        """Split the motions of a posture.

        What is free is a matter of geometry, so springs of any stiffness count alike.
        """
        closed = null_space(at.loops)
        sizes = np.linalg.norm(at.energy, axis=1, keepdims=True)
        geometry = at.energy / np.where(sizes > 0.0, sizes, 1.0)
        free = null_space(geometry @ closed)
        held = null_space(free.T) if free.shape[1] else np.eye(closed.shape[1])
        return Motions(at, closed @ free, closed @ held)

    @property
    def free_at_tool(self) -> Array:
        """Orthonormal twists (6, k) of the tool, unit-free, that nothing holds."""
        U, values, _ = np.linalg.svd(self.at.tool @ self.free, full_matrices=False)
        return np.asarray(U[:, : int(np.sum(values > _MOVES_TOOL))])

    def factor(self) -> Array:
        """Return R (m, m), upper triangular: held motions ``held s`` have the energy |R s|^2/2."""
        return np.asarray(np.linalg.qr(self.at.energy @ self.held, mode="r"))

    def free_motions(self, length: float) -> tuple[tuple[FreeMotion, ...], tuple[FreeMotion, ...]]:
        """Return the free motions that move the tool, and the idle ones that do not.

        ``length`` (m) is the one that the coordinates are made unit-free with.
        """
        if self.free.shape[1] == 0:
            return (), ()
        tool = self.at.tool @ self.free
        _, values, Vt = np.linalg.svd(tool)
        n_tool = int(np.sum(values > _MOVES_TOOL))
        of_tool = Vt[:n_tool].T @ plain_basis(tool @ Vt[:n_tool].T)
        idle = Vt[n_tool:].T @ plain_basis(self.free @ Vt[n_tool:].T)
        return (
            tuple(self._motion(self.free @ w, length, of_tool=True) for w in of_tool.T),
            tuple(self._motion(self.free @ w, length, of_tool=False) for w in idle.T),
        )

    def _motion(self, x: Array, length: float, *, of_tool: bool) -> FreeMotion:
        moves = np.abs(x) > 1e-6 * np.abs(x).max()
        moving = tuple(name for name, m in zip(self.at.names, moves, strict=True) if m)
        to_si = np.array([length] * 3 + [1.0] * 3)
        return FreeMotion(to_si * (self.at.tool @ x) if of_tool else np.zeros(6), moving)


def plain_basis(A: Array) -> Array:
    """Return W (k, k) so that the columns of ``A W`` (n, k) span the same and are mostly zeros.

    Gauss-Jordan elimination on the columns; of A's rows the first ones that do are made unit rows,
    so that a free motion comes out along x rather than along a mixture of x and y, and the spins of
    two rods come out one by one.
    """
    reduced = A.copy()
    W = np.eye(A.shape[1])
    column = 0
    for row in range(A.shape[0]):
        if column == A.shape[1]:
            break
        pivot = column + int(np.argmax(np.abs(reduced[row, column:])))
        if abs(reduced[row, pivot]) < 1e-6 * np.abs(A).max():
            continue
        step = np.eye(A.shape[1])
        step[:, [column, pivot]] = step[:, [pivot, column]]
        swapped = reduced[row] @ step
        step[:, column] /= swapped[column]
        swapped[column] = 0.0
        step -= np.outer(step[:, column], swapped)
        reduced, W = reduced @ step, W @ step
        column += 1
    return W
