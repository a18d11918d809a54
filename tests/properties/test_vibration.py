"""What holds for the frequencies of every mechanism."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from stiffkit.link.superelement import rigid_mass
from stiffkit.robot import Link
from stiffkit.spatial import Frame, exp_rotation, shift_stiffness, skew
from stiffkit.vibration import Discretisation, ModalModel, Modes

from .mechanisms import LENGTH, Mechanism, Rng, mechanisms, moved, seeds, split

Array = NDArray[np.float64]

HOW = Discretisation(n_elements=3, n_modes=4)
N = 4
"""Modes that are compared."""

few = settings(max_examples=25)


def modes_of(mechanism: Mechanism) -> Modes:
    tree = mechanism.tree
    return ModalModel(tree, LENGTH, HOW, backend="numpy").at(mechanism.coordinates(tree), N)


def frequencies(mechanism: Mechanism) -> Array:
    return modes_of(mechanism).frequencies_hz


def with_links(mechanism: Mechanism, changed: dict[str, Link]) -> Mechanism:
    links = {**mechanism.robot.links, **changed}
    return mechanism.with_parts(links, dict(mechanism.robot.joints))


def random_inertia(rng: Rng, mass: float) -> Array:
    """The inertia of a box of some centimetres."""
    a, b, c = mass * rng.uniform(0.02, 0.1, 3) ** 2 / 12.0
    R = exp_rotation(rng.uniform(-2, 2, 3))
    return np.asarray(R @ np.diag([b + c, c + a, a + b]) @ R.T)


def massive(mechanism: Mechanism, rng: Rng) -> Mechanism:
    """Return the mechanism with mass in the platform, and in every elastic link with a length."""
    links = {}
    for name, link in mechanism.robot.links.items():
        mass = float(rng.uniform(0.5, 5.0))
        if link.compliance is not None and np.any(link.ports["tip"].position):
            links[name] = replace(link, mass=mass, inertia=random_inertia(rng, mass))
        elif name == "platform":
            center = rng.uniform(-0.1, 0.1, 3)
            links[name] = replace(
                link, mass=mass, center_of_mass=center, inertia=random_inertia(rng, mass)
            )
    return with_links(mechanism, links)


@st.composite
def vibrating(draw: st.DrawFn) -> Mechanism:
    """Draw a mechanism with mass that has an elastic mode."""
    mechanism = massive(draw(mechanisms(depth=0)), np.random.default_rng(draw(seeds)))
    assume(frequencies(mechanism).size > 0)
    return mechanism


def assert_same(actual: Array, expected: Array) -> None:
    np.testing.assert_allclose(actual, expected, rtol=1e-6)


@few
@given(vibrating(), seeds)
def test_world_frame_does_not_matter(mechanism: Mechanism, seed: int) -> None:
    rng = np.random.default_rng(seed)
    T = Frame(exp_rotation(rng.uniform(-2, 2, 3)), rng.uniform(-1, 1, 3))
    assert_same(frequencies(moved(mechanism, T)), frequencies(mechanism))


@few
@given(vibrating(), seeds)
def test_a_rigid_body_may_be_split(mechanism: Mechanism, seed: int) -> None:
    rng = np.random.default_rng(seed)
    bare = with_links(mechanism, {"platform": Link("platform", {"base": Frame()})})
    cut = split(bare, "platform", rng)
    pieces = {}
    for name in ("platform", "piece"):
        mass = float(rng.uniform(0.5, 5.0))
        pieces[name] = Link(
            name,
            {"base": Frame()},
            mass=mass,
            center_of_mass=rng.uniform(-0.1, 0.1, 3),
            inertia=random_inertia(rng, mass),
        )
    T_body_piece = cut.T_world["platform"].inverse @ cut.T_world["piece"]
    whole = as_one_body(
        mass_matrix(pieces["platform"])
        + shift_stiffness(mass_matrix(pieces["piece"]), T_body_piece)
    )
    assert_same(
        frequencies(with_links(cut, pieces)), frequencies(with_links(bare, {"platform": whole}))
    )


def mass_matrix(link: Link) -> Array:
    assert link.mass is not None
    assert link.center_of_mass is not None
    return rigid_mass(link.mass, link.center_of_mass, link.inertia)


def as_one_body(M: Array) -> Link:
    """Return the rigid body with a mass matrix (6, 6) about its origin."""
    mass = float(M[0, 0])
    C = M[3:, :3] / mass
    center = np.array([C[2, 1], C[0, 2], C[1, 0]])
    inertia = M[3:, 3:] + mass * skew(center) @ skew(center)
    return Link("platform", {"base": Frame()}, mass=mass, center_of_mass=center, inertia=inertia)


@few
@given(vibrating())
def test_four_times_the_stiffness_doubles_frequencies(mechanism: Mechanism) -> None:
    links = {
        name: link if link.compliance is None else replace(link, compliance=link.compliance / 4.0)
        for name, link in mechanism.robot.links.items()
    }
    joints = {
        name: replace(joint, stiffness=4.0 * joint.stiffness)
        for name, joint in mechanism.robot.joints.items()
    }
    assert_same(frequencies(mechanism.with_parts(links, joints)), 2.0 * frequencies(mechanism))


@few
@given(vibrating(), st.floats(0.1, 20.0))
def test_more_mass_never_raises_a_frequency(mechanism: Mechanism, mass: float) -> None:
    before = frequencies(mechanism)
    tool = replace(mechanism.robot.tool, mass=mass)
    after = frequencies(replace(mechanism, robot=replace(mechanism.robot, tool=tool)))
    assert after.size >= before.size
    assert (after[: before.size] <= before * (1 + 1e-7)).all()


@few
@given(vibrating(), st.floats(1.0, 100.0), seeds)
def test_more_stiffness_never_lowers_a_frequency(
    mechanism: Mechanism, factor: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    links = dict(mechanism.robot.links)
    for name, link in links.items():
        if link.compliance is not None and rng.random() < 0.5:
            links[name] = replace(link, compliance=link.compliance / factor)
    joints = {
        name: replace(joint, stiffness=joint.stiffness * (factor if rng.random() < 0.5 else 1.0))
        for name, joint in mechanism.robot.joints.items()
    }
    before, after = frequencies(mechanism), frequencies(mechanism.with_parts(links, joints))
    common = min(before.size, after.size)
    assert common > 0
    assert (after[:common] >= before[:common] * (1 - 1e-7)).all()


@few
@given(vibrating())
def test_frequencies_ascend_and_energies_are_shares(mechanism: Mechanism) -> None:
    modes = modes_of(mechanism)
    assert (np.diff(modes.frequencies_hz) >= 0.0).all()
    assert modes.frequencies_hz[0] > 0.0
    for shares in modes.energy_shares:
        assert all(share >= 0.0 for share in shares.values())
        assert abs(sum(shares.values()) - 1.0) < 1e-9
