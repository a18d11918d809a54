"""Links that follow their length, against beams of every length and bodies of points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from stiffkit.link import (
    MATERIALS,
    beam_compliance,
    beam_inertia,
    check_compliance,
    check_inertia,
    tube,
)
from stiffkit.link.sections import Section
from stiffkit.link.stretch import Rule, Stretch
from stiffkit.spatial import axis_rotation, exp_rotation

Array = NDArray[np.float64]

STEEL = MATERIALS["steel"]
SLENDER = Section(area=4e-4, Iy=3e-8, Iz=5e-8, torsion=6e-8)
"""Without shear coefficients: the beam of Euler and Bernoulli."""
RULES: tuple[Rule, ...] = ("equivalent-beam", "constant-section")


def along(direction: Array, length: float, reference: float, rule: Rule) -> Stretch:
    return Stretch(length * direction, reference, rule)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("length", [0.15, 0.3, 0.9])
def test_a_slender_beam_drawn_out_is_the_beam_of_that_length(rule: Rule, length: float) -> None:
    by = along(np.array([1.0, 0.0, 0.0]), length, 0.3, rule)
    found = by.compliance(beam_compliance(0.3, SLENDER, STEEL))
    expected = beam_compliance(length, SLENDER, STEEL)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((found - expected) / scale).max() < 1e-12


@pytest.mark.parametrize("rule", RULES)
def test_the_line_may_point_anywhere(rule: Rule) -> None:
    R = np.kron(np.eye(2), axis_rotation("z", 0.7) @ axis_rotation("y", 0.4))
    direction = np.asarray(R[:3, 0], dtype=np.float64)
    k = R @ beam_compliance(0.3, SLENDER, STEEL) @ R.T
    # About the line the equivalent beam has its own axes, so a beam alike both ways is taken.
    if rule == "equivalent-beam":
        even = tube(0.04, 0.004)
        even = Section(area=even.area, Iy=even.Iy, Iz=even.Iz, torsion=even.torsion)
        k = R @ beam_compliance(0.3, even, STEEL) @ R.T
        expected = R @ beam_compliance(0.5, even, STEEL) @ R.T
    else:
        expected = R @ beam_compliance(0.5, SLENDER, STEEL) @ R.T
    found = along(direction, 0.5, 0.3, rule).compliance(k)
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


def test_mass_center_and_inertia_of_a_slender_beam_follow_its_length() -> None:
    by = along(np.array([1.0, 0.0, 0.0]), 0.8, 0.3, "constant-section")
    short, long = (beam_inertia(length, SLENDER, STEEL) for length in (0.3, 0.8))
    assert by.mass(short[0]) == pytest.approx(long[0])
    np.testing.assert_allclose(by.point(short[1]), long[1])
    np.testing.assert_allclose(by.inertia(short[2]), long[2], rtol=1e-12)


def test_inertia_is_that_of_the_points_of_the_body_moved() -> None:
    random = np.random.default_rng(5)
    points, masses = random.standard_normal((40, 3)), random.uniform(0.1, 1.0, 40)
    direction = np.array([2.0, -1.0, 2.0]) / 3.0
    by = along(direction, 0.5, 0.2, "constant-section")
    center = masses @ points / masses.sum()
    moved = np.array([by.point(point) for point in points])
    np.testing.assert_allclose(by.point(center), masses @ moved / masses.sum())
    expected = inertia_of(by.ratio * masses, moved)
    np.testing.assert_allclose(by.inertia(inertia_of(masses, points)), expected, rtol=1e-12)


def inertia_of(masses: Array, points: Array) -> Array:
    around = points - masses @ points / masses.sum()
    squares = np.einsum("n,ni,nj->ij", masses, around, around)
    return np.asarray(np.trace(squares) * np.eye(3) - squares)


def test_at_the_reference_length_a_constant_section_changes_nothing() -> None:
    by = along(np.array([0.0, 0.6, 0.8]), 0.3, 0.3, "constant-section")
    assert by.is_none
    k = beam_compliance(0.3, SLENDER, STEEL)
    np.testing.assert_allclose(by.compliance(k), k, rtol=1e-14)
    assert not along(np.array([1.0, 0.0, 0.0]), 0.3, 0.3, "equivalent-beam").is_none


def test_the_equivalent_beam_keeps_the_first_four_of_the_diagonal() -> None:
    k = some_compliance(3)
    found = along(np.array([1.0, 0.0, 0.0]), 0.4, 0.4, "equivalent-beam").compliance(k)
    np.testing.assert_allclose(np.diag(found)[:4], np.diag(k)[:4], rtol=1e-12)
    # And is a beam: k22 = L^3 / 3EI, k66 = L / EI, k26 = L^2 / 2EI.
    assert found[5, 5] == pytest.approx(3.0 * k[1, 1] / 0.4**2)
    assert found[1, 5] == pytest.approx(1.5 * k[1, 1] / 0.4)
    assert found[2, 4] == pytest.approx(-1.5 * k[2, 2] / 0.4)
    assert found[0, 1] == 0.0


def some_compliance(seed: int) -> Array:
    A = np.random.default_rng(seed).standard_normal((6, 6))
    size = np.array([1e-4, 3e-4, 3e-4, 1e-3, 1e-3, 1e-3])
    return np.asarray(np.outer(size, size) * (A @ A.T + np.eye(6)))


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    length=st.floats(0.05, 5.0),
    reference=st.floats(0.05, 5.0),
    turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    rule=st.sampled_from(RULES),
)
def test_what_a_body_can_have_it_can_have_at_every_length(
    seed: int, length: float, reference: float, turn: tuple[float, float, float], rule: Rule
) -> None:
    direction = exp_rotation(np.array(turn))[:, 0]
    by = along(direction, length, reference, rule)
    assert check_compliance(by.compliance(some_compliance(seed))) == []
    random = np.random.default_rng(seed)
    inertia = inertia_of(random.uniform(0.1, 1.0, 9), random.standard_normal((9, 3)))
    assert check_inertia(1.0, by.inertia(inertia)) == []


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), lengths=st.tuples(*[st.floats(0.1, 3.0)] * 3))
def test_two_steps_are_one(seed: int, lengths: tuple[float, float, float]) -> None:
    first, second, third = lengths
    x = np.array([1.0, 0.0, 0.0])
    k = some_compliance(seed)
    one = along(x, third, first, "constant-section").compliance(k)
    two = along(x, second, first, "constant-section").compliance(k)
    two = along(x, third, second, "constant-section").compliance(two)
    np.testing.assert_allclose(two, one, rtol=1e-11)
