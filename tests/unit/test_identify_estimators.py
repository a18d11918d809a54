import numpy as np
import pytest

from stiffkit.errors import FieldError
from stiffkit.identify import Estimator, Field, fit, residual_sums, residuals
from stiffkit.identify.closed_forms import cubic_normal, square_normal, symmetric_normal
from stiffkit.identify.estimators import rotation_minus_identity
from stiffkit.identify.moments import CHUNK, gyration, moments
from stiffkit.spatial import exp_rotation, skew
from stiffkit.spatial.rotation import Array

RANDOM = np.random.default_rng(2009)
ESTIMATORS: list[Estimator] = ["LIN", "SVD+", "SVD-", "SVD+-", "exact"]
AXIS = np.array([1.0, 2.0, -2.0]) / 3.0


def cloud(count: int = 40, size: float = 1.0) -> Array:
    return size * RANDOM.normal(size=(count, 3)) * [1.0, 0.6, 0.3] + [0.4, -1.0, 2.0]


def turned(points: Array, translation: Array, rotation: Array, reference: Array) -> Array:
    """Displacements (1, n, 3) of an exact rotation about the reference point, to rounding."""
    E = rotation_minus_identity(rotation)
    return np.asarray(translation + (points - reference) @ E.T)[None]


@pytest.mark.parametrize("angle", [1e-12, 1e-9, 1e-4, 0.3, 1.5, 3.0, 3.141])
@pytest.mark.parametrize("flat", [False, True])
def test_exact_reads_any_rotation_to_rounding(angle: float, flat: bool) -> None:
    p = cloud()
    if flat:
        p[:, 2] = 1.5
    reference, t, phi = np.array([3.0, 1.0, -2.0]), angle * np.array([1.0, -2, 3]), angle * AXIS
    found = fit(Field(p, turned(p, t, phi, reference)), reference, "exact")
    np.testing.assert_allclose(found.rotation[0], phi, rtol=0, atol=2e-14 * angle)
    np.testing.assert_allclose(found.translation[0], t, rtol=0, atol=2e-13 * angle)


@pytest.mark.parametrize("amplitude", [1e-12, 1e-9, 1.0])
def test_lin_reads_a_linear_field_at_any_amplitude(amplitude: float) -> None:
    p, reference = cloud(), np.array([3.0, 1.0, -2.0])
    t, phi = amplitude * RANDOM.normal(size=(2, 4, 3))
    u = t[:, None] + np.cross(phi[:, None], (p - reference)[None])
    found = fit(Field(p, u), reference)
    np.testing.assert_allclose(
        found.deflections, np.hstack([t, phi]), rtol=0, atol=2e-14 * amplitude
    )


def test_a_large_common_translation_costs_no_digits_of_the_rotation() -> None:
    p = cloud()
    # Displacements near 1 resolve 1e-16: the rotation can be known to that, and no better.
    u = turned(p, np.array([1.0, 1.0, 1.0]), 1e-9 * AXIS, np.zeros(3))
    chosen: list[Estimator] = ["LIN", "exact"]
    for estimator in chosen:
        found = fit(Field(p, u), np.zeros(3), estimator)
        np.testing.assert_allclose(found.rotation[0], 1e-9 * AXIS, rtol=0, atol=2e-16)


def test_the_angle_rules_of_table_1() -> None:
    p, phi = cloud(), 0.2 * AXIS
    field = Field(p, turned(p, np.zeros(3), phi, np.zeros(3)))
    R = exp_rotation(phi)
    plus, minus = [R[2, 1], R[0, 2], R[1, 0]], [-R[1, 2], -R[2, 0], -R[0, 1]]
    for estimator, angles in (("SVD+", plus), ("SVD-", minus), ("SVD+-", np.add(plus, minus) / 2)):
        found = fit(field, np.zeros(3), estimator)  # type: ignore[arg-type]
        np.testing.assert_allclose(found.rotation[0], angles, atol=1e-14)
        np.testing.assert_allclose(found.gradient[0], R - np.eye(3), atol=1e-14)


def test_a_reflection_is_never_taken_for_a_rotation() -> None:
    square = np.array([[1.0, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
    mirrored = square * [1.0, -1.0, 1.0]
    chosen: list[Estimator] = ["SVD+-", "exact"]
    for estimator in chosen:
        found = fit(Field(square, (mirrored - square)[None]), np.zeros(3), estimator)
        assert np.linalg.det(found.gradient[0] + np.eye(3)) == pytest.approx(1.0)


@pytest.mark.parametrize("estimator", ["exact", "SVD+-", "LIN"])
def test_the_fit_is_the_least_of_the_weighted_squares(estimator: Estimator) -> None:
    p, w = cloud(12), RANDOM.uniform(0.1, 3.0, size=12)
    u = 0.3 * RANDOM.normal(size=(1, 12, 3))
    field = Field(p, u, weights=w)
    found = fit(field, np.zeros(3), estimator)
    least = (w @ residuals(field, found)[0] ** 2).sum()
    for step in 1e-4 * RANDOM.normal(size=(50, 6)):
        if estimator == "LIN":
            A = found.gradient[0] + skew(step[3:])
        else:
            A = exp_rotation(step[3:]) @ (np.eye(3) + found.gradient[0]) - np.eye(3)
        moved = found.mean[0] + step[:3] + (p - found.centre) @ A.T
        assert (w @ (u[0] - moved) ** 2).sum() > least


def test_lin_solves_the_6x6_system_of_equation_16_at_the_reference_point() -> None:
    p, w, reference = cloud(15), RANDOM.uniform(0.1, 3.0, size=15), np.array([0.1, -0.7, 1.9])
    u = RANDOM.normal(size=(3, 15, 3))
    # u = t + phi x (p - reference): rows [I, P] with the matrix (14) of the paper.
    rows = np.vstack([np.hstack([np.eye(3), -skew(r)]) for r in p - reference])
    root = np.repeat(np.sqrt(w), 3)
    expected = np.linalg.lstsq(rows * root[:, None], u.reshape(3, -1).T * root[:, None])[0].T
    found = fit(Field(p, u, weights=w), reference)
    np.testing.assert_allclose(found.deflections, expected, rtol=1e-12, atol=1e-12)


def test_closed_forms_are_the_normal_matrices_of_their_fields() -> None:
    step = np.linspace(-0.5, 0.5, 11)
    cube = 0.01 * np.stack(np.meshgrid(step, step, step), axis=-1).reshape(-1, 3)
    face = cube[np.abs(cube[:, 0]) < 1e-12]
    for points in (cube, face):
        found = gyration(moments(Field(points + 0.3, np.zeros((1, *points.shape)))).second)
        np.testing.assert_allclose(found, np.diag(symmetric_normal(points)), atol=1e-15)
    np.testing.assert_allclose(symmetric_normal(cube), cubic_normal(0.01, 1331))
    np.testing.assert_allclose(symmetric_normal(face), square_normal(0.01, 121))


def test_pieces_make_no_difference() -> None:
    count = 2 * CHUNK + 3
    p, u = cloud(count), RANDOM.normal(size=(2, count, 3))
    field = Field(p, u)
    found = fit(field, np.zeros(3))
    left = u - found.mean[:, None] - (p - p.mean(axis=0)) @ found.gradient.mT
    np.testing.assert_allclose(residuals(field, found), left, atol=1e-12)
    sums = residual_sums(field, found)
    np.testing.assert_allclose(sums.squares, np.square(left).sum(axis=(1, 2)))
    np.testing.assert_allclose(sums.largest, np.abs(left).max(axis=(1, 2)))
    assert sums.largest_node == tuple(np.abs(left).max(axis=2).argmax(axis=1).tolist())


def test_a_reference_or_estimator_that_is_none_is_refused() -> None:
    field = Field(cloud(), np.zeros((1, 40, 3)))
    with pytest.raises(FieldError, match="three finite numbers"):
        fit(field, [1.0, 2.0])
    with pytest.raises(FieldError, match="no estimator 'QUAD'"):
        fit(field, np.zeros(3), "QUAD")  # type: ignore[arg-type]
