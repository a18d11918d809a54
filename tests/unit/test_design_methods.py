"""Optimisation: against the best cantilever there is, by every method; interrupted and resumed."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from design_cantilever import (  # type: ignore[import-not-found]
    DENSITY,
    TOOL,
    E,
    design,
    mass,
    sag,
)

from stiffkit.design import parameters_of, read_design, run_design, write_design_robot
from stiffkit.errors import OutputError, StiffkitError
from stiffkit.robot import load_robot
from stiffkit.study.sweep import prepare

HEAD = """\
vary:
  width: {from: 20 mm, to: 60 mm}
  height: {from: 20 mm, to: 80 mm}
postures: 4
"""
LIGHTEST = (
    HEAD
    + """\
objectives: {weight: {minimise: mass}}
constraints: {sag: {max: deflection_z, load: weight, below: 0.5 mm}}
"""
)
FRONT = (
    HEAD
    + """\
objectives:
  weight: {minimise: mass}
  sag: {minimise: {max: deflection_z, load: weight}}
"""
)


def lightest(bound: float) -> tuple[float, float]:
    """Return width and height of the lightest arm that yields no more than so much, m.

    Height carries more per kilogram than width, so the width is the smallest there is.
    """
    width = 0.02
    return width, (4.0 * 100.0 / (E * width * bound)) ** (1.0 / 3.0)


def chosen(designs: xr.Dataset, model: str = "refined") -> xr.Dataset:
    return designs.isel(design=json.loads(designs.attrs["chosen"])[model])


@pytest.fixture
def study(tmp_path: Path) -> Callable[[str], xr.Dataset]:
    return lambda text: run_design(design(tmp_path, text))


Run = Callable[[str], xr.Dataset]


def test_gradients_find_the_lightest_arm(study: Run) -> None:
    designs = study(LIGHTEST + "method: {gradient: {starts: 2}}\n")
    width, height = lightest(5e-4)
    best = chosen(designs)
    assert float(best.width) == pytest.approx(width, rel=1e-6)
    assert float(best.height) == pytest.approx(height, rel=1e-5)
    assert float(best.weight[0]) == pytest.approx(mass(width, height), rel=1e-5)
    assert designs.origin.values[0] == "start"
    assert float(designs.width[0]) == 0.04
    evaluations = json.loads(designs.attrs["evaluations"])
    assert evaluations["gradient"]["geometries"] > 10
    assert evaluations["gradient"]["seconds"] > 0.0
    assert designs.attrs["message"] == ""


@pytest.mark.parametrize(
    ("method", "within"),
    [
        ("grid: {steps: 41}", 0.05),
        ("evolution: {population: 30, generations: 15}", 0.02),
        ("global: {population: 30, generations: 15}", 0.02),
    ],
)
def test_other_methods_come_near_it(study: Run, method: str, within: float) -> None:
    designs = study(LIGHTEST + f"method: {{{method}}}\n")
    best = float(chosen(designs).weight[0]) - TOOL
    least = mass(*lightest(5e-4)) - TOOL
    assert least * (1.0 - 1e-6) <= best <= least * (1.0 + within)
    sags = designs.sag.values[0]
    np.testing.assert_array_equal(designs.feasible.values[0], sags <= 5e-4 * (1.0 + 1e-6))


def test_gradients_spread_over_the_front(study: Run) -> None:
    designs = study(FRONT + "method: {gradient: {starts: 1, points: 5}}\n")
    front = designs.isel(
        design=np.flatnonzero(designs.front.values[0] * (designs.origin != "start"))
    )
    weights, sags = np.sort(front.weight.values[0]), np.sort(front.sag.values[0])
    assert weights.size >= 6
    assert weights[0] == pytest.approx(mass(0.02, 0.02), rel=1e-5)
    assert sags[0] == pytest.approx(sag(0.06, 0.08), rel=1e-5)
    # On the front either the width is the smallest or the height is the largest.
    off = np.minimum(front.width.values - 0.02, 0.08 - front.height.values)
    np.testing.assert_allclose(off, 0.0, atol=2e-5)
    gaps = np.diff(np.sort(front.weight.values[0])) / np.ptp(front.weight.values[0])
    assert gaps.max() < 0.4


def test_evolution_begins_with_what_gradients_found(study: Run) -> None:
    text = (
        LIGHTEST + "method: {gradient: {starts: 1}, evolution: {population: 8, generations: 2}}\n"
    )
    best = chosen(study(text))
    assert str(best.origin.values) == "gradient"
    assert float(best.weight[0]) == pytest.approx(mass(*lightest(5e-4)), rel=1e-5)


def test_without_pymoo_it_is_asked_for(study: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pymoo.core.problem", None)
    with pytest.raises(StiffkitError, match="pymoo is needed for evolution"):
        study(LIGHTEST + "method: {evolution: {population: 8, generations: 2}}\n")


def test_whole_numbers_and_choices(study: Run) -> None:
    text = """\
vary:
  teeth: {integers: [5, 20]}
  section:
    choose:
      flat: {width: 60 mm, height: 20 mm}
      square: {width: 35 mm, height: 35 mm}
      tall: {width: 20 mm, height: 60 mm}
postures: 4
objectives: {teeth_count: {maximise: {min: stiffness_translation_min}}}
constraints: {sag: {max: deflection_z, load: weight, below: 0.5 mm}}
method: {evolution: {population: 12, generations: 6}}
"""
    designs = study(text)
    best = chosen(designs)
    assert float(best.teeth) % 1.0 == 0.0
    assert set(np.unique(designs.height.values[1:])) <= {0.02, 0.035, 0.06}
    # The weakest direction is the flattest: the square bends least at its worst.
    assert str(best.section.values) == "tall" if sag(0.035, 0.035) > 5e-4 else "square"
    assert designs.section.values[0] == ""
    assert designs.width.attrs["kind"] == "choice"


def test_both_models_have_their_own_best(study: Run) -> None:
    text = """\
vary: {height: {from: 20 mm, to: 80 mm}, length: {from: 0.5 m, to: 1.5 m}}
postures: 4
models: [refined, simplified]
objectives: {weight: {minimise: mass}}
constraints:
  across: {max: deflection_translation, load: weight, below: start}
  reach: {of: size, above: start}
method: {gradient: {starts: 1}}
"""
    designs = study(text)
    # Drives alone hold the arm rigidly across, so the simplified model takes the thinnest one.
    assert float(chosen(designs, "simplified").height) == pytest.approx(0.02)
    assert float(chosen(designs, "refined").height) == pytest.approx(0.04, rel=1e-5)
    assert designs.across.attrs["bound_by_model"][0] == pytest.approx(sag(0.04, 0.04))
    assert designs.across.attrs["bound_by_model"][1] == 0.0


def test_derived_parameters_follow(study: Run, tmp_path: Path) -> None:
    text = LIGHTEST.replace("  height: {from: 20 mm, to: 80 mm}\n", "")
    designs = study(text + "derived: {height: = 1.5 * width}\nmethod: {grid: {steps: 5}}\n")
    np.testing.assert_allclose(designs.height, 1.5 * designs.width)
    assert designs.height.attrs["kind"] == "derived"
    values = parameters_of(designs, 3)
    assert values.keys() == {"width", "height"}
    write_design_robot(designs, 3, tmp_path / "new.yaml")
    robot = load_robot(tmp_path / "new.yaml")
    assert robot.parameters["height"].value == float(designs.height[3])
    total = (robot.links["arm"].mass or 0.0) + TOOL
    assert total == pytest.approx(float(designs.weight[0, 3]))
    with pytest.raises(StiffkitError, match="no design 99"):
        parameters_of(designs, 99)


class TestClashes:
    """What is told where no design fulfils all constraints."""

    def test_two_that_exclude_each_other(self, study: Run) -> None:
        text = HEAD + (
            "objectives: {weight: {minimise: mass}}\n"
            "constraints:\n"
            "  sag: {max: deflection_z, load: weight, below: 0.1 mm}\n"
            "  light: {of: mass, below: 10 kg}\n"
            "  long: {of: size, below: 5 m}\n"
            "method: {gradient: {starts: 2}}\n"
        )
        designs = study(text)
        message = designs.attrs["message"]
        assert "'sag'" in message
        assert "'light'" in message
        assert "cannot be met together" in message
        assert "'long'" not in message
        assert "'reached'" not in message
        assert json.loads(designs.attrs["chosen"]) == {}
        assert not designs.feasible.any()
        # Of all designs the one told violates least: with both at the edge of the ranges.
        height = (4.0 * 100.0 / (E * 0.02 * 1e-4)) ** (1.0 / 3.0)
        least = DENSITY * 0.02 * min(height, 0.08)
        assert least + TOOL > 10.0

    def test_one_that_cannot_be_met(self, study: Run) -> None:
        text = HEAD + (
            "objectives: {weight: {minimise: mass}}\n"
            "constraints:\n"
            "  light: {of: mass, below: 6 kg}\n"
            "  stiff: {max: deflection_z, load: weight, below: 20 mm}\n"
            "method: {gradient: {starts: 1}}\n"
        )
        message = study(text).attrs["message"]
        assert "no design meets 'light'" in message
        assert "stiff" not in message
        assert "width = 0.02" in message

    def test_without_gradients(self, study: Run) -> None:
        text = (
            "vary: {teeth: {integers: [5, 7]}}\npostures: 2\n"
            "objectives: {weight: {minimise: mass}}\n"
            "constraints: {light: {of: mass, below: 6 kg}}\n"
            "method: {grid: {}}\n"
        )
        assert "no design meets 'light'" in study(text).attrs["message"]


class TestRangesWithoutARobot:
    """Arms too short to meet: none of the designs asked for can be put together."""

    TEXT = (
        "design: Arms\nrobot: five-bar\npostures: 4\n"
        "vary: {proximal: {from: 1 mm, to: 2 mm}}\n"
        "objectives: {weakest: {maximise: {min: stiffness_translation_min}}}\n"
        "method: {gradient: {starts: 2}, evolution: {population: 5, generations: 2},"
        " global: {population: 5, generations: 2}}\n"
    )

    @pytest.fixture(autouse=True)
    def _fewer_candidates(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(prepare, "_MOST_IN_VAIN", 2)

    def run(self, folder: Path, text: str) -> xr.Dataset:
        (folder / "arms.yaml").write_text(text, encoding="utf-8")
        return run_design(read_design(folder / "arms.yaml"))

    def test_the_start_stays(self, tmp_path: Path) -> None:
        designs = self.run(tmp_path, self.TEXT)
        assert json.loads(designs.attrs["chosen"]) == {"refined": 0}
        assert designs.feasible.sum() == 1
        assert np.isnan(designs.weakest[0, 1:]).all()
        # Descents have nothing to go by, and do not try.
        assert json.loads(designs.attrs["evaluations"])["gradient"]["geometries"] < 40

    def test_the_reason_is_told(self, tmp_path: Path) -> None:
        bound = "constraints: {stiff: {min: stiffness_translation_min, above: 1e9 N/m}}\n"
        message = self.run(tmp_path, self.TEXT + bound).attrs["message"]
        assert "none of the designs that were looked at can be put together" in message
        assert "'vary'" in message


class KilledError(Exception):
    """Ends a run in the middle."""


METHODS = (
    "method: {grid: {steps: 3}, gradient: {starts: 2, points: 2},"
    " evolution: {population: 8, generations: 3}, global: {population: 8, generations: 2},"
    " seed: 5}\n"
)


def same(first: xr.Dataset, second: xr.Dataset) -> bool:
    return all(
        np.array_equal(
            first[name].values, second[name].values, equal_nan=first[name].dtype == float
        )
        for name in first.variables
    )


def test_what_is_killed_goes_on_and_ends_the_same(tmp_path: Path) -> None:
    spec = design(tmp_path, FRONT + METHODS)
    undisturbed = run_design(spec)
    told: list[str] = []

    def kill_at(count: int) -> Callable[[str, float], None]:
        def progress(what: str, _share: float) -> None:
            told.append(what)
            if len(told) == count:
                raise KilledError

        return progress

    for count in (4, 8, 11):
        told.clear()
        with pytest.raises(KilledError):
            run_design(spec, tmp_path / "out", progress=kill_at(count))
    steps = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out" / "steps").iterdir()}
    assert len(steps) >= 5
    resumed = run_design(spec, tmp_path / "out")
    after = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out" / "steps").iterdir()}
    assert steps.items() <= after.items(), "a finished step was computed again"
    assert same(undisturbed, resumed)
    assert set(np.unique(resumed.origin)) == {"start", "grid", "gradient", "evolution", "global"}
    assert resumed.attrs["created"] == run_design(spec, tmp_path / "out").attrs["created"]


def test_a_damaged_step_is_computed_again(tmp_path: Path) -> None:
    spec = design(tmp_path, LIGHTEST + "method: {grid: {steps: 4}}\n")
    first = run_design(spec, tmp_path / "out")
    (tmp_path / "out" / "steps" / "grid-00000.npz").write_bytes(b"nonsense")
    (tmp_path / "out" / "designs.nc").write_bytes(b"nonsense")
    assert same(run_design(spec, tmp_path / "out"), first)


def test_a_directory_with_something_else_is_refused(tmp_path: Path) -> None:
    spec = design(tmp_path, LIGHTEST + "method: {grid: {steps: 2}}\n")
    other = design(tmp_path, LIGHTEST + "method: {grid: {steps: 3}}\n", "other.yaml")
    run_design(spec, tmp_path / "out")
    with pytest.raises(OutputError, match="holds the study 'Arm', begun with another file"):
        run_design(other, tmp_path / "out")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter.txt").write_text("dear")
    with pytest.raises(OutputError, match="holds no design study"):
        run_design(spec, tmp_path / "full")
    (tmp_path / "out" / "design.json").write_text("{")
    with pytest.raises(OutputError, match="is damaged"):
        run_design(spec, tmp_path / "out")


def test_the_dataset_says_what_everything_is(study: Run) -> None:
    designs = study(LIGHTEST + "method: {grid: {steps: 3}}\n")
    expected: dict[str, dict[str, Any]] = {
        "width": {"units": "m", "kind": "continuous", "low": 0.02, "high": 0.06},
        "weight": {"units": "kg", "role": "objective", "sense": "min"},
        "sag": {"units": "m", "role": "constraint", "sense": "below", "bound": 5e-4},
        "reached": {"units": "1", "role": "constraint", "sense": "above", "bound": 1.0},
    }
    for name, attributes in expected.items():
        assert attributes.items() <= designs[name].attrs.items(), name
        assert designs[name].attrs["long_name"]
    assert designs.sizes == {"design": 10, "model": 1}
    assert json.loads(designs.attrs["options"])["title"] == "Arm"
