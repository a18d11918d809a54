"""Laws that the stiffness of any mechanism obeys, on random ones."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from stiffkit.compiled import BatchFunction
from stiffkit.smallmat import ZERO_SHARE
from stiffkit.spatial import Frame, shift_compliance
from stiffkit.stiffness import Assembly, Composition, full_matrices
from tests.properties.mechanisms import (
    LENGTH,
    LinkSpec,
    Mechanism,
    build,
    elastic_links,
    mechanisms,
    moved,
    planar_mechanisms,
    random_frame,
    seeds,
    split,
)

Array = NDArray[np.float64]

UNIT_FREE = np.diag([1.0 / LENGTH] * 3 + [1.0] * 3)

anything = st.one_of(mechanisms(), planar_mechanisms())


def assembled(mechanism: Mechanism) -> Array | None:
    """Compliance by the general assembly, unit-free; None where the tool is free."""
    tree = mechanism.tree
    found = Assembly(tree, LENGTH).at(mechanism.coordinates(tree)).compliance
    return None if found is None else np.asarray(UNIT_FREE @ found @ UNIT_FREE)


def composed(mechanism: Mechanism) -> tuple[Array, float]:
    """Compliance by composition, unit-free, and the smallest share."""
    tree = mechanism.tree
    composition = Composition(tree, LENGTH)
    assume(composition.available)
    out = BatchFunction(composition.kernel(), "numpy")(mechanism.coordinates(tree)[:, None])
    return np.asarray(UNIT_FREE @ full_matrices(out[:21])[..., 0] @ UNIT_FREE), float(out[21, 0])


def close(actual: Array, expected: Array, tolerance: float = 1e-9) -> bool:
    return bool(np.abs(actual - expected).max() <= tolerance * np.abs(expected).max())


def ordinary(k: Array) -> bool:
    """Whether the tool is held so well that rounding does not decide."""
    return bool(np.linalg.cond(k) < 1e6)


@given(anything)
def test_composition_agrees_with_the_general_assembly(mechanism: Mechanism) -> None:
    expected = assembled(mechanism)
    assume(expected is not None)
    assert expected is not None
    assume(ordinary(expected))
    actual, _ = composed(mechanism)
    assert close(actual, expected)


@given(anything)
def test_both_ways_agree_on_what_is_free(mechanism: Mechanism) -> None:
    expected = assembled(mechanism)
    actual, share = composed(mechanism)
    if expected is None:
        assert not np.isfinite(actual).all() or share < ZERO_SHARE
    elif ordinary(expected):
        assert share > ZERO_SHARE


@given(anything)
def test_compliance_is_symmetric_and_positive(mechanism: Mechanism) -> None:
    k = assembled(mechanism)
    assume(k is not None)
    assert k is not None
    assert np.array_equal(k, k.T) or close(k, k.T, 1e-14)
    values = np.linalg.eigvalsh(k)
    assert values[0] >= -1e-12 * values[-1]


@given(anything, seeds)
def test_a_change_of_world_frame_only_turns_the_compliance(mechanism: Mechanism, seed: int) -> None:
    k = assembled(mechanism)
    assume(k is not None)
    assert k is not None
    T_new_old = random_frame(np.random.default_rng(seed))
    turn = np.kron(np.eye(2), T_new_old.rotation)
    k_moved = assembled(moved(mechanism, T_new_old))
    assert k_moved is not None
    assert close(k_moved, turn @ k @ turn.T)


@given(anything, seeds)
def test_splitting_a_rigid_link_changes_nothing(mechanism: Mechanism, seed: int) -> None:
    k = assembled(mechanism)
    assume(k is not None)
    assert k is not None
    k_split = assembled(split(mechanism, "platform", np.random.default_rng(seed)))
    assert k_split is not None
    assert close(k_split, k)


def leg_stiffnesses(mechanism: Mechanism) -> list[Array] | None:
    """Stiffness of each leg alone at the tool, None where one is rigid somewhere."""
    found = []
    for i in range(len(mechanism.legs)):
        leg = mechanism.only([i])
        tree = leg.tree
        K = Assembly(tree, LENGTH).at(leg.coordinates(tree)).stiffness
        if K is None:
            return None
        found.append(np.linalg.inv(UNIT_FREE) @ K @ np.linalg.inv(UNIT_FREE))
    return found


@given(anything)
def test_parallel_legs_add_their_stiffness(mechanism: Mechanism) -> None:
    expected = assembled(mechanism)
    assume(expected is not None)
    assert expected is not None
    assume(ordinary(expected))
    parts = leg_stiffnesses(mechanism)
    assume(parts is not None)
    assert parts is not None
    assert close(np.linalg.inv(np.sum(parts, axis=0)), expected, 1e-7)


@given(st.lists(elastic_links, min_size=1, max_size=4), seeds)
def test_serial_links_add_their_compliance(links: list[LinkSpec], seed: int) -> None:
    mechanism = build((tuple(links),), seed)
    tool = mechanism.T_world_tool.position
    total = np.zeros((6, 6))
    for name, link in mechanism.robot.links.items():
        if link.compliance is not None:
            body = mechanism.T_world[name]
            tip = body.point(link.ports["tip"].position)
            total += shift_compliance(link.compliance, Frame(body.rotation, tip - tool))
    expected = assembled(mechanism)
    assert expected is not None
    assert close(UNIT_FREE @ total @ UNIT_FREE, expected)


@given(anything)
def test_passive_joints_carry_no_load(mechanism: Mechanism) -> None:
    # A leg alone moves without any wrench along each of its own free motions.
    for i in range(len(mechanism.legs)):
        leg = mechanism.only([i])
        tree = leg.tree
        found = Assembly(tree, LENGTH).at(leg.coordinates(tree))
        if found.stiffness is None:
            continue
        for motion in found.free_motions:
            wrench = UNIT_FREE @ found.stiffness @ motion.twist
            size = np.linalg.norm(UNIT_FREE @ found.stiffness, 2) * np.linalg.norm(motion.twist)
            assert np.linalg.norm(wrench) <= 1e-8 * size
