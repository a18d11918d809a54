"""Joints, loops and their derivatives, on random mechanisms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from stiffkit.kinematics import ClosureEquations, Mobility
from stiffkit.kinematics.closure import tool_jacobian
from stiffkit.kinematics.coordinates import joint_coordinates, rotation_vectors
from stiffkit.kinematics.frames import joint_motion
from stiffkit.kinematics.locate import Located
from stiffkit.kinematics.numeric import evaluate, null_space
from stiffkit.robot import DIRECTIONS, Freedom
from stiffkit.smallmat import as_objects
from stiffkit.spatial import exp_rotation, log_rotation
from tests.properties.mechanisms import (
    AXES_OF_KIND,
    LENGTH,
    JointSpec,
    Mechanism,
    build,
    mechanisms,
    motion_frame,
    motions_of,
    planar_mechanisms,
    seeds,
)

Array = NDArray[np.float64]

KINDS = [(kind, axes) for kind, options in AXES_OF_KIND.items() for axes in options]
STEP = 1e-6


def angles(limit: float) -> st.SearchStrategy[float]:
    """Draw an angle in rad, often near zero or near the limit."""
    return st.one_of(
        st.floats(-limit, limit),
        st.sampled_from([0.0, 1e-9, -1e-9, 1e-5, limit, -limit, np.pi / 2, -np.pi / 2]),
    )


# Coordinates of joints.


@pytest.mark.parametrize(("kind", "axes"), KINDS)
@given(st.data())
def test_joint_coordinates_are_read_back(
    kind: str, axes: tuple[str, ...], data: st.DataObject
) -> None:
    """Up to a millionth of a radian from half a turn."""
    motions = motions_of(kind, axes)
    q = np.array(
        [
            data.draw(angles(np.pi - 1e-6) if m.startswith("r") else st.floats(-1, 1))
            for m in motions
        ]
    )
    if kind == "spherical":
        q *= min(1.0, (np.pi - 1e-6) / (np.linalg.norm(q) + 1e-300))
    frame = motion_frame(kind, motions, tuple(q))
    joint = next(iter(build(((JointSpec(kind, axes),),), 0).robot.joints.values()))
    found = joint_coordinates(joint, frame.rotation[..., None], frame.position[:, None])
    np.testing.assert_allclose(found[:, 0], q, atol=1e-9)
    assert found.shape == (len(motions), 1)


@pytest.mark.parametrize(("kind", "axes"), KINDS)
@given(seeds)
def test_joint_motion_moves_as_the_model_says(kind: str, axes: tuple[str, ...], seed: int) -> None:
    joint = next(iter(build(((JointSpec(kind, axes),),), 0).robot.joints.values()))
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, len(joint.motions))
    found = joint_motion(joint, as_objects(q))
    expected = motion_frame(kind, joint.motions, tuple(q))
    np.testing.assert_allclose(np.array(found.R, dtype=float), expected.rotation, atol=1e-14)
    np.testing.assert_allclose(np.array(found.p, dtype=float), expected.position, atol=1e-14)


@given(st.tuples(*[angles(3.0)] * 3))
def test_rotation_vectors_of_a_batch(turn: tuple[float, ...]) -> None:
    w = np.array(turn)
    R = np.stack([exp_rotation(w), exp_rotation(-w), np.eye(3)], axis=-1)
    found = rotation_vectors(R)
    for i in range(3):
        np.testing.assert_allclose(exp_rotation(found[:, i]), R[..., i], atol=1e-12)
        assert np.linalg.norm(found[:, i]) <= np.pi + 1e-12


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.sampled_from([0.0, 1e-12, 1e-9, 1e-6, 1e-3]))
def test_rotation_vectors_near_half_a_turn(axis: tuple[float, ...], less: float) -> None:
    size = float(np.linalg.norm(axis))
    if size < 1e-3:
        return
    w = (np.pi - less) * np.array(axis) / size
    found = rotation_vectors(exp_rotation(w)[..., None])[:, 0]
    np.testing.assert_allclose(exp_rotation(found), exp_rotation(w), atol=1e-9)
    assert np.linalg.norm(found) == pytest.approx(np.pi - less, abs=1e-9)


# Closed postures and derivatives.


@given(st.one_of(mechanisms(), planar_mechanisms()))
def test_loops_are_closed_where_the_frames_say_so(mechanism: Mechanism) -> None:
    tree = mechanism.tree
    loops = ClosureEquations(tree, (), LENGTH)
    residuals = evaluate(loops, mechanism.coordinates(tree), np.empty(0)).residuals
    np.testing.assert_allclose(residuals, 0.0, atol=1e-12)


@given(st.one_of(mechanisms(), planar_mechanisms()))
def test_bodies_are_where_they_were_put(mechanism: Mechanism) -> None:
    tree = mechanism.tree
    loops = ClosureEquations(tree, (), LENGTH)
    q = as_objects(mechanism.coordinates(tree))
    located = Located(tree, loops.constants, q, as_objects(loops.constants.values))
    for name, frame in mechanism.T_world.items():
        found = located.body(name)
        np.testing.assert_allclose(np.array(found.R, dtype=float), frame.rotation, atol=1e-12)
        np.testing.assert_allclose(np.array(found.p, dtype=float), frame.position, atol=1e-12)


def differences(closure: ClosureEquations, unknowns: Array, asked: Array) -> Array:
    """Return the closure's derivatives by central differences, unit-free."""
    residuals = evaluate(closure, unknowns, asked).residuals
    jacobian = np.zeros((len(residuals), len(unknowns)))
    for i, translates in enumerate(closure.translates):
        step = np.zeros(len(unknowns))
        step[i] = STEP * (LENGTH if translates else 1.0)
        ahead = evaluate(closure, unknowns + step, asked).residuals
        behind = evaluate(closure, unknowns - step, asked).residuals
        jacobian[:, i] = (ahead - behind) / (2 * STEP)
    return jacobian


def loop_of(kind: str, axes: tuple[str, ...], *, reverse: bool, seed: int) -> Mechanism:
    """Return a loop that is closed by a joint of a kind; all other joints are driven."""
    others = [
        JointSpec(other, options[0], motions=Freedom.DRIVEN, reverse=i % 2 == 0)
        for i, (other, options) in enumerate(AXES_OF_KIND.items())
        if other != "fixed"
    ]
    return build((tuple(others), (JointSpec(kind, axes, reverse=reverse),)), seed)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(("kind", "axes"), KINDS)
@given(seeds)
@settings(max_examples=5)
def test_closure_jacobian_of_each_kind(
    kind: str, axes: tuple[str, ...], reverse: bool, seed: int
) -> None:
    """The joint closes a loop in which each other kind is a joint of the tree, both ways round."""
    mechanism = loop_of(kind, axes, reverse=reverse, seed=seed)
    tree = mechanism.tree
    loops = ClosureEquations(tree, (), LENGTH)
    q = mechanism.coordinates(tree)
    (chord,) = tree.chords
    assert chord.kind == kind
    found = evaluate(loops, q, np.empty(0))
    np.testing.assert_allclose(found.jacobian, differences(loops, q, np.empty(0)), atol=1e-8)
    blocked = 6 - len(chord.motions)
    assert np.linalg.matrix_rank(found.jacobian, tol=1e-8) == blocked


@given(mechanisms(), st.sets(st.sampled_from(DIRECTIONS), min_size=1))
def test_closure_jacobian_with_tool_coordinates(mechanism: Mechanism, asked: set[str]) -> None:
    tree = mechanism.tree
    q = mechanism.coordinates(tree)
    T = mechanism.T_world_tool
    pose = np.concatenate([T.position, log_rotation(T.rotation)])
    actual = dict(zip(DIRECTIONS, pose, strict=True))
    closure = ClosureEquations(tree, [d for d in actual if d in asked], LENGTH)
    unknowns = np.concatenate([q, [actual[d] for d in closure.auxiliary]])
    values = np.array([actual[d] for d in closure.asked])
    found = evaluate(closure, unknowns, values)
    np.testing.assert_allclose(found.residuals, 0.0, atol=1e-9)
    np.testing.assert_allclose(
        found.jacobian, differences(closure, unknowns, values), rtol=1e-6, atol=1e-7
    )


@given(mechanisms())
def test_tool_jacobian(mechanism: Mechanism) -> None:
    """Against the motion of the tool's frame."""
    tree = mechanism.tree
    loops = ClosureEquations(tree, (), LENGTH)
    q = mechanism.coordinates(tree)
    observe, c = loops.observation().function, as_objects(loops.constants.values)

    def tool(q: Array) -> tuple[Array, Array]:
        frame = np.array(observe(as_objects(q), c)[:12], dtype=float)
        return frame[:9].reshape(3, 3), frame[9:]

    found = tool_jacobian(loops, q)
    rates = tool_jacobian(loops, q, rotation_vector_rates=True)
    R, _ = tool(q)
    for i, translates in enumerate(loops.translates):
        step = np.zeros(len(q))
        step[i] = STEP * (LENGTH if translates else 1.0)
        (R_ahead, p_ahead), (R_behind, p_behind) = tool(q + step), tool(q - step)
        moved = (p_ahead - p_behind) / (2 * STEP * LENGTH)
        turned = log_rotation(R_ahead @ R_behind.T) / (2 * STEP)
        np.testing.assert_allclose(found[:3, i], moved, atol=1e-8)
        np.testing.assert_allclose(found[3:, i], turned, atol=1e-8)
        if np.linalg.norm(log_rotation(R)) < 3.0:
            rate = (log_rotation(R_ahead) - log_rotation(R_behind)) / (2 * STEP)
            np.testing.assert_allclose(rates[3:, i], rate, rtol=1e-6, atol=1e-6)


# Trees and mobility.


@given(st.one_of(mechanisms(depth=2), planar_mechanisms()))
def test_the_tree_reaches_all_bodies_once(mechanism: Mechanism) -> None:
    tree = mechanism.tree
    assert sorted(t.child for t in tree.joints) == sorted(mechanism.robot.links)
    assert len(tree.joints) + len(tree.chords) == len(mechanism.robot.joints)
    for body in mechanism.robot.links:
        path = tree.path(body)
        assert [t.parent for t in path] == ["base", *(t.child for t in path[:-1])]
        assert path[-1].child == body
    assert len(tree.coordinate_names) == tree.n_coordinates == len(tree.motions)


@given(mechanisms())
def test_the_tree_prefers_driven_joints(mechanism: Mechanism) -> None:
    """A driven joint closes a loop only if all of that loop's joints are driven."""
    tree = mechanism.tree
    for chord in tree.chords:
        if Freedom.DRIVEN in chord.freedoms:
            left, right = tree.loop(chord)
            assert all(Freedom.DRIVEN in t.joint.freedoms for t in [*left, *right])


@given(st.one_of(mechanisms(), planar_mechanisms()))
def test_counted_and_numeric_mobility_differ_by_redundant_equations(mechanism: Mechanism) -> None:
    tree = mechanism.tree
    loops = ClosureEquations(tree, (), LENGTH)
    q = mechanism.coordinates(tree)
    mobility = Mobility.of(loops, q)
    equations = 6 * len(tree.chords) - sum(len(chord.motions) for chord in tree.chords)
    independent = tree.n_coordinates - mobility.numeric
    assert mobility.counted == tree.n_coordinates - equations
    assert mobility.over_constraint == equations - independent
    assert mobility.over_constraint >= 0
    assert 0 <= mobility.tool <= min(6, mobility.numeric)
    assert 0 <= mobility.idle <= mobility.numeric - mobility.tool


@given(st.one_of(mechanisms(), planar_mechanisms()))
def test_free_motions_keep_the_loops_closed(mechanism: Mechanism) -> None:
    """A small step along the null space opens the loops to second order only."""
    tree = mechanism.tree
    loops = ClosureEquations(tree, (), LENGTH)
    q = mechanism.coordinates(tree)
    free = null_space(evaluate(loops, q, np.empty(0)).jacobian)
    scales = np.where(loops.translates, LENGTH, 1.0)
    for direction in free.T:
        step = 1e-6 * scales * direction
        residuals = evaluate(loops, q + step, np.empty(0)).residuals
        np.testing.assert_allclose(residuals, 0.0, atol=1e-10)


@given(mechanisms(), seeds)
def test_the_topology_tells_trees_apart(mechanism: Mechanism, seed: int) -> None:
    """Drives on other joints may give another tree, whose kernels must not be shared."""
    rng = np.random.default_rng(seed)
    joints = {}
    for name, joint in mechanism.robot.joints.items():
        state = Freedom.DRIVEN if rng.random() < 0.5 else Freedom.PASSIVE
        freedoms = tuple(
            state if direction in joint.motions else freedom
            for direction, freedom in zip(DIRECTIONS, joint.freedoms, strict=True)
        )
        joints[name] = replace(joint, freedoms=freedoms)
    other = mechanism.with_parts(dict(mechanism.robot.links), joints).tree
    tree = mechanism.tree
    same = [t.joint.name for t in tree.joints] == [t.joint.name for t in other.joints]
    assert (tree.topology == other.topology) == same
