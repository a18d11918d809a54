import numpy as np
import pytest
from tests.unit.identified_beam import CASES, LOADS, TIP, beam_compliance, cube, displaced, face

from stiffkit.errors import FieldError
from stiffkit.identify import Field, Options, fit, identify, robust_fit
from stiffkit.identify.outliers import kept_nodes, rim_share, trimmed_sigma_ratio

RANDOM = np.random.default_rng(10)


def test_a_node_goes_if_any_of_its_residuals_is_among_the_largest() -> None:
    u = 1e-9 * RANDOM.normal(size=(2, 121, 3))
    u[0, 17, 2] = u[0, 90, 0] = 1e-7
    u[1, 5, 1] = -1e-7
    field = Field(face(), u)
    kept = kept_nodes(field, fit(field, TIP), 100 * 2.5 / 121)
    assert np.flatnonzero(~kept[0]).tolist() == [17, 90]
    assert 5 in np.flatnonzero(~kept[1])
    assert (~kept[1]).sum() == 2


def test_the_percentage_is_never_exceeded_and_ties_stay() -> None:
    field = Field(cube(), RANDOM.normal(size=(1, 1331, 3)))
    found = fit(field, TIP)
    assert (~kept_nodes(field, found, 10.0)).sum() == 133
    assert kept_nodes(field, found, 0.0).all()
    square = face(3)
    shrunk = Field(square, -1e-6 * (square - TIP)[None])
    # The residuals of the four corners and of four mid-sides have the same largest component.
    assert kept_nodes(shrunk, fit(shrunk, TIP), 30.0).all()
    with pytest.raises(FieldError, match="50 % of the nodes cannot be dropped"):
        kept_nodes(field, found, 50.0)


def test_trimming_good_noise_makes_sigma_too_small_by_the_ratio_told() -> None:
    field = Field(cube(), RANDOM.normal(size=(20, 1331, 3)))
    kept = kept_nodes(field, fit(field, TIP), 10.0)
    left = np.std(field.displacements[kept])
    assert left == pytest.approx(trimmed_sigma_ratio(10.0), abs=0.01)
    assert trimmed_sigma_ratio(0.0) == 1.0


def test_share_on_the_rim() -> None:
    field = Field(cube(), np.zeros((1, 1331, 3)))
    distance = np.linalg.norm(field.points - TIP, axis=1)
    outer = distance >= np.sort(distance)[-100]
    assert rim_share(field, outer) == 1.0
    assert rim_share(field, distance < 0.003) == 0.0
    assert rim_share(field, np.zeros(1331, dtype=bool)) == 0.0


def test_robust_fit_of_clean_noise_is_nearly_as_good_as_least_squares() -> None:
    field = Field(cube(7), 5e-8 * RANDOM.normal(size=(40, 343, 3)))
    found = robust_fit(field, TIP)
    assert found.sigma.mean() == pytest.approx(5e-8 / np.sqrt(0.95), rel=0.03)
    errors = found.fitted.translation.std()
    assert errors == pytest.approx(found.sigma.mean() / np.sqrt(343), rel=0.2)
    # Four standard deviations: 6.3e-5 of the residuals, three of a node.
    assert found.outliers.mean() < 1e-3


def test_robust_fit_of_an_exact_field_is_exact() -> None:
    u = displaced(face(), beam_compliance(), LOADS)
    found = robust_fit(Field(face(), u), TIP)
    np.testing.assert_allclose(found.fitted.deflections, LOADS @ beam_compliance().T, atol=1e-16)
    assert not found.outliers.any()


@pytest.mark.parametrize("treatment", ["drop", "robust"])
def test_before_and_after_are_side_by_side(treatment: str) -> None:
    k, points = beam_compliance(), face()
    u = displaced(points, k, LOADS, sigma=5e-8, seed=1)
    bad = np.arange(0, 10)
    u[1, bad, 0] += 5e-6
    field = Field(points, u, case_names=CASES, nodes=np.arange(121) + 1000)
    found = identify(field, LOADS, TIP, Options(outliers=treatment))  # type: ignore[arg-type]
    report = found.outliers
    assert report is not None
    assert set(bad + 1000) <= set(report.nodes[1].tolist())
    assert report.sigma_before[1] > 10 * report.sigma_after[1]
    truth = LOADS @ k.T
    error = np.sqrt(np.diag(found.deflection_covariances[1]))
    assert (np.abs(report.after - truth)[1] < 4 * error).all()
    assert (np.abs(report.before - truth)[1] > 10 * error).any()
    np.testing.assert_array_equal(report.after, found.estimate.deflections)
    assert any(note.startswith("outliers (") for note in found.notes)


def test_robust_suits_lin_only_and_other_words_are_refused() -> None:
    field = Field(face(), displaced(face(), beam_compliance(), LOADS))
    with pytest.raises(FieldError, match="a robust fit is linear, and the estimator is exact"):
        identify(field, LOADS, TIP, Options(estimator="exact", outliers="robust"))
    with pytest.raises(FieldError, match="no treatment of outliers 'ignore'"):
        identify(field, LOADS, TIP, Options(outliers="ignore"))  # type: ignore[arg-type]
