import numpy as np
import pytest
from tests.unit.identified_beam import TIP, cube, face

from stiffkit.identify import CaseStructure, Estimator, Field, fit, residual_structure
from stiffkit.identify.estimators import rotation_minus_identity
from stiffkit.spatial.rotation import Array

NOISE = 5e-8


def shape(
    points: Array, moved: Array, sigma: float = NOISE, estimator: Estimator = "LIN", seed: int = 3
) -> CaseStructure:
    u = moved + sigma * np.random.default_rng(seed).normal(size=points.shape)
    field = Field(points, u[None], case_names=["Fx"])
    return residual_structure(field, fit(field, TIP, estimator))[0]


def test_noise_has_no_shape() -> None:
    for points in (face(), cube()):
        found = shape(points, np.zeros_like(points))
        assert not found.structured
        assert "independent noise" in found.words
        assert found.linear_share + found.quadratic_share < 0.2


def test_false_alarms_are_as_rare_as_promised() -> None:
    points = face(7)
    u = np.random.default_rng(4).normal(size=(4000, *points.shape))
    field = Field(points, u)
    cases = residual_structure(field, fit(field, TIP))
    p_values = np.array([case.p_value for case in cases])
    # Uniform on (0, 1): 400 of 4000 below 0.1, with a standard deviation of 19.
    assert abs((p_values < 0.1).sum() - 400) < 80
    correlated = np.array([case.neighbour_p_value for case in cases])
    # The polynomials leave neighbours slightly too unlike: the test is on the safe side.
    assert (correlated < 0.1).sum() < 480
    assert sum(case.structured for case in cases) < 24


def test_poisson_contraction_of_a_face() -> None:
    strain = -0.266 * 1000 / (1e-4 * 2e11)
    points = face()
    found = shape(points, strain * (points - TIP) * [0, 1, 1], sigma=1e-9)
    assert found.structured
    assert found.linear_share > 0.98
    np.testing.assert_allclose(found.strains, strain, rtol=0.02)
    assert "face that shrinks evenly in its plane, by a strain of -1.3" in found.words
    assert "Poisson" in found.words


def test_tension_of_a_volume_with_its_poisson_ratio() -> None:
    points = cube()
    found = shape(points, 1e-4 * (points - TIP) * [1, -0.27, -0.27], sigma=1e-9)
    np.testing.assert_allclose(found.strains, [1e-4, -2.7e-5, -2.7e-5], rtol=1e-3)
    np.testing.assert_allclose(np.abs(found.directions[:, 0]), [1, 0, 0], atol=1e-3)
    assert "strain of 0.0001 along x, with the 0.27-fold of the other sign across" in found.words


def test_a_shear_is_named_with_its_directions() -> None:
    points = face()
    shear = np.array([[0.0, 0, 0], [0, 0, 1], [0, 1, 0]])
    found = shape(points, 1e-5 * (points - TIP) @ shear, sigma=1e-10)
    assert "uniform strain of" in found.words
    assert "along (0, 0.707, 0.707)" in found.words
    assert "along (0, 0.707, -0.707)" in found.words


def test_a_saddle_is_warping_and_a_bent_face_is_not() -> None:
    points = face()
    y, z = points[:, 1], points[:, 2]
    zero = np.zeros_like(y)
    saddle = shape(points, np.column_stack([0.3 * y * z, zero, zero]))
    assert saddle.quadratic_share > 0.9
    assert saddle.normal_share > 0.99
    assert "warping" in saddle.words
    anticlastic = shape(points, 0.3 * np.column_stack([zero, y * z, (z**2 - y**2) / 2]))
    assert anticlastic.normal_share < 0.1
    assert "anticlastic" in anticlastic.words


def test_warping_of_a_square_section_is_seen_though_no_quadratic_is() -> None:
    points = face()
    y, z = (points - TIP)[:, 1:].T / 0.005
    warped = 1e-6 * np.column_stack([y**3 * z - y * z**3, 0 * y, 0 * y])
    found = shape(points, warped)
    assert found.linear_share + found.quadratic_share < 0.05
    assert found.neighbour_correlation > 0.3
    assert found.structured
    assert "alike in neighbouring nodes" in found.words


@pytest.mark.parametrize(("estimator", "other"), [("LIN", "exact"), ("exact", "LIN")])
def test_a_rotation_too_large_for_the_estimator_is_recognised(
    estimator: Estimator, other: str
) -> None:
    points, phi = cube(5), np.array([0.0, 0.0, 0.05])
    E = rotation_minus_identity(phi)
    moved = (points - TIP) @ E.T if estimator == "LIN" else np.cross(phi, points - TIP)
    found = shape(points, moved, sigma=1e-9, estimator=estimator)
    assert (
        f"rotation of 2.86 deg leaves when the estimator does not suit the field: try {other}"
        in (found.words)
    )


def test_rounding_is_no_shape() -> None:
    points = cube(5)
    found = shape(points, 1e-3 + np.cross([1e-3, 2e-3, -1e-3], points - TIP), sigma=0.0)
    assert not found.structured
    assert found.words == "nothing but rounding is left"


def test_too_few_nodes_cannot_tell() -> None:
    found = shape(face(2), np.zeros((4, 3)))
    assert np.isnan(found.neighbour_correlation)
    assert not found.structured


def test_many_nodes_are_sampled_for_neighbours() -> None:
    points = face(80)
    y, z = (points - TIP)[:, 1:].T / 0.005
    found = shape(points, 1e-6 * np.column_stack([y**3 * z - y * z**3, 0 * y, 0 * y]))
    assert found.neighbour_correlation > 0.5
