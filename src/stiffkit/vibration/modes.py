"""Natural frequencies and mode shapes of single postures: any mechanism, exact constraints."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, eigh, svd

from stiffkit.compiled import Backend, BatchFunction, Constants, Kernel
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.kinematics.locate import add_geometry
from stiffkit.kinematics.numeric import one_thread
from stiffkit.network import (
    CoordinatesAtPosture,
    FreeMotion,
    Model,
    Motions,
    NetworkCoordinates,
    Node,
)
from stiffkit.smallmat import Vector, minus, vector
from stiffkit.spatial import twist_shift
from stiffkit.vibration.bodies import Bodies, Discretisation, make_bodies

Array = NDArray[np.float64]

_MASSLESS = 1e-14
"""Eigenvalues of the flexibility times mass below this share of the largest are no modes."""

_EQUAL = 1e-7
"""Frequencies as near as this, over the frequency, are equal."""


@dataclass(frozen=True, eq=False)
class Modes:
    """The elastic modes of a posture, lowest first."""

    frequencies_hz: Array
    """(n,), ascending."""
    shapes: Array
    """(n_coordinates, n), unit-free coordinates of the network, of unit modal mass."""
    tool: Array
    """(6, n), the tool's twist in each mode, SI, world axes, at the tool point."""
    energy_shares: list[dict[str, float]]
    """Share of the strain energy in each link and joint, largest first, for each mode."""
    free_motions: tuple[FreeMotion, ...]
    """Motions of the tool that nothing holds: rigid-body modes of frequency zero."""
    idle_motions: tuple[FreeMotion, ...]
    n_existing: int = 0
    """How many elastic modes there are, of which the lowest n are given."""


class ModalModel:
    """The vibration of a robot about any posture."""

    def __init__(
        self,
        tree: SpanningTree,
        length: float,
        how: Discretisation | None = None,
        *,
        bodies: Bodies | None = None,
        elasticity: Model = "refined",
        backend: Backend | None = None,
    ) -> None:
        """Take the mechanism, a typical length (m) and how links are cut up.

        ``bodies`` replace the robot's own masses; ``elasticity`` says what yields.
        """
        self.tree = tree
        self.length = length
        self.bodies: Bodies = bodies or make_bodies(tree.robot, how or Discretisation())
        self.coordinates = NetworkCoordinates(
            tree, length, elasticity, mode_stiffness=self.bodies.mode_stiffness, backend=backend
        )
        self._massive = [*self.bodies.rigid, *self.bodies.elastic]
        self._constants = Constants()
        add_geometry(self._constants, tree.robot)
        self._frames = BatchFunction(self._frames_kernel(), backend)

    def _frames_kernel(self) -> Kernel:
        """Return the kernel of where massive bodies are.

        Inputs: coordinates of the tree. Outputs, body by body: R_world_body row by row (9), and the
        tool point from the body's origin (3), m.
        """

        def frames(q: Vector, c: Vector) -> Vector:
            located = Located(self.tree, self._constants, q, c)
            values = []
            for name in self._massive:
                body = located.body(name)
                values += [*body.R.ravel(), *minus(located.tool.p, body.p)]
            return vector(values)

        return Kernel(
            "frames",
            frames,
            self.tree.n_coordinates,
            self._constants,
            (self.tree.topology, tuple(self._massive)),
        )

    def at(self, q: Array, n: int | None = None) -> Modes:
        """Return the lowest ``n`` elastic modes, all if None, at coordinates (n,) of the tree."""
        return next(self.at_each(q[:, None], n))

    def at_each(self, q: Array, n: int | None = None) -> Iterator[Modes]:
        """Yield the modes at each of the coordinates (n, N) of the tree, SI."""
        for at, roots in self.assembled(q):
            with one_thread():
                solved = self._solve(at, roots, n)
            yield solved

    def assembled(self, q: Array) -> Iterator[tuple[CoordinatesAtPosture, Array]]:
        """Yield the coordinates at each posture, and a root B of the mass, at (n, N) of the tree.

        The kinetic energy of rates dx of the coordinates is |B dx|^2 / 2, SI.
        """
        frames = self._frames(q).T.reshape(q.shape[1], -1, 12)
        for at, placed in zip(self.coordinates.at_each(q), frames, strict=True):
            yield at, self._mass_roots(at, placed)

    def _solve(self, at: CoordinatesAtPosture, roots: Array, n: int | None) -> Modes:
        motions = Motions.of(at)
        held, free = roots @ motions.held, roots @ motions.free
        if free.size:
            # Free motions with mass go along so that no momentum is left over.
            follow = -_inverse_of_massive(free, float(np.linalg.norm(roots))) @ held
            held = held + free @ follow
        else:
            follow = np.zeros((motions.free.shape[1], motions.held.shape[1]))
        R = motions.factor()
        # In coordinates of unit stiffness the mass matrix has eigenvalues 1/omega^2.
        half = np.linalg.solve(R.T, held.T).T
        singular, Vt = _singular_values(np.asarray(half))
        kept = singular > np.sqrt(_MASSLESS) * (singular[0] if singular.size else 1.0)
        singular, Vt = np.asarray(singular[kept]), np.asarray(Vt[kept])
        of_tool = at.tool @ (motions.held + motions.free @ follow)
        Vt = _settled(singular, Vt, np.asarray(np.linalg.solve(R.T, of_tool.T).T))
        n_existing = singular.size
        singular, Vt = singular[:n], Vt[:n]
        s = np.linalg.solve(R, Vt.T) / singular
        shapes = motions.held @ s + motions.free @ follow @ s
        to_si = np.diag([self.length] * 3 + [1.0] * 3)
        free_motions, idle_motions = motions.free_motions(self.length)
        return Modes(
            1.0 / (2.0 * np.pi * singular),
            shapes,
            to_si @ at.tool @ shapes,
            [self._energy_shares(at, x) for x in shapes.T],
            free_motions,
            idle_motions,
            n_existing,
        )

    def matrices(self, q: Array) -> tuple[Array, Array]:
        """Return stiffness and mass (m, m) at coordinates (n,), on all motions that are held.

        They are those of the motions that the loops allow, in unit-free coordinates; the stiffness
        is positive definite.
        """
        at, mass_root = next(self.assembled(q[:, None]))
        motions = Motions.of(at)
        held, roots = at.energy @ motions.held, mass_root @ motions.held
        return held.T @ held, roots.T @ roots

    def _mass_roots(self, at: CoordinatesAtPosture, placed: Array) -> Array:
        """Return B (m, n); see `assembled`."""
        rows = []
        to_si = np.diag([self.length] * 3 + [1.0] * 3)
        frames = dict(zip(self._massive, placed, strict=True))
        for name, mass in self.bodies.rigid.items():
            twist = _at_body(frames[name]) @ to_si @ at.motion_of[self._cluster(name, "base")]
            rows.append(_root(mass) @ twist)
        for name, element in self.bodies.elastic.items():
            ports = [
                twist_shift(frame.position)
                @ _at_body(frames[name])
                @ to_si
                @ at.motion_of[self._cluster(name, port)]
                for port, frame in self.tree.robot.links[name].ports.items()
            ]
            modes = np.zeros((element.mode_stiffness.size, len(at.names)))
            columns = [i for i, label in enumerate(at.names) if label == f"{name}.mode"]
            modes[np.arange(len(columns)), columns] = 1.0
            rows.append(_root(element.mass) @ np.vstack([*ports, modes]))
        if self.bodies.tool_mass:
            rows.append(np.sqrt(self.bodies.tool_mass) * self.length * at.tool[:3])
        return np.concatenate([np.zeros((0, len(at.names))), *rows])

    def _cluster(self, body: str, port: str) -> Node:
        return self.coordinates.network.cluster_of(body, port)

    def _energy_shares(self, at: CoordinatesAtPosture, x: Array) -> dict[str, float]:
        shares: dict[str, float] = {}
        for row in at.energy:
            owner = at.names[int(np.argmax(np.abs(row)))].rpartition(".")[0]
            shares[owner] = shares.get(owner, 0.0) + float((row @ x) ** 2)
        total = sum(shares.values())
        ranked = sorted(shares.items(), key=lambda item: -item[1])
        return {name: value / total for name, value in ranked}


def _singular_values(A: Array) -> tuple[Array, Array]:
    """Return the singular values (k,), largest first, and right vectors (k, n) of A (m, n)."""
    try:
        _, values, Vt = svd(A, full_matrices=False)
    except LinAlgError:
        # The faster algorithm does not converge on some rare matrices; the slower one always does.
        _, values, Vt = svd(A, full_matrices=False, lapack_driver="gesvd")
    return np.asarray(values), np.asarray(Vt)


def _inverse_of_massive(free: Array, scale: float) -> Array:
    """Return the pseudo-inverse of ``free`` (m, k) without what is rounding beside ``scale``."""
    size = float(np.linalg.norm(free))
    # Idle motions may have no mass at all: then there is nothing to invert but rounding.
    return np.asarray(np.linalg.pinv(free, rcond=1e-10 * scale / size if size else 1.0))


def _settled(singular: Array, Vt: Array, tool: Array) -> Array:
    """Return the rows of ``Vt`` (n, m), turned where frequencies are equal, with settled signs.

    Any mixture of modes of one frequency is a mode. Of theirs the first is made the one that alone
    moves the tool (6, m) along x, and so on, so that modes of symmetric robots are what one expects
    and come out alike on every machine.
    """
    settled = Vt.copy()
    starts = np.flatnonzero(np.r_[True, -np.diff(singular) > _EQUAL * singular[:-1]])
    for start, end in itertools.pairwise([*starts, singular.size]):
        if end - start > 1:
            twists = tool @ Vt[start:end].T
            sizes = np.linalg.norm(twists, axis=1)
            telling = sizes > 1e-3 * sizes.max()
            Q, _ = np.linalg.qr(twists[telling].T, mode="complete")
            settled[start:end] = Q.T @ Vt[start:end]
    twists = tool @ settled.T
    largest = twists[np.argmax(np.abs(twists), axis=0), np.arange(settled.shape[0])]
    return np.where(largest < 0.0, -1.0, 1.0)[:, None] * settled


def _at_body(placed: Array) -> Array:
    """Return Y (6, 6): a twist at the tool point, world axes, to the body's origin and axes."""
    R, arm = placed[:9].reshape(3, 3), placed[9:]
    return np.asarray(np.kron(np.eye(2), R.T) @ twist_shift(-arm))


def _root(M: Array) -> Array:
    """Return B with B^T B = M of a positive semi-definite matrix."""
    values, vectors = eigh(M)
    return np.asarray(np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T)
