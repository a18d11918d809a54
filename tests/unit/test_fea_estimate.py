"""Estimates of the error that is left."""

from __future__ import annotations

import numpy as np
import pytest

from stiffkit.fea.estimate import (
    convergence,
    geometry_error,
    relative_difference,
    whitening,
)

K = np.diag([5e-8, 2e-3, 2e-3, 9e-3, 6e-3, 6e-3])
K[1, 5] = K[5, 1] = 3e-3


def test_the_difference_does_not_depend_on_axes_or_units() -> None:
    rng = np.random.default_rng(0)
    D = 1e-3 * K * (1.0 + 0.5 * rng.random((6, 6)))
    D = D + D.T
    change = rng.standard_normal((6, 6))
    moved = relative_difference(change @ D @ change.T, change @ K @ change.T)
    assert moved == pytest.approx(relative_difference(D, K), rel=1e-6)
    assert relative_difference(0.01 * K, K) == pytest.approx(0.01)


def test_the_difference_bounds_each_element() -> None:
    rng = np.random.default_rng(1)
    D = rng.standard_normal((6, 6)) * np.sqrt(np.outer(np.diag(K), np.diag(K)))
    D = D + D.T
    elements = np.abs(D) / np.sqrt(np.outer(np.diag(K), np.diag(K)))
    assert relative_difference(D, K) >= elements.max()


def test_whitening_makes_the_compliance_the_identity() -> None:
    W = whitening(K)
    np.testing.assert_allclose(W.T @ K @ W, np.eye(6), atol=1e-12)


@pytest.mark.parametrize("ratio", [0.4, 0.6, 0.8])
def test_geometric_convergence_is_found(ratio: float) -> None:
    found = convergence([(1.0 - 0.1 * ratio**n) * K for n in range(5)])
    left = 0.1 * ratio**4
    assert found.ratio == pytest.approx(ratio, rel=0.02)
    assert left < found.error < 1.5 * left
    assert found.change == pytest.approx(left / ratio - left, rel=0.1)


def test_the_first_solution_tells_no_ratio() -> None:
    """It is as bad as it likes, and makes the second look good."""
    good = [(1.0 - 0.1 * 0.6**n) * K for n in range(3)]
    assert convergence([0.01 * K, *good]).error == pytest.approx(convergence(good).error, rel=0.1)


def test_nothing_is_known_from_one_solution() -> None:
    assert convergence([K]).error == np.inf


def test_a_small_change_by_chance_is_not_believed() -> None:
    solutions = [0.8 * K, 0.9 * K, 0.99 * K, 0.9999 * K]
    assert convergence(solutions).error > 5e-3 * 0.01


def test_geometry_errors_of_either_sign_count() -> None:
    assert geometry_error(-0.01, 0.0) == geometry_error(0.01, 0.0) == pytest.approx(0.03)
    assert geometry_error(0.0, 0.0) == 0.0
