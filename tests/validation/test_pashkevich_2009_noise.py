"""Pashkevich 2009, sections 3.4, 3.5 and 4.5: noise, confidence intervals and outliers.

A. Pashkevich, A. Klimchik, D. Chablat, P. Wenger, "Accuracy improvement for stiffness modeling of
parallel manipulators", 2009.

10 000 fields of a cube of 10 x 10 x 10 mm (1331 points), moved by 1 mm and 0.1 deg and contaminated
with noise of 5e-5 mm. Lengths are in mm here, as in the paper.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.identify import Field, fit, multiplier, precision, residual_sums, robust_fit
from stiffkit.identify.outliers import kept_nodes
from stiffkit.identify.statistics import noise
from stiffkit.spatial import axis_rotation, log_rotation
from stiffkit.spatial.rotation import Array

STEP = np.linspace(-5.0, 5.0, 11)
CUBE = np.stack(np.meshgrid(STEP, STEP, STEP, indexing="ij"), axis=-1).reshape(-1, 3)
CENTRE = np.zeros(3)
SIGMA = 5e-5
SHIFT = 1.0
ANGLE = np.radians(0.1)
R = np.linalg.multi_dot([axis_rotation(axis, ANGLE) for axis in "xyz"])
CLEAN = CUBE @ (R - np.eye(3)).T + SHIFT
TRUTH = np.hstack([np.full(3, SHIFT), log_rotation(R)])
FIELDS, BATCH = 10_000, 500


@cache
def simulated() -> tuple[Array, Array, Array]:
    """Deflections (10 000, 6) by `exact` and by LIN, and sigma (10 000,) from the residuals."""
    random = np.random.default_rng(2009)
    exact, linear, sigma = [], [], []
    known = precision(Field(CUBE, CLEAN[None]), CENTRE)
    for _ in range(FIELDS // BATCH):
        field = Field(CUBE, CLEAN + SIGMA * random.normal(size=(BATCH, *CUBE.shape)))
        found = fit(field, CENTRE, "exact")
        exact.append(found.deflections)
        linear.append(fit(field, CENTRE).deflections)
        sigma.append(noise(residual_sums(field, found).squares, known))
    return np.concatenate(exact), np.concatenate(linear), np.concatenate(sigma)


def equation_20() -> Array:
    """Standard deviations (6,) of the deflection."""
    known = precision(Field(CUBE, CLEAN[None]), CENTRE)
    return np.asarray(SIGMA * np.sqrt(np.diag(known.unit_covariance)))


def test_equation_20_gives_the_printed_standard_deviations() -> None:
    translation, rotation = equation_20()[0], np.degrees(equation_20()[3])
    assert f"{translation:.2e}" == "1.37e-06"  # mm, sigma / sqrt(n)
    assert f"{rotation:.1e}" == "1.8e-05"  # deg
    # The paper's approximation of the latter is good to a tenth only.
    assert np.degrees(SIGMA / (10.0 * np.sqrt(1331 / 6))) == pytest.approx(rotation, rel=0.1)


@pytest.mark.parametrize("estimator", ["exact", "LIN"])
def test_standard_deviations_of_all_six_estimates(estimator: str) -> None:
    exact, linear, _ = simulated()
    found = (exact if estimator == "exact" else linear).std(axis=0, ddof=1)
    # 10 000 samples know a standard deviation to 0.7 %; four times that.
    np.testing.assert_allclose(found, equation_20(), rtol=4.0 / np.sqrt(2 * FIELDS))
    if estimator == "exact":
        # "the s.t.d. of the translational error is about 1.36e-6 mm"
        assert found[:3] == pytest.approx(1.36e-6, rel=0.03)


def test_spread_of_the_rotation_by_lin_at_a_tenth_of_a_degree() -> None:
    error = np.degrees(simulated()[1][:, 3:] - ANGLE)
    # "about 8.4e-5 deg": over the three angles together, whose biases have unlike signs.
    assert f"{error.std():.1e}" == "8.4e-05"
    # "the linearization component is about 8.8e-5 deg"; it is b^2/2 = 8.73e-5 deg.
    np.testing.assert_allclose(np.abs(error.mean(axis=0)), np.degrees(ANGLE**2 / 2), rtol=0.01)


def test_sigma_from_residuals() -> None:
    sigma = simulated()[2]
    # Each has 3987 degrees of freedom, and is good to 1.1 %.
    assert sigma.mean() == pytest.approx(SIGMA, rel=5e-4)
    assert sigma.std() / SIGMA == pytest.approx(1.0 / np.sqrt(2 * 3987), rel=0.05)


@pytest.mark.parametrize("level", [0.6827, 0.95, 0.9973])
def test_coverage_of_the_intervals(level: float) -> None:
    exact, _, sigma = simulated()
    reach = multiplier(level, 3 * 1331 - 6).value
    error = np.outer(sigma / SIGMA, equation_20())
    held = (np.abs(exact - TRUTH) <= reach * error).sum(axis=0)
    # Binomial: four standard deviations of the number of intervals that hold the truth.
    slack = 4.0 * np.sqrt(FIELDS * level * (1.0 - level))
    assert np.abs(held - FIELDS * level).max() < slack


def planted(percent: float, place: str, axes: list[int]) -> tuple[Field, NDArray[np.bool_]]:
    """A field with outliers of 20 sigma to one side, and which nodes (1331,) they are."""
    random = np.random.default_rng(int(percent) + len(axes))
    count = int(percent / 100.0 * len(CUBE))
    if place == "edges":
        chosen = np.argsort(-np.linalg.norm(CUBE, axis=1), kind="stable")[:count]
    else:
        chosen = random.choice(len(CUBE), count, replace=False)
    u = CLEAN + SIGMA * random.normal(size=CUBE.shape)
    u[chosen[:, None], np.array(axes)] += 20.0 * SIGMA
    bad = np.zeros(len(CUBE), dtype=bool)
    bad[chosen] = True
    return Field(CUBE, u[None]), bad


@pytest.mark.parametrize("axes", [[0], [0, 1, 2]], ids=["one axis", "all axes"])
@pytest.mark.parametrize("place", ["edges", "anywhere"])
@pytest.mark.parametrize("percent", [1.0, 5.0, 10.0])
def test_planted_outliers_are_found_and_the_estimate_recovered(
    percent: float, place: str, axes: list[int]
) -> None:
    field, bad = planted(percent, place, axes)
    error = equation_20()
    before = fit(field, CENTRE, "exact")
    assert (np.abs(before.deflections[0] - TRUTH) > 5.0 * error).any()

    kept = kept_nodes(field, before, percent)[0]
    np.testing.assert_array_equal(kept, ~bad)
    after = fit(field.case(0, kept), CENTRE, "exact").deflections[0]
    assert (np.abs(after - TRUTH) < 4.0 * error).all()


@pytest.mark.parametrize("axes", [[0], [0, 1, 2]], ids=["one axis", "all axes"])
@pytest.mark.parametrize("percent", [1.0, 5.0, 10.0])
def test_the_robust_fit_needs_no_percentage(percent: float, axes: list[int]) -> None:
    field, bad = planted(percent, "edges", axes)
    found = robust_fit(field, CENTRE)
    assert found.outliers[0][bad].all()
    # Normal noise has four good nodes of 20 000 beyond four sigma; chance may add a few.
    assert found.outliers[0][~bad].sum() <= 4
    assert found.sigma[0] == pytest.approx(SIGMA, rel=0.15)
    # The robust fit is linear: compare with LIN on the good nodes alone.
    good = fit(field.case(0, ~bad), CENTRE).deflections[0]
    assert (np.abs(found.fitted.deflections[0] - good) < 2.0 * equation_20()).all()
