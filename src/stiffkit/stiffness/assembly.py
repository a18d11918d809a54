"""The general assembly: any mechanism, one posture at a time, with NumPy's linear algebra.

Every elastic link and every joint contributes coordinates: six elastic deflections, or the joint's
directions that are passive, driven or elastic. Loops tie the coordinates together exactly, so rigid
parts, over-constrained loops, redundant passive joints and singular postures need no special care.
It is slow, and the reference that the fast path is tested against.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Constants
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.kinematics.numeric import null_space, rank
from stiffkit.robot import Freedom
from stiffkit.smallmat import as_objects
from stiffkit.stiffness.network import (
    Edge,
    JointPart,
    LinkPart,
    Network,
    Node,
    build_network,
)
from stiffkit.stiffness.parts import LooseDirection, PartsAtTool, add_elasticity

Array = NDArray[np.float64]
Model = Literal["refined", "simplified"]


@dataclass(frozen=True, eq=False)
class _Coordinates:
    """The coordinates of one edge: how they move the far side, and what holds them."""

    columns: Array
    """(6, n), twist at the tool point for a unit of each coordinate, lengths over the robot's."""
    energy: Array
    """(n, n), upper triangular or rectangular E so that the energy is |E x|^2 / 2; zero rows for
    passive coordinates."""
    names: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class FreeMotion:
    """A motion that no drive and no elasticity holds."""

    twist: Array
    """(6,), of the tool, SI, at the tool point, world axes; zero if only inner parts move."""
    moving: tuple[str, ...]
    """Names of the passive joint directions that take part."""


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

    def __init__(self, tree: SpanningTree, length: float, model: Model = "refined") -> None:
        """Take the mechanism and a length (m) that makes its equations unit-free.

        In the simplified model only the drives are elastic.
        """
        self.tree = tree
        self.length = length
        self.model = model
        self.constants = Constants()
        add_elasticity(self.constants, tree.robot, length)
        self.network = build_network(tree.robot)

    def at(self, q: Array) -> AssembledCompliance:
        """Return compliance and free motions at coordinates (n,) of the tree, SI."""
        c = as_objects(self.constants.values)
        located = Located(self.tree, self.constants, as_objects(q), c)
        parts = PartsAtTool(located, self.constants, c)
        blocks = [self._coordinates(edge, parts) for edge in self.network.edges]
        loops, tool = _loops_and_tool(self.network, [block.columns for block in blocks])
        system = _System(
            loops,
            tool,
            _block_diagonal([block.energy for block in blocks]),
            [name for block in blocks for name in block.names],
            self.length,
        )
        return system.solve()

    def _coordinates(self, edge: Edge, parts: PartsAtTool) -> _Coordinates:
        robot = self.tree.robot
        if isinstance(edge.part, JointPart):
            return self._joint_coordinates(parts.loose_directions(robot.joints[edge.part.name]))
        if not isinstance(edge.part, LinkPart):
            raise TypeError("the general assembly works on the network before its reduction")
        if self.model == "simplified":
            return _Coordinates(np.zeros((6, 0)), np.zeros((0, 0)), ())
        S = np.array(parts.link_compliance(robot.links[edge.part.name]), dtype=float)
        unit_free = _lengths_over(self.length)
        # With S = L L^T a deflection y holds the energy |L^-1 y|^2 / 2.
        lower = np.linalg.cholesky(unit_free @ S @ unit_free)
        return _Coordinates(np.eye(6), np.linalg.inv(lower), (f"{edge.part.name} bends",) * 6)

    def _joint_coordinates(self, directions: list[LooseDirection]) -> _Coordinates:
        if self.model == "simplified":
            directions = [d for d in directions if d.freedom is Freedom.DRIVEN or d.moves]
        columns = np.zeros((6, len(directions)))
        rows = []
        for j, direction in enumerate(directions):
            unit = 1.0 if direction.turns else self.length
            columns[:, j] = _lengths_over(self.length) @ np.array(direction.twist, dtype=float)
            columns[:, j] *= unit
            held = direction.freedom is Freedom.DRIVEN or (
                direction.freedom is Freedom.ELASTIC and self.model == "refined"
            )
            if held:
                row = np.zeros(len(directions))
                row[j] = unit / np.sqrt(float(direction.compliance))
                rows.append(row)
        energy = np.array(rows).reshape(-1, len(directions))
        return _Coordinates(columns, energy, tuple(d.name for d in directions))


def _lengths_over(length: float) -> Array:
    return np.diag([1.0 / length] * 3 + [1.0] * 3)


def _block_diagonal(blocks: list[Array]) -> Array:
    result = np.zeros((sum(b.shape[0] for b in blocks), sum(b.shape[1] for b in blocks)))
    row = column = 0
    for block in blocks:
        result[row : row + block.shape[0], column : column + block.shape[1]] = block
        row, column = row + block.shape[0], column + block.shape[1]
    return result


def _loops_and_tool(network: Network, columns: list[Array]) -> tuple[Array, Array]:
    """Return the loop equations (6 n_loops, n) and the tool's twist (6, n), unit-free."""
    ends = np.cumsum([0, *(block.shape[1] for block in columns)])
    motion_of: dict[Node, Array] = {network.base: np.zeros((6, ends[-1]))}
    loops = []
    waiting = list(enumerate(network.edges))
    while waiting:
        ready = [(i, e) for i, e in waiting if e.a in motion_of or e.b in motion_of]
        if not ready:
            break
        i, edge = ready[0]
        waiting.remove((i, edge))
        step = np.zeros((6, ends[-1]))
        step[:, ends[i] : ends[i + 1]] = columns[i]
        if edge.a in motion_of and edge.b in motion_of:
            loops.append(motion_of[edge.a] + step - motion_of[edge.b])
        elif edge.a in motion_of:
            motion_of[edge.b] = motion_of[edge.a] + step
        else:
            motion_of[edge.a] = motion_of[edge.b] - step
    return np.concatenate([np.zeros((0, ends[-1])), *loops]), motion_of[network.tool]


@dataclass(frozen=True, eq=False)
class _System:
    """The robot's coordinates x at one posture, unit-free."""

    loops: Array
    """(6 n_loops, n): loops x = 0."""
    tool: Array
    """(6, n): the tool's twist is tool x."""
    energy: Array
    """(m, n): the energy is |energy x|^2 / 2."""
    names: list[str]
    length: float

    def solve(self) -> AssembledCompliance:
        closed = null_space(self.loops)
        held = self.energy @ closed
        # What is free is a matter of geometry, so springs of any stiffness count alike.
        sizes = np.linalg.norm(self.energy, axis=1, keepdims=True)
        geometry = self.energy / np.where(sizes > 0.0, sizes, 1.0)
        free = null_space(geometry @ closed)
        stiff = null_space(free.T) if free.shape[1] else np.eye(closed.shape[1])
        tool = self.tool @ closed
        free_motions, idle_motions = self._free_motions(tool @ free, closed @ free)
        # The deflection under a wrench w is G (G^T w) with G = tool (energy)^+: a least-squares
        # problem, twice as precise as the normal equations.
        if stiff.shape[1]:
            _, R = np.linalg.qr(held @ stiff)
            G = np.linalg.solve(R.T, (tool @ stiff).T).T
        else:
            G = np.zeros((6, 0))
        k = G @ G.T
        to_si = np.diag([self.length] * 3 + [1.0] * 3)
        compliance = to_si @ k @ to_si if not free_motions else None
        return AssembledCompliance(
            compliance, self._stiffness(G, tool @ free, to_si), free_motions, idle_motions
        )

    def _stiffness(self, G: Array, free: Array, to_si: Array) -> Array | None:
        """Return the stiffness: on the wrenches that do no work on free motions, k's inverse."""
        carried = null_space(free.T) if rank(free) else np.eye(6)
        half = carried.T @ G
        if rank(half / max(np.linalg.norm(half), np.finfo(float).tiny)) < carried.shape[1]:
            return None
        root = np.linalg.pinv(half)
        inverse = np.linalg.inv(to_si)
        return np.asarray(inverse @ carried @ root.T @ root @ carried.T @ inverse)

    def _free_motions(
        self, tool: Array, coordinates: Array
    ) -> tuple[tuple[FreeMotion, ...], tuple[FreeMotion, ...]]:
        """Split free coordinates (n, k) into motions that move the tool (6, k) and idle ones."""
        if coordinates.shape[1] == 0:
            return (), ()
        n_tool = rank(tool)
        _, _, Vt = np.linalg.svd(tool)
        of_tool = Vt[:n_tool].T @ plain_basis(tool @ Vt[:n_tool].T)
        idle = Vt[n_tool:].T @ plain_basis(coordinates @ Vt[n_tool:].T)
        return (
            tuple(self._motion(tool, coordinates @ weights) for weights in of_tool.T),
            tuple(self._motion(None, coordinates @ weights) for weights in idle.T),
        )

    def _motion(self, tool: Array | None, x: Array) -> FreeMotion:
        moves = np.abs(x) > 1e-6 * np.abs(x).max()
        moving = tuple(name for name, m in zip(self.names, moves, strict=True) if m)
        if tool is None:
            return FreeMotion(np.zeros(6), moving)
        return FreeMotion(np.array([self.length] * 3 + [1.0] * 3) * (self.tool @ x), moving)


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
