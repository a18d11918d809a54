"""The fast model: the lowest natural frequencies of many postures, as a posture kernel.

Elastic coordinates are followed in the axes of their own link or joint, where the modes of one
posture look much like those of another. A few of them span what is needed (`Basis`). At a posture
each basis vector closes the loops by the deflection of least energy: with A x = 0 the loops and W
the compliances,

    x = (I - W A^T (A W A^T)^-1 A) phi,

so that only A, made of the joints' and links' places, depends on the posture. Passive directions
enter with a compliance that is large but finite, whose energy is taken out again: the loops are
closed exactly, and what comes out are the Rayleigh quotients of the full model on a subspace.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Constants, Kernel
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.link.ports import carried
from stiffkit.network import (
    JointPart,
    LinkPart,
    Network,
    Node,
    PartsAtTool,
    add_elasticity,
    build_network,
    loose_directions,
)
from stiffkit.robot import Freedom, Link, Robot
from stiffkit.smallmat import (
    Matrix,
    Scalar,
    Vector,
    add,
    dot,
    factor,
    lower_triangle,
    matmul,
    minus,
    multiply,
    outer_sum,
    plus,
    scale,
    skew,
    sqrt,
    symmetric,
    vector,
    zeros,
)
from stiffkit.vibration.bodies import Bodies

Array = NDArray[np.float64]

_PASSIVE = 1e5
"""Compliance of a passive direction over a typical elastic one."""


@dataclass(frozen=True, eq=False)
class Basis:
    """Vectors of elastic coordinates, edge by edge, of unit energy and orthogonal in it."""

    edges: tuple[Array, ...]
    """(n_e, r) for each edge of the network: six deflections of a link's port in link axes, or the
    loose directions of a joint; SI. Passive rows are zero."""
    modes: dict[str, Array]
    """(n, r), of the internal modes of each elastic link."""

    @property
    def size(self) -> int:
        """r."""
        return int(self.edges[0].shape[1])


@dataclass(frozen=True)
class _Route:
    """Edges passed on the way to a node, or around a loop, with their sense."""

    signs: tuple[tuple[int, float], ...]


def routes(network: Network) -> tuple[dict[Node, _Route], list[_Route]]:
    """Return the route from the base to each node, and the loops."""
    way: dict[Node, dict[int, float]] = {network.base: {}}
    loops: list[_Route] = []
    waiting = list(enumerate(network.edges))
    while waiting:
        ready = next(((i, e) for i, e in waiting if e.a in way or e.b in way), None)
        if ready is None:
            break
        waiting.remove(ready)
        i, edge = ready
        if edge.a in way and edge.b in way:
            loop = {i: 1.0}
            for signs, sense in ((way[edge.a], 1.0), (way[edge.b], -1.0)):
                for j, sign in signs.items():
                    loop[j] = loop.get(j, 0.0) + sense * sign
            loops.append(_Route(tuple((j, s) for j, s in sorted(loop.items()) if s != 0.0)))
        elif edge.a in way:
            way[edge.b] = {**way[edge.a], i: 1.0}
        else:
            way[edge.a] = {**way[edge.b], i: -1.0}
    return {node: _Route(tuple(signs.items())) for node, signs in way.items()}, loops


def add_basis_and_masses(
    constants: Constants, robot: Robot, bodies: Bodies, basis: Basis, length: float
) -> None:
    """Store what the kernel reads beside the robot's geometry and elasticity."""
    links = [link for link in robot.links.values() if link.compliance is not None]
    soft = [
        float(np.trace(k[i : i + 3, i : i + 3])) / 3.0
        for k in (x.compliance for x in links)
        if k is not None
        for i in range(0, len(k), 6)
    ]
    drives = [
        (1.0 / s) * (length**2 if d.turns else 1.0)
        for joint in robot.joints.values()
        for d in loose_directions(joint)
        if d.freedom is not Freedom.PASSIVE and (s := joint.stiffness[d.index]) > 0.0
    ]
    typical = _PASSIVE * float(np.mean(soft + drives))
    constants.add("passive", np.array([typical, typical / length**2]))
    for i, rows in enumerate(basis.edges):
        constants.add(f"basis:{i}", rows)
    for name, mass in bodies.rigid.items():
        constants.add_symmetric(f"mass:{name}", mass)
    for name, element in bodies.elastic.items():
        _add_elastic_mass(constants, robot.links[name], element.mass, basis.modes[name])
    constants.add("tool mass", np.array([bodies.tool_mass]))


def _add_elastic_mass(constants: Constants, link: Link, mass: Array, modes: Array) -> None:
    """Store the mass for [base twist; ports' deflections], and what the constant modes add."""
    n = 6 * len(link.ports)
    carry = np.eye(mass.shape[0])
    carry[6:n, :6] = carried([link.ports[port].position for port in link.other_ports])
    M = carry.T @ mass @ carry
    constants.add_symmetric(f"mass:{link.name}", M[:n, :n])
    constants.add(f"modes:{link.name}", M[:n, n:] @ modes)
    constants.add_symmetric(f"own:{link.name}", modes.T @ M[n:, n:] @ modes)


class ReducedKernel:
    """The reduced mass and stiffness of a robot, for a basis."""

    def __init__(self, tree: SpanningTree, length: float, bodies: Bodies, basis: Basis) -> None:
        """Take the mechanism, a typical length (m), its masses and the basis."""
        self.tree = tree
        self.robot = tree.robot
        self.bodies = bodies
        self.basis = basis
        self.network = build_network(self.robot)
        self._way, self._loops = routes(self.network)
        self.edge_of = {edge.part: i for i, edge in enumerate(self.network.edges)}
        self.constants = Constants()
        add_elasticity(self.constants, self.robot, length)
        add_basis_and_masses(self.constants, self.robot, bodies, basis, length)

    def kernel(self, *, with_factor: bool = False) -> Kernel:
        """Return the kernel.

        Inputs: coordinates of the tree. Outputs: the lower triangle of L^-1 M L^-T with the reduced
        stiffness L L^T and mass M; its eigenvalues are 1/omega^2, the largest belonging to the
        lowest mode. With ``with_factor`` the lower triangle of L follows: it takes an eigenvector y
        to L y, the parts that the basis vectors have in the mode, of unit energy.
        """
        r = self.basis.size
        entries = [(i, j) for i in range(r) for j in range(i + 1)]

        def reduced(q: Vector, c: Vector) -> Vector:
            located = Located(self.tree, self.constants, q, c)
            posture = _Posture(self, located, c)
            K, M = posture.stiffness(), posture.mass()
            factors = factor(K)
            half = [factors.solve_half(M[:, j]) for j in range(r)]
            # Solve from the other side too, and give both sides the roots of the pivots.
            C = zeros(r, r)
            for i in range(r):
                column = factors.solve_half(vector(half[j][i] for j in range(r)))
                for j in range(r):
                    C[i, j] = column[j]
            roots = vector(sqrt(d) for d in factors.inverse_pivots)
            scaled = lower_triangle(symmetric(r, lambda i, j: C[i, j] * roots[i] * roots[j]))
            if not with_factor:
                return scaled
            pivots = vector(sqrt(d) for d in factors.pivots)
            return vector([*scaled, *(multiply(factors.L[i, j], pivots[j]) for i, j in entries)])

        topology = (
            self.tree.topology,
            self.network.edges,
            r,
            tuple(self.bodies.rigid),
            tuple(self.bodies.elastic),
            tuple(tuple(loose_directions(joint)) for joint in self.robot.joints.values()),
        )
        name = "reduced modes and factor" if with_factor else "reduced modes"
        return Kernel(name, reduced, self.tree.n_coordinates, self.constants, topology, large=True)


class _Posture:
    """The network at one posture, acting on the basis."""

    def __init__(self, model: ReducedKernel, located: Located, c: Vector) -> None:
        self.model = model
        self.located = located
        self.c = c
        self.parts = PartsAtTool(located, model.constants, c)
        self.r = model.basis.size
        edges = model.network.edges
        self._columns = [self._edge_columns(i) for i in range(len(edges))]
        self._moved = [self._edge_motion(i) for i in range(len(edges))]
        self._flexibility = self._flexibilities()
        self._wrench = self._loop_wrenches()
        self._steps = [self._closed_step(i) for i in range(len(edges))]

    def _read(self, name: str) -> Matrix:
        return self.model.constants.read(self.c, name)

    def _edge_columns(self, i: int) -> Matrix:
        """Return the twist at the tool point (6, n_e) for a unit of each coordinate, SI, world."""
        part = self.model.network.edges[i].part
        if isinstance(part, JointPart):
            loose = self.parts.joint_looseness(self.model.robot.joints[part.name])
            columns = zeros(6, len(loose))
            for j, direction in enumerate(loose):
                columns[:, j] = direction.twist
            return columns
        if not isinstance(part, LinkPart):
            raise TypeError("the fast model works on the network before its reduction")
        return self.parts.from_port(self.model.robot.links[part.name], part.port)

    def _edge_motion(self, i: int) -> Matrix:
        """Return what the basis does across an edge: twists (6, r)."""
        return matmul(self._columns[i], self._read(f"basis:{i}"))

    def _flexibilities(self) -> dict[int, dict[int, Matrix]]:
        """Return the twists (6, 6) across edges under wrenches on those that they depend on.

        An edge depends on itself alone, one of a link on all edges of that link.
        """
        found: dict[int, dict[int, Matrix]] = {}
        for i, edge in enumerate(self.model.network.edges):
            if not isinstance(edge.part, LinkPart):
                found[i] = {i: self._joint_flexibility(i)}
                continue
            link, port = self.model.robot.links[edge.part.name], edge.part.port
            found[i] = {i: self.parts.link_compliance(link, port)}
            for other in link.other_ports[: link.other_ports.index(port)]:
                j = self.model.edge_of[LinkPart(link.name, other)]
                found[i][j] = self.parts.link_coupling(link, port, other)
                found[j][i] = found[i][j].T
        return found

    def _joint_flexibility(self, i: int) -> Matrix:
        S = zeros(6, 6)
        for weight, twist, _passive in self._weighted(i):
            S = outer_sum(S, twist, weight)
        return S

    def _weighted(self, i: int) -> list[tuple[Scalar, Vector, bool]]:
        """Return compliance, twist, and whether it is passive, of each direction of a joint."""
        part = self.model.network.edges[i].part
        if not isinstance(part, JointPart):
            return []
        passive = self._read("passive")
        weighted = []
        for loose in self.parts.joint_looseness(self.model.robot.joints[part.name]):
            is_passive = loose.direction.freedom is Freedom.PASSIVE
            stand_in = passive[1] if loose.direction.turns else passive[0]
            weighted.append((stand_in if is_passive else loose.compliance, loose.twist, is_passive))
        return weighted

    def _loop_wrenches(self) -> list[Matrix | None]:
        """Return the wrench (6, r) that closes the loops, edge by edge."""
        loops, n = self.model._loops, len(self.model.network.edges)
        wrench: list[Matrix | None] = [None] * n
        if not loops:
            self._gap = zeros(0, self.r)
            self._half = zeros(0, self.r)
            return wrench
        S = zeros(6 * len(loops), 6 * len(loops))
        gap = zeros(6 * len(loops), self.r)
        for a, first in enumerate(loops):
            rows = slice(6 * a, 6 * a + 6)
            for i, sign in first.signs:
                gap[rows] = plus(gap[rows], scale(sign, self._moved[i]))
            for b, second in enumerate(loops[: a + 1]):
                other = dict(second.signs)
                for i, sign in first.signs:
                    for j in (j for j in self._flexibility[i] if j in other):
                        block = slice(6 * b, 6 * b + 6)
                        S[rows, block] = plus(
                            S[rows, block], scale(sign * other[j], self._flexibility[i][j])
                        )
                S[6 * b : 6 * b + 6, rows] = S[rows, 6 * b : 6 * b + 6].T
        factors = factor(S)
        solved = zeros(6 * len(loops), self.r)
        for j in range(self.r):
            solved[:, j] = factors.solve(gap[:, j])
        self._gap, self._solved = gap, solved
        for a, loop in enumerate(loops):
            for i, sign in loop.signs:
                share = scale(sign, solved[6 * a : 6 * a + 6])
                known = wrench[i]
                wrench[i] = share if known is None else plus(known, share)
        return wrench

    def stiffness(self) -> Matrix:
        """Return the reduced stiffness (r, r): the basis has unit energy before it is closed."""
        K = symmetric(self.r, lambda i, j: 1.0 if i == j else 0.0)
        if not self.model._loops:
            return K
        work = symmetric(self.r, lambda i, j: dot(self._gap[:, i], self._solved[:, j]))
        K = minus(K, work)
        for i, wrench in enumerate(self._wrench):
            if wrench is None:
                continue
            for weight, twist, is_passive in self._weighted(i):
                if is_passive:
                    pushed = matmul(wrench.T, twist)
                    K = outer_sum(K, pushed, multiply(-1.0, weight))
        return K

    def _motion(self, node: Node) -> Matrix:
        """Return the twist (6, r) of a rigid cluster at the tool point, loops closed."""
        V = zeros(6, self.r)
        for i, sign in self.model._way[node].signs:
            V = plus(V, scale(sign, self._steps[i]))
        return V

    def _closed_step(self, i: int) -> Matrix:
        """Return what the basis does across an edge, loops closed: twists (6, r)."""
        step = self._moved[i]
        for j, flexibility in self._flexibility[i].items():
            wrench = self._wrench[j]
            if wrench is not None:
                step = minus(step, matmul(flexibility, wrench))
        return step

    def mass(self) -> Matrix:
        """Return the reduced mass (r, r)."""
        model = self.model
        M = zeros(self.r, self.r)
        for name in model.bodies.rigid:
            twist = self._at_origin(name, "base")
            mass = model.constants.read_symmetric(self.c, f"mass:{name}")
            M = plus(M, _quadratic(twist, matmul(mass, twist)))
        for name in model.bodies.elastic:
            M = plus(M, self._elastic_mass(name))
        if model.bodies.tool_mass:
            V = self._motion(model.network.tool)[:3]
            M = plus(M, _quadratic(V, scale(self._read("tool mass")[0], V)))
        return M

    def _elastic_mass(self, name: str) -> Matrix:
        constants = self.model.constants
        rows = np.concatenate([self._at_origin(name, "base"), self._deflections(name)])
        mass = constants.read_symmetric(self.c, f"mass:{name}")
        from_modes = scale(2.0, self._read(f"modes:{name}"))
        M = _quadratic(rows, plus(matmul(mass, rows), from_modes))
        return plus(M, constants.read_symmetric(self.c, f"own:{name}"))

    def _deflections(self, name: str) -> Matrix:
        """Return the deflections (6p, r) of a link's p ports, link axes, loops closed."""
        ports = self.model.robot.links[name].other_ports
        edges = [self.model.edge_of[LinkPart(name, port)] for port in ports]
        own = np.concatenate([self._read(f"basis:{i}") for i in edges])
        loads = zeros(*own.shape)
        for at, i in enumerate(edges):
            wrench = self._wrench[i]
            if wrench is not None:
                loads[6 * at : 6 * at + 6] = matmul(self._columns[i].T, wrench)
        S = self.model.constants.read_symmetric(self.c, f"compliance:{name}")
        return minus(own, matmul(S, loads))

    def _at_origin(self, name: str, port: str) -> Matrix:
        """Return the twist (6, r) of a body at its link's origin, link axes."""
        V = self._motion(self.model.network.cluster_of(name, port))
        body = self.located.body(name)
        arm = minus(body.p, self.located.tool.p)
        moved = zeros(6, self.r)
        moved[:3] = matmul(body.R.T, minus(V[:3], matmul(skew(arm), V[3:])))
        moved[3:] = matmul(body.R.T, V[3:])
        return moved


def _quadratic(A: Matrix, B: Matrix) -> Matrix:
    """Return the symmetric part of A^T B."""
    return symmetric(
        A.shape[1],
        lambda i, j: (
            dot(A[:, i], B[:, j])
            if i == j
            else multiply(0.5, add(dot(A[:, i], B[:, j]), dot(A[:, j], B[:, i])))
        ),
    )
