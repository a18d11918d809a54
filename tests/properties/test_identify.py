"""What must not change when a field is only written down in another way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiffkit.identify import Estimator, Field, fit, identify, precision
from stiffkit.spatial import exp_rotation
from stiffkit.spatial.rotation import Array

SEEDS = st.integers(0, 2**32 - 1)
ESTIMATORS = st.sampled_from(["LIN", "SVD+-", "exact"])
FEW = settings(max_examples=40, deadline=None)


def arrays(seed: int, cases: int = 2) -> tuple[Array, Array, Array, Array]:
    """Points, displacements of up to a tenth of them, weights and a reference point."""
    random = np.random.default_rng(seed)
    count = int(random.integers(4, 30))
    size = 10.0 ** random.uniform(-3, 1)
    points = size * random.normal(size=(count, 3)) + random.normal(size=3)
    moved = size * 10.0 ** random.uniform(-8, -1) * random.normal(size=(cases, count, 3))
    return points, moved, random.uniform(0.1, 3.0, size=count), random.normal(size=3)


def deflections(
    points: Array, moved: Array, weights: Array, reference: Array, estimator: Estimator
) -> Array:
    return fit(Field(points, moved, weights), reference, estimator).deflections


def close(found: Array, expected: Array, moved: Array, points: Array, reference: Array) -> None:
    """Agree to the rounding of the displacements at the reference point, which may be far off."""
    size = np.ptp(points, axis=0).max()
    scale = np.abs(moved).max() / size * max(1.0, size, np.linalg.norm(reference - points[0]))
    # The paper's SVD knows rotations to the rounding of 1.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * scale + 1e-13)


@FEW
@given(SEEDS, ESTIMATORS)
def test_order_of_nodes(seed: int, estimator: Estimator) -> None:
    p, u, w, reference = arrays(seed)
    order = np.random.default_rng(seed).permutation(len(p))
    close(
        deflections(p[order], u[:, order], w[order], reference, estimator),
        deflections(p, u, w, reference, estimator),
        u,
        p,
        reference,
    )


@FEW
@given(SEEDS, ESTIMATORS)
def test_a_node_split_in_two_with_its_weight(seed: int, estimator: Estimator) -> None:
    p, u, w, reference = arrays(seed)
    share = np.random.default_rng(seed).uniform(0.1, 0.9, size=len(w))
    close(
        deflections(
            np.vstack([p, p]),
            np.concatenate([u, u], axis=1),
            np.concatenate([share * w, (1 - share) * w]),
            reference,
            estimator,
        ),
        deflections(p, u, w, reference, estimator),
        u,
        p,
        reference,
    )


@FEW
@given(SEEDS, ESTIMATORS, st.floats(1e-12, 1e12))
def test_only_ratios_of_weights_count(seed: int, estimator: Estimator, factor: float) -> None:
    p, u, w, reference = arrays(seed)
    close(
        deflections(p, u, factor * w, reference, estimator),
        deflections(p, u, w, reference, estimator),
        u,
        p,
        reference,
    )
    first, second = (precision(Field(p, u, f * w), reference) for f in (1.0, factor))
    np.testing.assert_allclose(first.unit_covariance, second.unit_covariance, rtol=1e-6, atol=1e-6)


@FEW
@given(SEEDS, ESTIMATORS)
def test_weight_zero_drops_a_node_exactly(seed: int, estimator: Estimator) -> None:
    p, u, w, reference = arrays(seed)
    random = np.random.default_rng(seed)
    gone = np.sort(random.integers(0, len(p) + 1, size=5))
    with_gone = (
        np.insert(p, gone, 1e3 * random.normal(size=(5, 3)), axis=0),
        np.insert(u, gone, np.nan, axis=1),
        np.insert(w, gone, 0.0),
    )
    np.testing.assert_array_equal(
        deflections(*with_gone, reference, estimator), deflections(p, u, w, reference, estimator)
    )


@FEW
@given(SEEDS, st.sampled_from(["LIN", "exact"]))
def test_turning_and_moving_everything_turns_the_answer(seed: int, estimator: Estimator) -> None:
    p, u, w, reference = arrays(seed)
    random = np.random.default_rng(seed)
    R, shift = exp_rotation(random.normal(size=3)), random.normal(size=3)
    there = deflections(p @ R.T + shift, u @ R.T, w, R @ reference + shift, estimator)
    here = deflections(p, u, w, reference, estimator)
    close(there, here @ np.kron(np.eye(2), R).T, u, p, reference)


@FEW
@given(SEEDS, st.floats(1e-9, 1e-2))
def test_a_rigid_motion_on_top_adds_up(seed: int, amplitude: float) -> None:
    p, u, w, reference = arrays(seed)
    t, phi = amplitude * np.random.default_rng(seed).normal(size=(2, 3))
    added = u + t + np.cross(phi, p - reference)
    here = deflections(p, u, w, reference, "LIN")
    close(
        deflections(p, added, w, reference, "LIN"), here + np.hstack([t, phi]), added, p, reference
    )


@FEW
@given(SEEDS, st.sampled_from([6, 8]))
def test_the_compliance_does_not_depend_on_order_or_units_of_loads(seed: int, cases: int) -> None:
    p, u, w, reference = arrays(seed, cases)
    random = np.random.default_rng(seed)
    wrenches = random.normal(size=(cases, 6))
    first = identify(Field(p, u, w), wrenches, reference)
    order = random.permutation(cases)
    again = identify(Field(p, u[order], w), wrenches[order], reference)
    np.testing.assert_allclose(
        again.compliance, first.compliance, rtol=0, atol=1e-9 * np.abs(first.compliance).max()
    )
    larger = identify(Field(p, 1e-3 * u, w), 1e-3 * wrenches, reference)
    np.testing.assert_allclose(larger.compliance, first.compliance, rtol=1e-6)
    np.testing.assert_allclose(larger.standard_error, first.standard_error, rtol=1e-6)
    assert larger.sigma == pytest.approx(1e-3 * first.sigma, rel=1e-6)
