"""Laws of stiffness, on random mechanisms at random postures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from stiffkit.kinematics import ClosureEquations
from stiffkit.robot import DIRECTIONS, Freedom, Joint
from stiffkit.smallmat import ZERO_SHARE, as_objects
from stiffkit.spatial import Frame, exp_rotation
from stiffkit.stiffness import (
    AssembledCompliance,
    Assembly,
    Composition,
    SimplifiedModel,
    full_matrices,
)
from tests.properties.mechanisms import (
    LENGTH,
    Chain,
    JointSpec,
    LinkSpec,
    Mechanism,
    build,
    elastic_links,
    joint_specs,
    legs,
    mechanisms,
    moved,
    planar_mechanisms,
    seeds,
    split,
)
from tests.properties.reference import (
    UNIT_FREE,
    compliance_by_nodes,
    leg_elements,
    leg_stiffness,
)

Array = NDArray[np.float64]

any_mechanism = st.one_of(mechanisms(), planar_mechanisms())


def assembled(mechanism: Mechanism) -> AssembledCompliance:
    tree = mechanism.tree
    return Assembly(tree, LENGTH).at(mechanism.coordinates(tree))


def held(mechanism: Mechanism) -> Array:
    """Return the assembly's compliance, of a mechanism that is held in all directions."""
    compliance = assembled(mechanism).compliance
    assume(compliance is not None)
    assert compliance is not None
    assume(condition(compliance) < 1e7)
    return compliance


def stiffness_of(mechanism: Mechanism) -> Array:
    """Return the assembly's stiffness, which may be semi-definite but not infinite."""
    stiffness = assembled(mechanism).stiffness
    assume(stiffness is not None)
    assert stiffness is not None
    return stiffness


def composed(mechanism: Mechanism) -> tuple[Array, float]:
    """Return the fast path's compliance and its share of stiffness, at one posture."""
    tree = mechanism.tree
    composition = Composition(tree, LENGTH)
    assume(composition.available)
    q, c = mechanism.coordinates(tree), composition.constants.values
    out = np.array(composition.kernel().function(as_objects(q), as_objects(c)), dtype=float)
    return full_matrices(out[:21, None])[..., 0], float(out[21])


def condition(k: Array) -> float:
    return float(np.linalg.cond(UNIT_FREE @ k @ UNIT_FREE))


def difference(k: Array, expected: Array) -> float:
    """Return the relative difference of two compliances, free of units."""
    size = np.linalg.norm(UNIT_FREE @ expected @ UNIT_FREE)
    return float(np.linalg.norm(UNIT_FREE @ (k - expected) @ UNIT_FREE) / size)


def independence(mechanism: Mechanism) -> float:
    """Return how independent the passive joints of the legs are: 1 if at right angles.

    Redundant ones do not count. Mechanisms in which they are nearly redundant are not used: they
    are at the border of what is called singular.
    """
    least = 1.0
    for leg in mechanism.legs:
        S, J = leg_elements(mechanism, leg)
        if J.shape[1] and condition(S) < 1e12:
            strains = np.linalg.solve(np.linalg.cholesky(S), J)
            values = np.linalg.svd(strains / np.linalg.norm(strains, axis=0), compute_uv=False)
            least = min(least, float(np.min(values[values > 1e-9 * values[0]]) / values[0]))
    assume(least > 1e-4)
    return least**2


def stiffness_difference(K: Array, expected: Array) -> float:
    """Return the relative difference of two stiffnesses, free of units."""
    scale = np.linalg.inv(UNIT_FREE)
    size = np.linalg.norm(scale @ expected @ scale)
    return float(np.linalg.norm(scale @ (K - expected) @ scale) / size)


def allowed(mechanism: Mechanism, k: Array) -> float:
    """Return 1e-9, or what rounding leaves.

    It leaves less where one direction of the tool is a million times softer than another, and where
    the passive joints of a leg are nearly redundant, such as three hinges nearly in line.
    """
    return 1e-9 + 1e-14 * condition(k) + 1e-15 / independence(mechanism)


# The fast path and the references.


@given(st.one_of(mechanisms(depth=2), planar_mechanisms()))
@settings(max_examples=300)
def test_fast_path_is_the_assembly(mechanism: Mechanism) -> None:
    assume(independence(mechanism) > 0.0)
    expected = assembled(mechanism).compliance
    k, share = composed(mechanism)
    if expected is None:
        assert not (share > ZERO_SHARE and np.isfinite(k).all())
    else:
        assert share > ZERO_SHARE
        assert difference(k, expected) < allowed(mechanism, expected)


@given(any_mechanism)
def test_assembly_is_the_sum_over_nodes(mechanism: Mechanism) -> None:
    k = held(mechanism)
    assume(condition(k) < 1e5)
    assert difference(compliance_by_nodes(mechanism), k) < 1e-7


@given(st.lists(legs(), min_size=1, max_size=3), seeds)
def test_assembly_is_the_block_inverse_of_the_papers(chains: list[Chain], seed: int) -> None:
    """Briot et al. 2009: eq. 4 for each leg, eq. 3 with its passive joints, eq. 9 for their sum."""
    mechanism = build(tuple(chains), seed)
    k = held(mechanism)
    assume(condition(k) < 1e5)
    K = np.sum([leg_stiffness(mechanism, leg) for leg in mechanism.legs], axis=0)
    assert difference(np.asarray(np.linalg.inv(K)), k) < 1e-7


# The simplified model.


def _leg(*kinds: str) -> Chain:
    """Return a leg of joints with rigid links between them; a star marks a driven joint."""
    axes = {"universal": ("y", "z"), "revolute": ("z",), "prismatic": ("x",)}
    return tuple(
        JointSpec(
            kind.strip("*"),
            axes.get(kind.strip("*"), ()),
            motions=Freedom.DRIVEN if kind.endswith("*") else Freedom.PASSIVE,
        )
        for kind in kinds
    )


SIX_LEGS = [
    _leg("universal", "prismatic*", "spherical"),
    _leg("spherical", "prismatic*", "spherical"),
    _leg("revolute*", "universal", "spherical"),
    _leg("prismatic*", "universal", "spherical"),
]
THREE_LEGS = [
    _leg("revolute*", "revolute*", "revolute", "spherical"),
    _leg("prismatic*", "revolute*", "revolute", "spherical"),
    _leg("universal*", "prismatic", "spherical"),
]
TWO_LEGS = [
    _leg("revolute*", "revolute*", "prismatic*", "spherical"),
    _leg("universal*", "prismatic*", "spherical"),
]
SERIAL = [_leg("universal*", "prismatic*", "revolute*", "universal*"), _leg("revolute*")]
PLANAR = [_leg("revolute*", "revolute", "revolute"), _leg("prismatic*", "revolute", "revolute")]


@st.composite
def fully_driven(draw: st.DrawFn) -> Mechanism:
    """Draw a mechanism with as many drives as degrees of freedom."""
    kinds, n = draw(
        st.sampled_from([(SIX_LEGS, 6), (THREE_LEGS, 3), (TWO_LEGS, 2), (SERIAL, 1), (PLANAR, 3)])
    )
    chains = draw(st.lists(st.sampled_from(kinds), min_size=n, max_size=n))
    return build(tuple(chains), draw(seeds), "planar" if kinds is PLANAR else "general")


@given(fully_driven())
def test_jacobian_and_drives_are_the_simplified_assembly(mechanism: Mechanism) -> None:
    """Briot et al. 2009, eqs 1 and 2."""
    tree = mechanism.tree
    q = mechanism.coordinates(tree)
    model = SimplifiedModel(ClosureEquations(tree, (), LENGTH))
    out = np.array(
        model.kernel().function(as_objects(q), as_objects(model.constants.values)), dtype=float
    )
    k, leverage, J = full_matrices(out[:21, None])[..., 0], out[21], out[22:].reshape(6, -1)
    assume(leverage < 1e5)
    expected = Assembly(tree, LENGTH, "simplified").at(q).compliance
    assert expected is not None
    assert difference(k, expected) < 1e-9
    drives = [name.split(".") for name in model.drive_names]
    stiffness = [
        mechanism.robot.joints[joint].stiffness[DIRECTIONS.index(direction)]
        for joint, direction in drives
    ]
    assert difference(J @ np.diag(1.0 / np.array(stiffness)) @ J.T, expected) < 1e-9


# What every compliance is.


@given(any_mechanism)
def test_compliance_and_stiffness_are_symmetric_and_not_negative(mechanism: Mechanism) -> None:
    found = assembled(mechanism)
    for matrix, scale in (
        (found.compliance, UNIT_FREE),
        (found.stiffness, np.linalg.inv(UNIT_FREE)),
    ):
        if matrix is not None:
            M = scale @ matrix @ scale
            size = float(np.linalg.norm(M))
            np.testing.assert_allclose(M, M.T, atol=1e-12 * size)
            assert np.linalg.eigvalsh(M)[0] > -1e-12 * size


@given(any_mechanism)
def test_fast_compliance_is_not_negative(mechanism: Mechanism) -> None:
    k, share = composed(mechanism)
    assume(share > ZERO_SHARE)
    M = UNIT_FREE @ k @ UNIT_FREE
    assert np.linalg.eigvalsh(M)[0] > -1e-9 * np.linalg.norm(M)


@given(any_mechanism)
def test_compliance_and_stiffness_are_inverse(mechanism: Mechanism) -> None:
    k = held(mechanism)
    assume(condition(k) < 1e6)
    np.testing.assert_allclose(
        UNIT_FREE @ k @ stiffness_of(mechanism) @ np.linalg.inv(UNIT_FREE), np.eye(6), atol=1e-7
    )


@given(any_mechanism)
def test_free_motions_are_not_held_and_others_are(mechanism: Mechanism) -> None:
    found = assembled(mechanism)
    assume(found.stiffness is not None)
    assert found.stiffness is not None
    K = np.linalg.inv(UNIT_FREE) @ found.stiffness @ np.linalg.inv(UNIT_FREE)
    twists = np.array([UNIT_FREE @ motion.twist for motion in found.free_motions]).reshape(-1, 6)
    assert np.linalg.matrix_rank(K, tol=1e-11 * np.linalg.norm(K)) == 6 - len(twists)
    np.testing.assert_allclose(K @ twists.T, 0.0, atol=1e-9 * float(np.linalg.norm(K)))


# What changes nothing.


rotations = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@given(any_mechanism, rotations, rotations)
def test_world_frame_does_not_matter(
    mechanism: Mechanism, turn: tuple[float, ...], shift: tuple[float, ...]
) -> None:
    k = held(mechanism)
    T = Frame(exp_rotation(turn), np.array(shift))
    R = np.kron(np.eye(2), T.rotation)
    assert difference(held(moved(mechanism, T)), R @ k @ R.T) < allowed(mechanism, k)


@given(any_mechanism, rotations)
def test_world_frame_does_not_matter_to_the_fast_path(
    mechanism: Mechanism, turn: tuple[float, ...]
) -> None:
    k, share = composed(mechanism)
    assume(share > 1e-7)
    T = Frame(exp_rotation(turn), np.array([0.3, -0.2, 0.5]))
    R = np.kron(np.eye(2), T.rotation)
    assert difference(composed(moved(mechanism, T))[0], R @ k @ R.T) < allowed(mechanism, k)


@given(any_mechanism, seeds)
def test_a_rigid_link_split_in_two_is_the_same(mechanism: Mechanism, seed: int) -> None:
    k = held(mechanism)
    rng = np.random.default_rng(seed)
    rigid = [n for n, link in mechanism.robot.links.items() if link.compliance is None]
    cut = split(mechanism, str(rng.choice(rigid)), rng)
    assert difference(held(cut), k) < allowed(mechanism, k)
    if Composition(cut.tree, LENGTH).available:
        assert difference(composed(cut)[0], k) < allowed(mechanism, k)


@given(any_mechanism, seeds)
def test_the_order_of_parts_does_not_matter(mechanism: Mechanism, seed: int) -> None:
    k = held(mechanism)
    rng = np.random.default_rng(seed)
    links, joints = list(mechanism.robot.links.items()), list(mechanism.robot.joints.items())
    shuffled = mechanism.with_parts(
        dict(links[i] for i in rng.permutation(len(links))),
        dict(joints[i] for i in rng.permutation(len(joints))),
    )
    assert difference(held(shuffled), k) < allowed(mechanism, k)


# Sums.


@given(mechanisms(most_legs=3))
def test_stiffnesses_of_parallel_legs_add(mechanism: Mechanism) -> None:
    total = stiffness_of(mechanism)
    parts = [stiffness_of(mechanism.only([i])) for i in range(len(mechanism.legs))]
    assume(np.any(parts))
    assert stiffness_difference(total, np.sum(parts, axis=0)) < 1e-8


@given(
    st.lists(st.one_of(joint_specs(("revolute", "prismatic")), elastic_links), min_size=1),
    seeds,
)
def test_compliances_in_a_chain_add(elements: list[JointSpec | LinkSpec], seed: int) -> None:
    chain = tuple(
        replace(e, motions=Freedom.DRIVEN) if isinstance(e, JointSpec) else e for e in elements
    )
    mechanism = build((chain,), seed)
    S, J = leg_elements(mechanism, mechanism.legs[0])
    assert J.shape[1] == 0
    assume(np.any(S))
    compliance = assembled(mechanism).compliance
    assert compliance is not None
    assert difference(compliance, S) < 1e-12


# Passive joints and soft parts.


@given(legs(depth=0), seeds)
def test_a_passive_direction_carries_no_load(chain: Chain, seed: int) -> None:
    mechanism = build((chain,), seed)
    K = stiffness_of(mechanism)
    _, J = leg_elements(mechanism, mechanism.legs[0])
    scale = np.linalg.inv(UNIT_FREE)
    size = float(np.linalg.norm(scale @ K @ scale))
    np.testing.assert_allclose(scale @ K @ scale @ (UNIT_FREE @ J), 0.0, atol=1e-9 * (size + 1.0))


@given(any_mechanism, st.floats(1.0, 100.0), seeds)
def test_adding_compliance_never_stiffens(mechanism: Mechanism, factor: float, seed: int) -> None:
    k = held(mechanism)
    links, joints = dict(mechanism.robot.links), dict(mechanism.robot.joints)
    soft = [n for n, link in links.items() if link.compliance is not None]
    soft += [n for n, joint in joints.items() if np.any(_springs(joint))]
    name = str(np.random.default_rng(seed).choice(soft))
    if name in links:
        links[name] = replace(links[name], compliance=factor * np.array(links[name].compliance))
    else:
        springs = np.where(_springs(joints[name]), 1.0 / factor, 1.0)
        joints[name] = replace(joints[name], stiffness=joints[name].stiffness * springs)
    softer = held(mechanism.with_parts(links, joints))
    gain = UNIT_FREE @ (softer - k) @ UNIT_FREE
    size = np.linalg.norm(UNIT_FREE @ softer @ UNIT_FREE)
    assert np.linalg.eigvalsh(gain)[0] > -1e-9 * size


@given(any_mechanism)
def test_a_bearing_that_yields_never_stiffens(mechanism: Mechanism) -> None:
    """Each blocked direction in turn, made elastic."""
    k = held(mechanism)
    joints = dict(mechanism.robot.joints)
    name, joint = next(iter(joints.items()))
    blocked = np.array([freedom is Freedom.BLOCKED for freedom in joint.freedoms])
    assume(blocked.any())
    i = int(np.flatnonzero(blocked)[0])
    freedoms, stiffness = list(joint.freedoms), joint.stiffness.copy()
    freedoms[i], stiffness[i] = Freedom.ELASTIC, 1e7
    joints[name] = replace(joint, freedoms=tuple(freedoms), stiffness=stiffness)
    softer = held(mechanism.with_parts(dict(mechanism.robot.links), joints))
    gain = UNIT_FREE @ (softer - k) @ UNIT_FREE
    assert np.linalg.eigvalsh(gain)[0] > -1e-9 * np.linalg.norm(UNIT_FREE @ softer @ UNIT_FREE)


def _springs(joint: Joint) -> NDArray[np.bool_]:
    return np.array([f in (Freedom.DRIVEN, Freedom.ELASTIC) for f in joint.freedoms])
