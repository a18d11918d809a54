"""Coordinates of everything that can move or deform, at single postures.

Every elastic link and every joint contributes coordinates: six elastic deflections for each port
of the link but its base and, if asked for, the link's internal modes; or the joint's directions
that are passive, driven or elastic. Loops
tie the coordinates together exactly, so rigid parts, over-constrained loops, redundant passive
joints and singular postures need no special care. All numbers are unit-free: lengths are over the
robot's typical length, and twists are those of the point at the tool, in world axes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction, Constants, Kernel
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.network.graph import JointPart, LinkPart, Network, Node, build_network
from stiffkit.network.parts import PartsAtTool, add_elasticity, loose_directions
from stiffkit.robot import Freedom, Joint, Link, Robot
from stiffkit.smallmat import Scalar, Vector, from_lower_triangle, lower_triangle, vector

Array = NDArray[np.float64]

Model = Literal["refined", "simplified"]
"""refined: links, joints and drives are elastic; simplified: the drives only."""


@dataclass(frozen=True, eq=False)
class _Block:
    """The coordinates of a link or a joint: how they move its far sides, and what holds them."""

    columns: Array
    """(p, 6, n), twist for a unit of each coordinate, of each of the p edges that it stands for in
    the network: one for a joint, and one for each port of a link but its base."""
    energy: Array
    """(m, n), so that the energy is |energy x|^2 / 2; passive coordinates have no row."""
    names: tuple[str, ...]
    """Such as "elbow.rz", "leg.bending" or "leg.mode"."""


@dataclass(frozen=True, eq=False)
class CoordinatesAtPosture:
    """The coordinates x (n,) of a robot at one posture."""

    loops: Array
    """(6 n_loops, n): loops x = 0."""
    motion_of: Mapping[Node, Array]
    """(6, n) for each rigid cluster: its twist is motion_of x."""
    energy: Array
    """(m, n): the energy is |energy x|^2 / 2."""
    names: list[str]
    tool: Array
    """(6, n): the tool's twist is tool x."""


class NetworkCoordinates:
    """Makes the coordinates of a robot's postures."""

    def __init__(
        self,
        tree: SpanningTree,
        length: float,
        model: Model = "refined",
        *,
        mode_stiffness: Mapping[str, Array] | None = None,
        backend: Backend | None = None,
    ) -> None:
        """Take the mechanism and a length (m) that makes everything unit-free.

        ``mode_stiffness`` holds the squared angular frequencies (n,) of links' internal modes.
        """
        self.tree = tree
        self.length = length
        self.model = model
        self.constants = Constants()
        add_elasticity(self.constants, tree.robot, length)
        self.network: Network = build_network(tree.robot)
        self._elements = elements_of(self.network, tree.robot)
        self._mode_stiffness = mode_stiffness or {}
        self._parts = BatchFunction(self._parts_kernel(), backend)

    def at_each(self, q: Array) -> Iterator[CoordinatesAtPosture]:
        """Yield the coordinates at each posture, given by coordinates (n, N) of the tree, SI."""
        for values in self._parts(q).T:
            yield self._at(values)

    def _parts_kernel(self) -> Kernel:
        """Return the kernel that refers all parts to the tool point.

        Inputs: coordinates of the tree. Outputs, part by part: the lower triangle of a link's
        compliance (21 if it has two ports), or the unit twists (6 each) of a joint's loose
        directions; SI.
        """
        robot = self.tree.robot

        def parts(q: Vector, c: Vector) -> Vector:
            at_tool = PartsAtTool(Located(self.tree, self.constants, q, c), self.constants, c)
            values: list[Scalar] = []
            for part in self._elements:
                if isinstance(part, Link):
                    values += list(lower_triangle(at_tool.whole_compliance(part)))
                else:
                    for loose in at_tool.joint_looseness(part):
                        values += list(loose.twist)
            return vector(values)

        loose = tuple(tuple(loose_directions(joint)) for joint in robot.joints.values())
        topology = (self.tree.topology, self.network.edges, loose)
        return Kernel("parts", parts, self.tree.n_coordinates, self.constants, topology)

    def _at(self, values: Array) -> CoordinatesAtPosture:
        blocks: list[_Block] = []
        start = 0
        for part in self._elements:
            if isinstance(part, Link):
                size = 6 * len(part.other_ports)
                end = start + size * (size + 1) // 2
                blocks.append(self._link_block(part, values[start:end]))
            else:
                end = start + 6 * len(loose_directions(part))
                blocks.append(self._joint_block(part, values[start:end].reshape(-1, 6)))
            start = end
        loops, motion_of = _loops_and_motions(self.network, _steps(blocks))
        return CoordinatesAtPosture(
            loops,
            motion_of,
            _block_diagonal([block.energy for block in blocks]),
            [name for block in blocks for name in block.names],
            motion_of[self.network.tool],
        )

    def _link_block(self, link: Link, lower: Array) -> _Block:
        p = len(link.other_ports)
        if self.model == "simplified":
            return _Block(np.zeros((p, 6, 0)), np.zeros((0, 0)), ())
        S = np.array(from_lower_triangle(vector(lower.tolist())), dtype=float)
        unit_free = np.tile([1.0 / self.length] * 3 + [1.0] * 3, p)
        # With S = L L^T deflections y hold the energy |L^-1 y|^2 / 2.
        L = np.linalg.cholesky(unit_free[:, None] * S * unit_free)
        modes = np.sqrt(self._mode_stiffness.get(link.name, np.zeros(0)))
        return _Block(
            np.eye(6 * p, 6 * p + modes.size).reshape(p, 6, -1),
            _block_diagonal([np.linalg.inv(L), np.diag(modes)]),
            (f"{link.name}.bending",) * 6 * p + (f"{link.name}.mode",) * modes.size,
        )

    def _joint_block(self, joint: Joint, twists: Array) -> _Block:
        columns, roots, names = [], [], []
        for direction, twist in zip(loose_directions(joint), twists, strict=True):
            held = direction.freedom is Freedom.DRIVEN or (
                direction.freedom is Freedom.ELASTIC and self.model == "refined"
            )
            if not (held or direction.moves):
                continue
            unit = 1.0 if direction.turns else self.length
            columns.append(unit * (_lengths_over(self.length) @ twist))
            roots.append(unit * np.sqrt(joint.stiffness[direction.index]) if held else 0.0)
            names.append(direction.name)
        energy = np.diag(np.array(roots))[np.array(roots) > 0.0]
        return _Block(np.array(columns).reshape(-1, 6).T[None], energy, tuple(names))


def elements_of(network: Network, robot: Robot) -> list[Link | Joint]:
    """Return the links and joints that the edges of a network belong to, in order, each once."""
    parts = [edge.part for edge in network.edges]
    found = [robot.links[part.name] for part in parts if isinstance(part, LinkPart)]
    return [
        *dict.fromkeys(found),
        *(robot.joints[part.name] for part in parts if isinstance(part, JointPart)),
    ]


def _lengths_over(length: float) -> Array:
    return np.diag([1.0 / length] * 3 + [1.0] * 3)


def _block_diagonal(blocks: list[Array]) -> Array:
    result = np.zeros((sum(b.shape[0] for b in blocks), sum(b.shape[1] for b in blocks)))
    row = column = 0
    for block in blocks:
        result[row : row + block.shape[0], column : column + block.shape[1]] = block
        row, column = row + block.shape[0], column + block.shape[1]
    return result


def _steps(blocks: list[_Block]) -> list[Array]:
    """Return the twists (6, n) across the edges, in their order, for a unit of each coordinate."""
    n = sum(len(block.names) for block in blocks)
    steps, start = [], 0
    for block in blocks:
        end = start + len(block.names)
        for columns in block.columns:
            step = np.zeros((6, n))
            step[:, start:end] = columns
            steps.append(step)
        start = end
    return steps


def _loops_and_motions(network: Network, steps: list[Array]) -> tuple[Array, dict[Node, Array]]:
    """Return the loop equations (6 n_loops, n) and the twist (6, n) of each rigid cluster."""
    n = steps[0].shape[1] if steps else 0
    motion_of: dict[Node, Array] = {network.base: np.zeros((6, n))}
    loops = []
    waiting = list(enumerate(network.edges))
    while waiting:
        ready = next(((i, e) for i, e in waiting if e.a in motion_of or e.b in motion_of), None)
        if ready is None:
            break
        waiting.remove(ready)
        i, edge = ready
        step = steps[i]
        if edge.a in motion_of and edge.b in motion_of:
            loops.append(motion_of[edge.a] + step - motion_of[edge.b])
        elif edge.a in motion_of:
            motion_of[edge.b] = motion_of[edge.a] + step
        else:
            motion_of[edge.a] = motion_of[edge.b] - step
    return np.concatenate([np.zeros((0, n)), *loops]), motion_of
