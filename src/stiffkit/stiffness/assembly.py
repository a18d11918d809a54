"""The general assembly: any mechanism, one posture at a time, with NumPy's linear algebra.

Every elastic link and every joint contributes coordinates: six elastic deflections, or the joint's
directions that are passive, driven or elastic. Loops tie the coordinates together exactly, so rigid
parts, over-constrained loops, redundant passive joints and singular postures need no special care.
It is slow, and the reference that the fast path is tested against.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction, Constants, Kernel
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.kinematics.numeric import null_space, rank
from stiffkit.robot import Freedom, Joint
from stiffkit.smallmat import Scalar, Vector, lower_triangle, vector
from stiffkit.stiffness.indices import full_matrices
from stiffkit.stiffness.network import JointPart, LinkPart, Network, Node, build_network
from stiffkit.stiffness.parts import PartsAtTool, add_elasticity, loose_directions

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
        self.tree = tree
        self.length = length
        self.model = model
        self.constants = Constants()
        add_elasticity(self.constants, tree.robot, length)
        self.network = build_network(tree.robot)
        self._parts = BatchFunction(self._parts_kernel(), backend)

    def at(self, q: Array) -> AssembledCompliance:
        """Return compliance and free motions at coordinates (n,) of the tree, SI."""
        return next(self.at_each(q[:, None]))

    def at_each(self, q: Array) -> Iterator[AssembledCompliance]:
        """Yield compliance and free motions at each of the coordinates (n, N) of the tree, SI."""
        for values in self._parts(q).T:
            yield self._system(values).solve()

    def _parts_kernel(self) -> Kernel:
        """Return the kernel that refers all parts to the tool point.

        Inputs: coordinates of the tree. Outputs, edge by edge: the lower triangle of a link's
        compliance (21), or the unit twists (6 each) of a joint's loose directions; SI.
        """
        robot = self.tree.robot

        def parts(q: Vector, c: Vector) -> Vector:
            at_tool = PartsAtTool(Located(self.tree, self.constants, q, c), self.constants, c)
            values: list[Scalar] = []
            for edge in self.network.edges:
                if isinstance(edge.part, LinkPart):
                    compliance = at_tool.link_compliance(robot.links[edge.part.name])
                    values += list(lower_triangle(compliance))
                elif isinstance(edge.part, JointPart):
                    for loose in at_tool.joint_looseness(robot.joints[edge.part.name]):
                        values += list(loose.twist)
            return vector(values)

        loose = tuple(tuple(loose_directions(joint)) for joint in robot.joints.values())
        topology = (self.tree.topology, self.network.edges, loose)
        return Kernel("parts", parts, self.tree.n_coordinates, self.constants, topology)

    def _system(self, values: Array) -> _System:
        robot = self.tree.robot
        blocks: list[_Coordinates] = []
        start = 0
        for edge in self.network.edges:
            if isinstance(edge.part, LinkPart):
                blocks.append(self._link_coordinates(edge.part.name, values[start : start + 21]))
                start += 21
            elif isinstance(edge.part, JointPart):
                joint = robot.joints[edge.part.name]
                end = start + 6 * len(loose_directions(joint))
                blocks.append(self._joint_coordinates(joint, values[start:end].reshape(-1, 6)))
                start = end
        loops, tool = _loops_and_tool(self.network, [block.columns for block in blocks])
        return _System(
            loops,
            tool,
            _block_diagonal([block.energy for block in blocks]),
            [name for block in blocks for name in block.names],
            self.length,
        )

    def _link_coordinates(self, name: str, lower: Array) -> _Coordinates:
        if self.model == "simplified":
            return _Coordinates(np.zeros((6, 0)), np.zeros((0, 0)), ())
        S = full_matrices(lower[:, None])[..., 0]
        unit_free = _lengths_over(self.length)
        # With S = L L^T a deflection y holds the energy |L^-1 y|^2 / 2.
        L = np.linalg.cholesky(unit_free @ S @ unit_free)
        return _Coordinates(np.eye(6), np.linalg.inv(L), (f"{name}.bending",) * 6)

    def _joint_coordinates(self, joint: Joint, twists: Array) -> _Coordinates:
        refined = self.model == "refined"
        columns, rows, names = [], [], []
        for direction, twist in zip(loose_directions(joint), twists, strict=True):
            held = direction.freedom is Freedom.DRIVEN or (
                direction.freedom is Freedom.ELASTIC and refined
            )
            if not (held or direction.moves):
                continue
            unit = 1.0 if direction.turns else self.length
            columns.append(unit * (_lengths_over(self.length) @ twist))
            rows.append(unit * np.sqrt(joint.stiffness[direction.index]) if held else 0.0)
            names.append(direction.name)
        energy = np.diag(rows) if rows else np.zeros((0, 0))
        held_rows = np.array([row > 0.0 for row in rows], dtype=bool)
        return _Coordinates(np.array(columns).reshape(-1, 6).T, energy[held_rows], tuple(names))


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
