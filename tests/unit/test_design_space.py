"""Points of the unit cube and what they stand for; losses, violations and fronts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from design_cantilever import design  # type: ignore[import-not-found]

from stiffkit.design.judge import WITHOUT_ANSWER, Judge, front
from stiffkit.design.space import Space
from stiffkit.design.spec import Variable
from stiffkit.errors import StiffkitError

VARIABLES = (
    Variable("length", "continuous", ("length",), ((0.5, 1.5),), ("m",)),
    Variable("teeth", "integer", ("teeth",), ((10.0, 11.0, 12.0),), ("",)),
    Variable(
        "tube", "choice", ("width", "wall"), ((0.04, 0.06), (0.003, 0.002)), ("m", "m"), ("a", "b")
    ),
)


@pytest.fixture
def space() -> Space:
    return Space(VARIABLES)


def test_points_stand_for_parameters(space: Space) -> None:
    u = np.array([[0.0, 0.25, 1.0], [0.0, 0.5, 1.0], [0.0, 0.6, 1.0]])
    np.testing.assert_allclose(
        space.parameters(u),
        [[0.5, 0.75, 1.5], [10.0, 11.0, 12.0], [0.04, 0.06, 0.06], [0.003, 0.002, 0.002]],
    )


def test_there_and_back(space: Space) -> None:
    u = space.sample(50, 3)
    np.testing.assert_allclose(space.points(space.parameters(u)), u, atol=1e-12)
    np.testing.assert_array_equal(space.snapped(u), u)


def test_the_nearest_values_are_taken(space: Space) -> None:
    u = space.points(np.array([[9.0], [10.6], [0.042], [0.0029]]))
    np.testing.assert_allclose(space.parameters(u)[:, 0], [1.5, 11.0, 0.04, 0.003])


def test_a_grid_has_every_combination_once(space: Space) -> None:
    values = space.parameters(space.grid(4))
    assert values.shape == (4, 4 * 3 * 2)
    assert len({tuple(column) for column in values.T}) == 24
    np.testing.assert_allclose(np.unique(values[0]), [0.5, 5 / 6, 7 / 6, 1.5])


def test_a_front_has_what_no_other_betters() -> None:
    losses = np.array([[1.0, 2.0, 3.0, 2.0, 0.5, 1.0], [3.0, 2.0, 1.0, 2.5, 9.0, 3.0]])
    feasible = np.array([True, True, True, True, False, True])
    assert front(losses, feasible).tolist() == [True, True, True, False, False, False]
    assert not front(losses, np.zeros(6, dtype=bool)).any()


class TestJudge:
    """Of a study with an objective to maximise, and bounds of both kinds."""

    text = """\
vary: {width: {from: 20 mm, to: 60 mm}}
objectives: {stiff: {maximise: {min: stiffness_translation_min}}}
constraints:
  light: {of: mass, below: start}
  wide: {of: size, above: 2 m}
  middle: {joint: slide, to: 0}
"""

    @pytest.fixture
    def judge(self, tmp_path: Path) -> Judge:
        spec = design(tmp_path, self.text)
        assert [m.name for m in spec.measures] == [
            "stiff",
            "reached",
            "light",
            "wide",
            "middle_highest",
        ]
        return Judge(spec, np.array([[1e6, 1.0, 20.0, 1.5, 0.1]]))

    def test_bounds(self, judge: Judge) -> None:
        np.testing.assert_allclose(judge.bounds, [[1.0, 20.0, 2.0, 0.0]])

    def test_what_the_start_does_not_have_is_no_bound(self, judge: Judge) -> None:
        with pytest.raises(StiffkitError, match="the start has no 'light' by the refined model"):
            Judge(judge.spec, np.array([[1e6, 1.0, np.nan, 1.5, 0.1]]))

    def test_violations_are_over_the_bound(self, judge: Judge) -> None:
        measures = np.array([[[2e6, 1e6], [1.0, 0.9], [22.0, 19.0], [1.5, np.nan], [0.3, -1.0]]])
        np.testing.assert_allclose(judge.losses(measures), [[[-2.0, -1.0]]])
        expected = [[[0.0, 0.1], [0.1, 0.0], [0.25, WITHOUT_ANSWER], [0.3, 0.0]]]
        np.testing.assert_allclose(judge.violations(measures), expected)
        assert not judge.feasible(measures).any()

    def test_feasible_is_what_breaks_nothing(self, judge: Judge) -> None:
        good = np.array([1e6, 1.0, 20.0, 2.0, 0.0])
        measures = np.stack([good, good, good], axis=1)[None]
        measures[0, 0, 1] = np.nan
        measures[0, 2, 2] *= 1.0 + 1e-5
        assert judge.feasible(measures).tolist() == [[True, False, False]]
