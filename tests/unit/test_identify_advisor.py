import numpy as np
import pytest
from tests.unit.identified_beam import TIP, beam_compliance, cube

from stiffkit.errors import FieldError
from stiffkit.identify import DeflectionNoise, Field, advise

NOISE = DeflectionNoise.of_cube(0.01, 1331, 5e-8)


def test_noise_of_a_cube_is_that_of_its_field() -> None:
    field = Field(cube(), np.zeros((1, 1331, 3)))
    found = DeflectionNoise.of_field(field, TIP, 5e-8)
    assert found.translation == pytest.approx(NOISE.translation)
    assert found.rotation == pytest.approx(NOISE.rotation)
    assert found.radius == pytest.approx(NOISE.radius)


def test_the_papers_range_of_angles() -> None:
    # Section 3.5: 0.01 to 0.2 deg ensure an accuracy of about 0.2 %.
    k = beam_compliance()
    bend = {advice.load: advice for advice in advise(k, NOISE)}["My"]
    turn = np.degrees(np.linalg.norm(k[3:, 4]))
    assert round(bend.lowest * turn, 2) == 0.01
    assert round(bend.highest * turn, 1) == 0.2
    # At the ends the error is the accuracy asked for, in between it is least at `best`.
    error = {
        load: np.hypot(NOISE.rotation / (b := np.radians(load * turn)), b / 2)
        for load in np.geomspace(bend.lowest, bend.highest, 41)
    }
    assert error[bend.lowest] == pytest.approx(2e-3)
    assert list(error.values())[-1] == pytest.approx(2e-3)
    assert min(error, key=lambda load: error[load]) == pytest.approx(bend.best, rel=0.05)


def test_the_papers_loads_are_of_the_size_advised() -> None:
    # Section 4.2: 1000 N along the beam, 1 N across; 0.1 to 1 mm and 0.01 to 0.2 deg wanted.
    advice = {a.load: a for a in advise(beam_compliance(), NOISE)}
    assert advice["Fx"].lowest < 1000 < advice["Fx"].highest == np.inf
    assert advice["Fy"].lowest < 1 < advice["Fy"].highest
    assert "hardly turns" in advice["Fx"].reasoning[0]
    assert "balance at b = 0.0449 deg" in advice["Mz"].reasoning[0]
    assert 0.01 < np.degrees(advice["Fz"].rotation) < 0.2


def test_a_force_must_show_its_translation_too() -> None:
    # A force far out on a stiff part that turns about a point nearby.
    k = np.diag([1e-10, 1e-10, 1e-10, 1e-6, 1e-6, 1e-4])
    k[5, 1] = k[1, 5] = 9e-8
    advice = {a.load: a for a in advise(k, NOISE)}
    assert advice["Fy"].lowest == pytest.approx(advice["Fx"].lowest, rel=1e-6)
    assert any("stands out of the noise" in line for line in advice["Fy"].reasoning)


@pytest.mark.parametrize(
    ("compliance", "accuracy", "message"),
    [
        (np.eye(5), 2e-3, "6x6"),
        (np.diag([1e-6, 0, 1e-6, 1e-3, 1e-3, 1e-3]), 2e-3, "under Fy the expected compliance"),
        (beam_compliance(), 1e-4, "accuracy of 0.0001 cannot be had.* allows 0.00055 at best"),
        (beam_compliance(), 0.0, "accuracy between 0 and 1"),
    ],
)
def test_what_allows_no_advice_is_refused(
    compliance: np.ndarray, accuracy: float, message: str
) -> None:
    with pytest.raises(FieldError, match=message):
        advise(compliance, NOISE, accuracy)
