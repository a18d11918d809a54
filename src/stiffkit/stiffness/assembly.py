"""The general assembly: any mechanism, one posture at a time, with NumPy's linear algebra.

It is slow, and the reference that the fast path is tested against.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend
from stiffkit.kinematics import SpanningTree
from stiffkit.kinematics.numeric import null_space, one_thread, rank
from stiffkit.network import CoordinatesAtPosture, FreeMotion, Model, Motions, NetworkCoordinates

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AssembledCompliance:
    """What the general assembly finds at one posture; SI, world axes, at the tool point."""

    compliance: Array | None
    """(6, 6), None where the tool can move freely."""
    stiffness: Array | None
    """(6, 6), semi-definite where the tool can move freely; None where it is infinite in a
    direction that the mechanism holds rigidly."""
    free_motions: tuple[FreeMotion, ...]
    """Of the tool."""
    idle_motions: tuple[FreeMotion, ...]
    """Of inner parts only, such as a rod's spin."""


class Assembly:
    """The general assembly of a robot."""

    def __init__(
        self,
        tree: SpanningTree,
        length: float,
        model: Model = "refined",
        *,
        backend: Backend | None = None,
    ) -> None:
        """Take the mechanism and a length (m) that makes its equations unit-free.

        In the simplified model only the drives are elastic.
        """
        self.length = length
        self.coordinates = NetworkCoordinates(tree, length, model, backend=backend)

    def at(self, q: Array) -> AssembledCompliance:
        """Return compliance and free motions at coordinates (n,) of the tree, SI."""
        return next(self.at_each(q[:, None]))

    def at_each(self, q: Array) -> Iterator[AssembledCompliance]:
        """Yield compliance and free motions at each of the coordinates (n, N) of the tree, SI."""
        for at in self.coordinates.at_each(q):
            with one_thread():
                solved = self._solve(at)
            yield solved

    def _solve(self, at: CoordinatesAtPosture) -> AssembledCompliance:
        motions = Motions.of(at)
        free_motions, idle_motions = motions.free_motions(self.length)
        # The deflection under a wrench w is G (G^T w) with G = tool (energy)^+: a least-squares
        # problem, twice as precise as the normal equations.
        if motions.held.shape[1]:
            G = np.asarray(np.linalg.solve(motions.factor().T, (at.tool @ motions.held).T).T)
        else:
            G = np.zeros((6, 0))
        to_si = np.diag([self.length] * 3 + [1.0] * 3)
        compliance = to_si @ G @ G.T @ to_si if not free_motions else None
        return AssembledCompliance(
            compliance, _stiffness(G, motions.free_at_tool, to_si), free_motions, idle_motions
        )


def _stiffness(G: Array, free: Array, to_si: Array) -> Array | None:
    """Return the stiffness: on the wrenches that do no work on free motions, k's inverse."""
    carried = null_space(free.T)
    half = carried.T @ G
    if rank(half / max(np.linalg.norm(half), np.finfo(float).tiny)) < carried.shape[1]:
        return None
    root = np.linalg.pinv(half)
    inverse = np.linalg.inv(to_si)
    return np.asarray(inverse @ carried @ root.T @ root @ carried.T @ inverse)
