"""The fast path: the robot's stiffness by series and parallel composition, as a posture kernel."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stiffkit.compiled import Constants, Kernel
from stiffkit.kinematics import Located, SpanningTree
from stiffkit.network import (
    Coupled,
    JointPart,
    LinkPart,
    Looseness,
    Parallel,
    Part,
    PartsAtTool,
    add_elasticity,
    build_network,
    links_of,
    loose_directions,
    members,
    reduce_network,
)
from stiffkit.robot import Freedom, Robot
from stiffkit.smallmat import (
    Matrix,
    Scalar,
    Vector,
    factor,
    lower_triangle,
    multiply,
    outer_sum,
    plus,
    reciprocal,
    release,
    series,
    smallest,
    soften,
    symmetric,
    vector,
    zeros,
)


@dataclass(frozen=True, eq=False)
class _Held:
    """The stiffness of a part."""

    stiffness: Matrix
    """(6, 6), positive semi-definite."""
    scale: Vector
    """(6,), diagonal of the stiffness with passive joints locked. What is small beside it is
    rounding; the diagonal of `stiffness` itself may be no more than that."""


@dataclass(eq=False)
class _Chain:
    """What stands in series between two bodies; the order does not matter at one point."""

    compliance: Matrix | None = None
    """Sum over elastic links, (6, 6)."""
    soft: list[Looseness] = field(default_factory=list)
    passive: list[Looseness] = field(default_factory=list)
    groups: list[_Held] = field(default_factory=list)
    """Parallel groups, which may have free motions."""


class Composition:
    """A robot as one expression of series and parallel parts."""

    def __init__(self, tree: SpanningTree, length: float) -> None:
        """Reduce the robot's network; `available` tells whether that was possible."""
        self.tree = tree
        self.robot: Robot = tree.robot
        self.part = reduce_network(build_network(self.robot))
        self.constants = Constants()
        add_elasticity(self.constants, self.robot, length)

    @property
    def available(self) -> bool:
        """Whether the robot is series-parallel and no branch of it is rigid in a direction."""
        return self.part is not None and self._has_stiffness(self.part)

    def _has_stiffness(self, part: Part) -> bool:
        """Tell whether the stiffness of a part is finite, by counting its directions."""
        if isinstance(part, Parallel):
            return all(self._has_stiffness(p) for p in part.parts)
        parts = members(part)
        if any(isinstance(p, Parallel) for p in parts):
            return all(self._has_stiffness(p) for p in parts if isinstance(p, Parallel))
        if any(isinstance(p, LinkPart | Coupled) for p in parts):
            return True
        loose = sum(
            len(loose_directions(self.robot.joints[p.name]))
            for p in parts
            if isinstance(p, JointPart)
        )
        return loose >= 6

    def kernel(self) -> Kernel:
        """Return the kernel of the tool's compliance.

        Inputs: coordinates of the tree. Outputs: the lower triangle of the compliance (21, SI,
        world axes, at the tool point), and the smallest share of a direction's stiffness that is
        left with passive joints released, which is zero where the tool can move freely.
        """
        if self.part is None:
            raise ValueError("the robot is not series-parallel")
        root = self.part

        def compliance(q: Vector, c: Vector) -> Vector:
            located = Located(self.tree, self.constants, q, c)
            held = self._held(root, PartsAtTool(located, self.constants, c))
            k = factor(held.stiffness).inverse()
            shares = [reciprocal(multiply(k[i, i], held.scale[i])) for i in range(6)]
            return vector([*lower_triangle(k), smallest(shares)])

        elastic = tuple(
            (joint.name, joint.freedoms, tuple(np.isfinite(joint.stiffness)))
            for joint in self.robot.joints.values()
        )
        return Kernel(
            "compliance",
            compliance,
            self.tree.n_coordinates,
            self.constants,
            (self.tree.topology, root, elastic),
        )

    def _held(self, part: Part, parts: PartsAtTool) -> _Held:
        """Return the stiffness of a part."""
        if isinstance(part, Parallel):
            K, scale = zeros(6, 6), zeros(6)
            for branch in part.parts:
                held = self._held(branch, parts)
                K, scale = plus(K, held.stiffness), plus(scale, held.scale)
            return _Held(K, scale)
        if isinstance(part, Coupled):
            return self._held_together(part, parts)
        return _held_by_chain(self._chain(part, parts), parts.length)

    def _chain(self, part: Part, parts: PartsAtTool) -> _Chain:
        chain = _Chain()
        for p in members(part):
            self._append(chain, p, parts)
        return chain

    def _held_together(self, part: Coupled, parts: PartsAtTool) -> _Held:
        """Return the stiffness of coupled chains, by the twists of all their ends side by side."""
        n = len(part.chains)
        chains = [self._chain(chain, parts) for chain in part.chains]
        S = self._whole_compliance(part, chains, parts)
        for at, chain in enumerate(chains):
            for soft in chain.soft:
                S = outer_sum(S, _among(soft.twist, at, n), soft.compliance)
        K = factor(S).inverse()
        passive = [
            _among(loose.twist, at, n) for at, chain in enumerate(chains) for loose in chain.passive
        ]
        locked = _with_one_end(K)
        return _Held(_with_one_end(release(K, passive)), vector(locked[i, i] for i in range(6)))

    def _whole_compliance(self, part: Coupled, chains: list[_Chain], parts: PartsAtTool) -> Matrix:
        """Return the compliance (6n, 6n) of the ends of n coupled chains, all by their links."""
        S = zeros(6 * len(chains), 6 * len(chains))
        for a, chain in enumerate(chains):
            own = slice(6 * a, 6 * a + 6)
            S[own, own] = zeros(6, 6) if chain.compliance is None else chain.compliance
            for b in range(a):
                other = slice(6 * b, 6 * b + 6)
                for first in links_of(part.chains[a]):
                    for second in links_of(part.chains[b]):
                        if first.name == second.name:
                            link = self.robot.links[first.name]
                            coupling = parts.link_coupling(link, first.port, second.port)
                            S[own, other] = plus(S[own, other], coupling)
                S[other, own] = S[own, other].T
        return S

    def _append(self, chain: _Chain, part: Part, parts: PartsAtTool) -> None:
        if isinstance(part, LinkPart):
            S = parts.link_compliance(self.robot.links[part.name], part.port)
            chain.compliance = S if chain.compliance is None else plus(chain.compliance, S)
        elif isinstance(part, JointPart):
            for loose in parts.joint_looseness(self.robot.joints[part.name]):
                passive = loose.direction.freedom is Freedom.PASSIVE
                (chain.passive if passive else chain.soft).append(loose)
        else:
            chain.groups.append(self._held(part, parts))


def _among(twist: Vector, at: int, n: int) -> Vector:
    """Return a twist (6,) at the place that it has among n of them."""
    whole = zeros(6 * n)
    whole[6 * at : 6 * at + 6] = twist
    return whole


def _with_one_end(K: Matrix) -> Matrix:
    """Return the stiffness (6, 6) of chains (6n, 6n) whose ends move as one."""
    blocks = [slice(6 * i, 6 * i + 6) for i in range(K.shape[0] // 6)]
    total = zeros(6, 6)
    for rows in blocks:
        for columns in blocks:
            total = plus(total, K[rows, columns])
    return symmetric(6, lambda i, j: total[i, j])


def _held_by_chain(chain: _Chain, length: Scalar) -> _Held:
    if chain.groups and chain.compliance is None:
        return _held_by_groups(chain)
    S = chain.compliance if chain.compliance is not None else _padding(chain, length)
    for soft in chain.soft:
        S = outer_sum(S, soft.twist, soft.compliance)
    K = factor(S).inverse()
    held = _Held(K, vector(K[i, i] for i in range(6)))
    for group in chain.groups:
        held = _in_series(group, held)
    passive = [loose.twist for loose in chain.passive]
    scale = held.scale if chain.groups else None
    return _Held(release(held.stiffness, passive, scale=scale), held.scale)


def _held_by_groups(chain: _Chain) -> _Held:
    """Return the stiffness of groups with nothing but joints beside them, which soften it."""
    held, *others = chain.groups
    for group in others:
        held = _in_series(held, group)
    K = held.stiffness
    for soft in chain.soft:
        K = soften(K, soft.twist, soft.compliance)
    passive = [loose.twist for loose in chain.passive]
    return _Held(release(K, passive, scale=held.scale), held.scale)


def _in_series(first: _Held, second: _Held) -> _Held:
    """Return two parts one behind the other; the free motions of the first stay free exactly."""
    total = plus(first.scale, second.scale)
    K = series(first.stiffness, second.stiffness, total)
    scale = vector(
        multiply(multiply(a, b), reciprocal(c))
        for a, b, c in zip(first.scale, second.scale, total, strict=True)
    )
    return _Held(K, scale)


def _padding(chain: _Chain, length: Scalar) -> Matrix:
    """Return a compliance along the passive directions only.

    A chain of rigid links is stiff in the directions that neither a drive nor a passive joint
    moves it in; where there are none, any compliance along its passive directions makes its
    compliance matrix definite and is removed with them. Its size is that of the drives.
    """
    typical: Scalar = 0.0
    for soft in chain.soft:
        typical = typical + soft.compliance * (length * length if soft.direction.turns else 1.0)
    S = zeros(6, 6)
    for passive in chain.passive:
        weight = typical / (length * length) if passive.direction.turns else typical
        S = outer_sum(S, passive.twist, weight)
    return S
