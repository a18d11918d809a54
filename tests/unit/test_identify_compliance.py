import numpy as np
import pytest
from tests.unit.identified_beam import (
    CASES,
    LOADS,
    TIP,
    beam_compliance,
    cube,
    displaced,
    face,
)

from stiffkit.errors import FieldError
from stiffkit.identify import Field, Identified, Options, check_loads, identify
from stiffkit.spatial import Frame, exp_rotation, shift_compliance
from stiffkit.spatial.rotation import Array

RANDOM = np.random.default_rng(36)
SIGMA = 5.6e-8
NAMES = tuple("abcdefghijkl")


def identified(
    points: Array, wrenches: Array = LOADS, sigma: float = SIGMA, **options: object
) -> Identified:
    u = displaced(points, beam_compliance(), wrenches, sigma, seed=5)
    names = CASES if len(wrenches) == 6 else NAMES[: len(wrenches)]
    return identify(Field(points, u, case_names=names), wrenches, TIP, Options(**options))  # type: ignore[arg-type]


def test_the_26_zero_elements_are_found() -> None:
    # Section 4.6 of the paper.
    k, found = beam_compliance(), identified(face())
    np.testing.assert_array_equal(found.significant, k != 0.0)
    assert (found.cleaned == 0.0).sum() == 26
    np.testing.assert_allclose(found.cleaned, k, rtol=2e-3, atol=0)
    assert np.abs(found.compliance - k).max() / found.standard_error.max() < 3.5
    assert found.sigma == pytest.approx(SIGMA, rel=0.05)
    assert found.positive_definite
    assert not found.structured
    assert found.doubts == ()
    assert found.outliers is None
    low, high = found.interval
    assert ((low <= k) & (k <= high)).sum() >= 34


def test_without_noise_rounding_is_not_taken_for_significant() -> None:
    for points, scale in ((face(), 1.0), (cube(), 1e-6), (cube() + np.array([0, 0, 0.2]), 1.0)):
        found = identified(points, scale * LOADS, sigma=0.0)
        np.testing.assert_array_equal(found.significant, beam_compliance() != 0.0)
        np.testing.assert_allclose(found.cleaned, beam_compliance(), rtol=1e-11)


def test_symmetrising_halves_what_noise_does_to_mirror_elements() -> None:
    k, found = beam_compliance(), identified(face())
    np.testing.assert_array_equal(found.symmetrised, found.symmetrised.T)
    np.testing.assert_array_equal(found.symmetrised_significant, k != 0.0)
    np.testing.assert_allclose(found.cleaned_symmetrised, k, rtol=2e-3, atol=0)
    variance = np.diag(found.symmetrised_covariance).reshape(6, 6)
    expected = (found.standard_error**2 + found.standard_error.T**2) / 4.0
    off = ~np.eye(6, dtype=bool)
    np.testing.assert_allclose(variance[off], expected[off])
    np.testing.assert_allclose(np.diag(variance), np.diag(found.standard_error) ** 2)


@pytest.mark.parametrize("cases", [6, 9, 12])
def test_loads_of_any_directions(cases: int) -> None:
    wrenches = RANDOM.normal(size=(cases, 6)) * [500.0, 1, 1, 1, 1, 1]
    found = identified(face(), wrenches, sigma=1e-10)
    np.testing.assert_array_less(
        np.abs(found.compliance - beam_compliance()), 5.0 * found.standard_error
    )
    if cases > 6:
        assert found.load_misfit.max() < 3.0
    else:
        assert not found.load_misfit.any()


def test_more_load_cases_make_errors_smaller() -> None:
    six, twelve = identified(face()), identified(face(), np.vstack([LOADS, LOADS]))
    np.testing.assert_allclose(
        twelve.standard_error, six.standard_error / np.sqrt(2) * twelve.sigma / six.sigma, rtol=1e-6
    )


def test_standard_errors_are_those_of_repeated_fields() -> None:
    wrenches = RANDOM.normal(size=(7, 6)) * [500.0, 1, 1, 1, 1, 1]
    points, k = cube(4), beam_compliance()
    clean = displaced(points, k, wrenches)
    noise = SIGMA * RANDOM.normal(size=(300, *clean.shape))
    many = [identify(Field(points, clean + e), wrenches, TIP) for e in noise]
    elements = np.stack([found.compliance.ravel() for found in many])
    # 300 samples know a standard deviation to 4 %.
    ratio = elements.std(axis=0) / many[0].standard_error.ravel()
    assert 0.8 < ratio.min() < ratio.max() < 1.2
    scaled = np.cov(elements.T) / np.sqrt(np.outer(*[np.diag(many[0].covariance)] * 2))
    correlation = many[0].covariance / np.sqrt(np.outer(*[np.diag(many[0].covariance)] * 2))
    assert np.abs(scaled - correlation).max() < 0.3


def test_one_sigma_for_each_case_or_one_for_all() -> None:
    points = face()
    u = displaced(points, beam_compliance(), LOADS, SIGMA)
    u[0] += 20 * SIGMA * RANDOM.normal(size=points.shape)
    field = Field(points, u, case_names=CASES)
    pooled, single = (identify(field, LOADS, TIP, Options(pooled=p)) for p in (True, False))
    assert any("as unlike as" in note and "Fx" in note for note in pooled.notes)
    assert not any("as unlike as" in note for note in single.notes)
    np.testing.assert_allclose(
        single.standard_error / pooled.standard_error,
        np.tile(single.estimate.sigma / pooled.sigma, (6, 1)),
    )
    assert single.multiplier.reason.startswith("sigma rests on 357 ")
    assert pooled.multiplier.reason.startswith("sigma rests on 2142 ")


def test_structure_makes_intervals_nominal() -> None:
    points = face()
    u = displaced(points, beam_compliance(), LOADS, 1e-9)
    u[0] -= 1.33e-5 * (points - TIP) * [0, 1, 1]
    found = identify(Field(points, u, case_names=CASES), LOADS, TIP)
    assert found.structured
    assert found.notes[0].startswith("the intervals are nominal: in load case Fx the residuals")
    assert "Poisson contraction" in found.notes[1]


def test_a_load_that_does_not_fit_the_others_is_named() -> None:
    wrenches = np.vstack([LOADS, LOADS])
    u = displaced(face(), beam_compliance(), wrenches, SIGMA)
    claimed = wrenches.copy()
    claimed[8, 2] *= 1.01
    found = identify(Field(face(), u, case_names=NAMES), claimed, TIP)
    assert any(note.startswith("the deflection of load case") for note in found.notes)
    assert int(found.load_misfit.argmax()) in (2, 8)


def test_loads_at_another_point_show_as_asymmetry() -> None:
    found = identify(
        Field(face(), displaced(face(), beam_compliance(), LOADS)),
        LOADS,
        TIP + np.array([0.01, 0, 0]),
    )
    assert any(note.startswith("the compliance is not symmetric: elements") for note in found.notes)


def test_a_large_rotation_says_which_estimator_suits() -> None:
    found = identified(face(), 5.0 * LOADS)
    assert any("turns by 2.58" in note and "here it is LIN" in note for note in found.notes)


@pytest.mark.parametrize("count", [5, 1])
def test_too_few_load_cases_name_what_is_missing(count: int) -> None:
    with pytest.raises(FieldError) as error:
        check_loads(LOADS[:count], CASES[:count])
    assert f"only {count} load cases" in error.value.what
    assert error.value.what.endswith("; ".join(CASES[count:]))


def test_dependent_loads_name_the_missing_combination() -> None:
    wrenches = LOADS.copy()
    wrenches[5] = [0, 2.0, 0, 0, 0, 0]
    with pytest.raises(FieldError, match=r"span only 5 of 6 directions; nothing .* do: Mz\n"):
        check_loads(wrenches, CASES)
    # Fy always comes with Mz = 0.3 Fy.
    wrenches = np.vstack([np.eye(6)[[0, 2, 3, 4]], 2 * [[0, 1, 0, 0, 0, 0.3]]])
    with pytest.raises(FieldError) as error:
        check_loads(wrenches, CASES)
    words = error.value.what.split("these do: ")[1].split(" with ")
    values = {word.split(" = ")[0]: float(word.split(" ")[2]) for word in words}
    assert values.keys() == {"Fy", "Mz"}
    # The direction that is missing is at right angles to the one that is there.
    length = (1 * 1 * 0.3 * 0.3) ** 0.25  # geometric mean of the moments; of the forces it is 1
    assert values["Fy"] + 0.3 * values["Mz"] / length**2 == pytest.approx(0.0, abs=0.01)


def test_amplitudes_do_not_make_loads_dependent_but_directions_do() -> None:
    assert check_loads(LOADS * np.logspace(0, 9, 6)[:, None], CASES).condition < 1e6
    assert check_loads(LOADS, CASES).condition == pytest.approx(1.0)
    nearly = LOADS.copy()
    nearly[5] = [0, 1, 0, 0, 0, 1e-5]
    found = identify(Field(face(), displaced(face(), beam_compliance(), nearly)), nearly, TIP)
    assert any("nearly dependent" in note and note.endswith("Mz") for note in found.notes)


@pytest.mark.parametrize(
    ("wrenches", "message"),
    [
        (np.ones((6, 3)), r"shape \(cases, 6\) and have \(6, 3\)"),
        (np.ones((0, 6)), "there is no load case"),
        (np.ones((7, 6)), "6 load cases and loads for 7"),
        (np.diag([1.0, 1, 1, 1, 1, np.nan]), "load case Mz: its load .* is not finite"),
        (np.diag([1.0, 1, 0, 1, 1, 1]), "load case Fz has no load"),
    ],
)
def test_what_are_no_loads_is_refused(wrenches: Array, message: str) -> None:
    with pytest.raises(FieldError, match=message):
        check_loads(wrenches, CASES)


@pytest.mark.parametrize(
    ("coordinates", "displacements", "moments", "words"),
    [
        (1.0, 1e3, 1.0, "displacements are in mm and were read as m"),
        (1e3, 1.0, 1.0, "coordinates are probably in mm and were read as m"),
        (1.0, 1.0, 1e3, "moments are probably in N mm and were read as N m"),
    ],
)
def test_a_unit_wrong_by_1000_is_doubted(
    coordinates: float, displacements: float, moments: float, words: str
) -> None:
    u = displaced(face(), beam_compliance(), LOADS, 1e-9)
    field = Field(coordinates * face(), displacements * u, case_names=CASES)
    found = identify(field, LOADS * [1, 1, 1, *[moments] * 3], coordinates * TIP)
    assert any(words in doubt for doubt in found.doubts)


def test_what_no_body_can_be_is_said() -> None:
    u = displaced(face(), -beam_compliance(), LOADS, 1e-9)
    found = identify(Field(face(), u), LOADS, TIP)
    assert not found.positive_definite
    assert "must be positive" in found.notes[0]
    assert np.isnan(found.asymmetry).all()


def test_a_turned_field_gives_the_turned_compliance() -> None:
    T = Frame(exp_rotation([0.4, -1.1, 0.7]), np.array([0.2, 0.3, -0.5]))
    R = T.rotation
    u = displaced(face(), beam_compliance(), LOADS, SIGMA)
    here = identify(Field(face(), u), LOADS, TIP)
    there = identify(
        Field(face() @ R.T + T.position, u @ R.T), LOADS @ np.kron(np.eye(2), R).T, T.point(TIP)
    )
    np.testing.assert_allclose(
        there.compliance, shift_compliance(here.compliance, Frame(R)), rtol=0, atol=1e-13
    )
    assert there.sigma == pytest.approx(here.sigma)
