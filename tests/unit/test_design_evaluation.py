"""Measures of designs: those of theory, of maps, and of long studies; and their derivatives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from design_cantilever import design, mass, sag  # type: ignore[import-not-found]

from stiffkit.design.evaluation import Evaluation
from stiffkit.design.read import read_design
from stiffkit.design.slopes import Row, Slopes
from stiffkit.design.space import Space
from stiffkit.design.spec import DesignSpec
from stiffkit.robot import load_robot
from stiffkit.study import Analysis, map_workspace

CANTILEVER = """\
vary:
  width: {from: 20 mm, to: 60 mm}
  height: {from: 20 mm, to: 60 mm}
  travel: {from: 50 mm, to: 150 mm}
derived: {length: = 25 * height}
postures: 5
models: [refined, simplified]
frequencies: {postures: 2}
objectives: {weight: {minimise: mass}}
constraints:
  sag: {max: deflection_z, load: weight, below: 1 mm}
  long: {of: size, below: 2 m}
  stroke: {stroke: slide, below: 1 m}
  ends: {joint: slide, from: -1, to: 1}
  slow: {min: frequency_first, above: 1 Hz}
"""

FIVE_BAR = """\
design: Arms
robot: five-bar
vary:
  proximal: {from: 150 mm, to: 260 mm}
  distal: {from: 100 mm, to: 420 mm}
postures: 40
models: [refined, simplified]
objectives:
  weakest: {maximise: {min: stiffness_translation_min}}
  typical: {maximise: {mean: stiffness_translation_min}}
  push: {minimise: {percentile: 90, of: deflection_xy, load: push}}
  weight: {minimise: mass}
constraints:
  motor: {joint: motor_left, from: -7 rad, to: 7 rad}
"""


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory: pytest.TempPathFactory) -> Evaluation:
    return Evaluation(design(tmp_path_factory.mktemp("cantilever"), CANTILEVER))


@pytest.fixture(scope="module")
def five_bar(tmp_path_factory: pytest.TempPathFactory) -> Evaluation:
    return Evaluation(five_bar_spec(tmp_path_factory.mktemp("five-bar")))


def five_bar_spec(folder: Path) -> DesignSpec:
    path = folder / "arms.yaml"
    path.write_text(FIVE_BAR, encoding="utf-8")
    return read_design(path)


def by_name(evaluation: Evaluation, found: np.ndarray) -> dict[str, np.ndarray]:
    names = [measure.name for measure in evaluation.measures]
    return {name: found[:, r] for r, name in enumerate(names)}


def test_a_cantilever_is_as_theory_has_it(cantilever: Evaluation) -> None:
    values = np.array([[0.03, 0.05], [0.04, 0.03], [0.06, 0.14]])
    found = by_name(cantilever, cantilever.at(values))
    for i, (width, height, travel) in enumerate(values.T):
        length = 25.0 * height
        assert found["weight"][:, i] == pytest.approx([mass(width, height, length)] * 2)
        assert found["sag"][0, i] == pytest.approx(sag(width, height, length), rel=1e-9)
        assert found["long"][:, i] == pytest.approx([length] * 2)
        assert found["stroke"][:, i] == pytest.approx([2.0 * travel] * 2)
        assert found["ends_lowest"][:, i] == pytest.approx([-travel] * 2)
        assert found["ends_highest"][:, i] == pytest.approx([travel] * 2)
        # The drive alone moves the tool alone.
        assert found["slow"][1, i] == pytest.approx(np.sqrt(1.2e6 / 5.0) / (2.0 * np.pi))
    np.testing.assert_allclose(found["reached"], 1.0)


def test_the_refined_frequency_is_that_of_the_modes(cantilever: Evaluation) -> None:
    from stiffkit.study import analyse_modes

    values = np.array([0.03, 0.04, 0.06])
    found = by_name(cantilever, cantilever.at(values[:, None]))["slow"][0, 0]
    geometry = cantilever.family.geometry(values)
    modes = analyse_modes(geometry.robot, {"y": 0.0})
    assert found == pytest.approx(modes.modes[0].frequency_hz, rel=1e-3)


def test_measures_are_those_of_a_map(five_bar: Evaluation) -> None:
    values = np.array([[0.2, 0.21], [0.35, 0.36]])
    found = by_name(five_bar, five_bar.at(values))
    counts = dict(zip(five_bar.family.swept, five_bar.family.grid.shape, strict=True))
    for i, (proximal, distal) in enumerate(values.T):
        robot = load_robot("five-bar", {"proximal": float(proximal), "distal": float(distal)})
        robot = replace(robot, workspace=replace(robot.workspace, counts=counts))
        mapped = map_workspace(robot, frequencies=False)
        for m, model in enumerate(("refined", "simplified")):
            own = mapped.sel(model=model)
            weakest = own.stiffness_translation_min.values
            assert found["weakest"][m, i] == pytest.approx(np.nanmin(weakest), rel=1e-9)
            assert found["typical"][m, i] == pytest.approx(np.nanmean(weakest), rel=1e-9)
            push = own.deflection_xy.sel(load="push").values
            assert found["push"][m, i] == pytest.approx(np.nanpercentile(push, 90), rel=1e-9)
        total = sum(link.mass or 0.0 for link in robot.links.values()) + (robot.tool.mass or 0.0)
        assert found["weight"][:, i] == pytest.approx([total] * 2)


def test_joint_ranges_are_those_of_the_postures(five_bar: Evaluation) -> None:
    found = by_name(five_bar, five_bar.at(np.array([[0.2], [0.35]])))
    kinematics = Analysis(load_robot("five-bar")).kinematics
    geometry = five_bar.family.geometry(np.array([0.2, 0.35]))
    row = kinematics.joint_names.index("motor_left.rz")
    postures = [
        kinematics.solve_at(dict(zip(five_bar.family.swept, pose, strict=True)))
        for pose in geometry.poses[:, geometry.inside].T.tolist()
    ]
    angles = [float(posture.joints[row, 0]) for posture in postures]
    assert found["motor_lowest"][0, 0] == pytest.approx(min(angles), abs=1e-9)
    assert found["motor_highest"][0, 0] == pytest.approx(max(angles), abs=1e-9)


def test_what_is_not_reached_is_a_share(five_bar: Evaluation) -> None:
    values = np.array([[0.2, 0.15, 0.2, 0.2], [0.35, 0.28, 0.1, -0.1]])
    found = by_name(five_bar, five_bar.at(values))
    assert found["reached"][0, 0] == 1.0
    assert 0.0 < found["reached"][0, 1] < 1.0
    assert found["reached"][0, 2:].tolist() == [0.0, 0.0]
    assert np.isfinite(found["weakest"][0]).tolist() == [True, True, False, False]


def test_a_design_does_not_depend_on_its_neighbours(five_bar: Evaluation) -> None:
    values = np.array([[0.2, 0.22, 0.18], [0.35, 0.3, 0.4]])
    together = five_bar.at(values)
    for i in range(3):
        np.testing.assert_array_equal(five_bar.at(values[:, i : i + 1])[..., 0], together[..., i])


@pytest.mark.parametrize("which", ["cantilever", "five_bar"])
def test_derivatives_agree_with_differences(which: str, request: pytest.FixtureRequest) -> None:
    evaluation: Evaluation = request.getfixturevalue(which)
    space = Space(evaluation.spec.variables)
    slopes = Slopes(evaluation, space)
    # Off the start, whose section is a square: there two frequencies are the same.
    u = space.points(evaluation.start()[:, None])[:, 0] + np.array([-0.1, 0.1, 0.1])[: space.size]
    rows = []
    for r, measure in enumerate(evaluation.measures):
        # Where two postures are the worst, the worst has no derivative.
        if measure.kind != "reached" and measure.name != "weakest":
            rows.append(Row(r))
        if measure.column is not None:
            rows += [Row(r, 0), Row(r, 1)]
    for model in range(2):
        exact = slopes.at(u, rows, model)
        differences = slopes.differences(u, rows, model)
        sizes = np.abs(slopes.values(u, rows, model))[:, None]
        # The simplified cantilever is rigid across: there is nothing to compare.
        sizes[sizes == 0.0] = np.inf
        # The fast model, of which differences are taken, has frequencies to 1e-4.
        np.testing.assert_allclose(exact / sizes, differences / sizes, rtol=1e-3, atol=2e-5)
