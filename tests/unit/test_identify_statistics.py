import numpy as np
import pytest
from tests.unit.identified_beam import TIP, cube, face

from stiffkit.errors import FieldError
from stiffkit.identify import Field, fit, multiplier, precision, residual_sums
from stiffkit.identify.closed_forms import cubic_normal, square_normal
from stiffkit.identify.statistics import compliance_covariance, noise, symmetric_covariance
from stiffkit.spatial import skew
from stiffkit.spatial.rotation import Array

RANDOM = np.random.default_rng(20)


def design(points: Array, reference: Array) -> Array:
    """Rows (3n, 6): displacements by a translation and a rotation at the reference."""
    return np.vstack([np.hstack([np.eye(3), -skew(p)]) for p in points - reference])


def test_equal_weights_give_equation_20_and_3n_minus_6() -> None:
    points = cube()
    known = precision(Field(points, np.zeros((1, 1331, 3))), TIP)
    assert known.squares_per_variance == pytest.approx(3 * 1331 - 6)
    assert known.degrees_of_freedom == pytest.approx(3 * 1331 - 6)
    d = cubic_normal(0.01, 1331)
    np.testing.assert_allclose(
        known.unit_covariance, np.diag([1 / 1331] * 3 + [1 / d] * 3), rtol=1e-9, atol=1e-9
    )


def test_a_face_sees_the_rotation_about_its_normal_best() -> None:
    known = precision(Field(face(), np.zeros((1, 121, 3))), TIP)
    np.testing.assert_allclose(
        np.diag(known.unit_covariance)[3:], 1.0 / square_normal(0.01, 121), rtol=1e-9
    )


def test_any_weights_and_reference_against_the_matrices_of_the_linear_model() -> None:
    points, w = RANDOM.normal(size=(9, 3)) * 0.02 + 0.5, RANDOM.uniform(0.2, 4.0, size=9)
    reference = np.array([0.4, 0.55, 0.47])
    known = precision(Field(points, np.zeros((1, 9, 3)), weights=5.0 * w), reference)
    X, W = design(points, reference), np.diag(np.repeat(w / w.mean(), 3))
    estimator = np.linalg.solve(X.T @ W @ X, X.T @ W)
    np.testing.assert_allclose(known.unit_covariance, estimator @ estimator.T, rtol=1e-8)
    # The weighted sum of squares of the residuals of noise e is e^T A e.
    rest = np.eye(27) - X @ estimator
    A = rest.T @ W @ rest
    assert known.squares_per_variance == pytest.approx(np.trace(A))
    assert known.degrees_of_freedom == pytest.approx(np.trace(A) ** 2 / np.trace(A @ A))


def test_sigma_is_unbiased_for_unequal_weights() -> None:
    points, w = RANDOM.normal(size=(8, 3)), RANDOM.uniform(0.1, 5.0, size=8)
    field = Field(points, 2e-6 * RANDOM.normal(size=(20_000, 8, 3)), weights=w)
    known = precision(field, np.zeros(3))
    sigma = noise(residual_sums(field, fit(field, np.zeros(3))).squares, known)
    # The mean of 20 000 variances with some 12 degrees of freedom is good to 0.3 %.
    assert np.mean(sigma**2) == pytest.approx(4e-12, rel=0.01)
    assert 2.0 * 16e-24 / np.var(sigma**2) == pytest.approx(known.degrees_of_freedom, rel=0.06)


def test_compliance_covariance_is_that_of_the_elements() -> None:
    loads = RANDOM.normal(size=(8, 6))
    inverse = np.linalg.pinv(loads.T)
    roots = RANDOM.normal(size=(8, 6, 6))
    found = compliance_covariance(roots @ roots.mT, np.asarray(inverse))
    # k = D L^+ with D = sum of root_j e_j: one linear map for each case.
    expected = np.zeros((36, 36))
    for root, row in zip(roots, inverse, strict=True):
        to_elements = np.kron(root, row[:, None])
        expected += to_elements @ to_elements.T
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_covariance_of_the_symmetric_part() -> None:
    root = RANDOM.normal(size=(36, 36))
    swap = np.eye(36).reshape(6, 6, 36).transpose(1, 0, 2).reshape(36, 36)
    half = (np.eye(36) + swap) / 2.0
    np.testing.assert_allclose(
        symmetric_covariance(root @ root.T), half @ root @ root.T @ half.T, atol=1e-12
    )


def test_few_degrees_of_freedom_widen_the_interval() -> None:
    # Tables of Student's t and of the normal distribution.
    assert multiplier(0.95, 10).value == pytest.approx(2.228, abs=5e-4)
    assert multiplier(0.95, 10).distribution == "Student t"
    assert multiplier(0.95, 3987).value == pytest.approx(1.960, abs=5e-4)
    assert multiplier(0.95, 3987).distribution == "normal"
    assert multiplier(0.9973, 3987).value == pytest.approx(3.0, abs=1e-3)


@pytest.mark.parametrize("level", [0.0, 1.0, 95.0, float("nan")])
def test_a_level_that_is_none_is_refused(level: float) -> None:
    with pytest.raises(FieldError, match="between 0 and 1"):
        multiplier(level, 10)
