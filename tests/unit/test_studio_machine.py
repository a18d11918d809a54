"""The studio's machine: variants of robots, solved over their workspaces and at single poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from stiffkit import load_robot, map_workspace
from stiffkit.errors import AssemblyError, PoseError, StiffkitError
from stiffkit.kinematics import Status
from stiffkit.robot import RobotFile
from stiffkit.robot.catalogue import find_robot
from stiffkit.stiffness import Model
from stiffkit.studio.machine import Machine, Variant
from stiffkit.studio.sliders import in_si
from stiffkit.studio.statics import tool_twist
from stiffkit.study import QUANTITIES, analyse_pose

RIGID = 1e15
"""Stiffness, SI, above which a direction is rigid and the number rounding."""

POINTS = 100


@lru_cache
def machine_of(name: str) -> Machine:
    return Machine(name, points=POINTS)


@pytest.fixture
def five_bar() -> Machine:
    return machine_of("five-bar")


def written(path: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Return a robot of the catalogue with some of its text replaced."""
    text = find_robot(name).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


def assert_same_as_map(source: str | Path, machine: Machine, values: Mapping[str, float]) -> None:
    given = {n: in_si(v, machine.robot.parameters[n].unit) for n, v in values.items()}
    robot = load_robot(source, given)
    counts = dict(zip(machine.swept, machine.shape, strict=True))
    robot = replace(robot, workspace=replace(robot.workspace, counts=counts))
    dataset = map_workspace(robot, frequencies=False)
    variant = machine.variant(values)
    for model in machine.models:
        status = dataset.status.sel(model=model).values
        assert status.shape == variant.shape
        np.testing.assert_array_equal(variant.status(model), status.ravel())
        for name in machine.quantities:
            if QUANTITIES[name].source == "frequencies":
                continue
            for load in machine.loads if QUANTITIES[name].per_load else (None,):
                expected, scale = (
                    dataset[quantity].sel(model=model).sel({} if load is None else {"load": load})
                    for quantity in (name, QUANTITIES[name].scale)
                )
                size = float(np.nan_to_num(np.abs(scale.values)).max())
                if RIGID > size > 1.0 / RIGID:
                    found = variant.quantity(name, model, load)
                    np.testing.assert_allclose(
                        found, expected.values.ravel(), rtol=0.0, atol=1e-6 * size
                    )


def assert_alike(one: Variant, other: Variant, within: float = 1e-8) -> None:
    """Two machines' own geometries differ by rounding, as one may be compiled when made."""
    for model in one.machine.models:
        np.testing.assert_array_equal(one.status(model), other.status(model))
        for name in ("deflection_translation", "stiffness_rotation_min"):
            load = one.machine.loads[0] if QUANTITIES[name].per_load else None
            found, expected = (v.quantity(name, model, load) for v in (one, other))
            small = expected < RIGID
            np.testing.assert_array_equal(small, found < RIGID)
            np.testing.assert_allclose(found[small], expected[small], rtol=within)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("five-bar", {"base": 0.45}),  # some poses are out of reach
        ("five-bar", {"proximal": 0.23, "distal": 0.31}),
        ("biglide", {"L1": 0.9, "a": 0.87, "drive": 3e8}),
        ("delta", {"rod": 0.54, "platform_radius": 0.053}),
        ("hexapod-cubic", {"edge": 0.41, "leg": 4e6, "half": 0.12}),  # half follows from edge
    ],
)
def test_a_variant_is_the_map_of_the_robot_with_these_parameters(
    name: str, values: dict[str, float]
) -> None:
    assert_same_as_map(name, machine_of(name), values)


def test_statuses_are_those_of_the_map(tmp_path: Path) -> None:
    loose = written(
        tmp_path / "loose.yaml",
        "five-bar",
        ("to: right_arm.base\n    drive: 2e4 N m/rad", "to: right_arm.base"),
    )
    machine = Machine(loose, points=POINTS)
    variant = machine.variant({"base": 0.5})
    assert_same_as_map(loose, machine, {"base": 0.5})
    kinds = set(variant.status("refined").tolist())
    assert kinds == {Status.UNCONTROLLED, Status.UNREACHABLE}
    assert variant.at(variant.home).result().status is Status.UNCONTROLLED


def test_a_variant_does_not_depend_on_the_way_there(five_bar: Machine) -> None:
    goal = {"base": 0.41, "distal": 0.33}
    fresh = five_bar.variant(goal)
    walked = Machine("five-bar", points=POINTS)
    lost = walked.variant({"base": 0.6})
    assert not lost.reached.all()
    for values in ({"base": 0.2}, {"base": 0.55}, {"proximal": 0.35}, {"distal": 0.6}):
        walked.variant({**goal, **values})
    with pytest.raises(StiffkitError):
        walked.variant({**goal, "distal": 0.1})
    assert_alike(walked.variant(goal), fresh)
    assert_alike(walked.variant(), five_bar.variant())
    assert walked.variant().reached.all()


def test_what_was_forgotten_comes_out_the_same_to_the_last_bit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("stiffkit.studio.stations._MOST_KEPT", 1)
    monkeypatch.setattr("stiffkit.studio.machine._MOST_KEPT", 1)
    machine = Machine("five-bar", points=POINTS)
    goal = {"base": 0.58, "proximal": 0.22}
    first = machine.variant(goal)
    for base in (0.2, 0.56, 0.3, 0.45):
        machine.variant({"base": base, "proximal": 0.22})
    again = machine.variant(goal)
    assert again is not first
    assert_alike(again, first, within=0.0)


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ({"distal": float("nan")}, StiffkitError),
        ({"distal": float("inf")}, StiffkitError),
        ({"distal": -0.35}, StiffkitError),
        ({"distal": 0.0}, StiffkitError),
        ({"distal": 1e300}, StiffkitError),
        ({"base": 1e6}, AssemblyError),
        ({"distal": 0.05}, AssemblyError),
        ({"elbow": 1.0}, StiffkitError),
    ],
)
def test_impossible_values_are_refused_and_leave_no_trace(
    five_bar: Machine, values: dict[str, float], error: type[StiffkitError]
) -> None:
    before = five_bar.variant({"base": 0.31})
    with pytest.raises(error) as caught:
        five_bar.variant(values)
    assert caught.value.mend
    assert five_bar.variant({"base": 0.31}) is before
    assert_same_as_map("five-bar", five_bar, {"base": 0.29})


def test_loops_are_not_closed_again_where_only_a_stiffness_changes() -> None:
    machine = machine_of("biglide")
    own, soft = machine.variant(), machine.variant({"drive": 5e8})
    assert soft.closed.q is own.closed.q
    assert soft.robot.joints["slide_1"].stiffness[1] == 5e8
    ratio = soft.quantity("deflection_xy", "simplified", "f_y") / own.quantity(
        "deflection_xy", "simplified", "f_y"
    )
    np.testing.assert_allclose(ratio, 2.0, rtol=1e-6)


def test_values_of_the_file_make_the_robot_of_the_file(five_bar: Machine) -> None:
    assert five_bar.variant({"base": 0.3}) is five_bar.variant()
    assert five_bar.variant().values == {}


def test_sliders_are_of_what_can_be_moved() -> None:
    machine = machine_of("hexapod-cubic")
    assert set(machine.parameters) == {"edge", "leg"}
    assert set(machine.following) == {"half", "radius"}
    edge = machine.parameters["edge"]
    assert (edge.low, edge.value, edge.high, edge.unit) == (0.2, 0.4, 0.8, "mm")
    assert machine.variant({"edge": 0.5}).robot.parameters["radius"].value == pytest.approx(
        0.5 * np.sqrt(2.0 / 3.0)
    )


def test_sliders_end_where_the_file_makes_no_sense_any_more(tmp_path: Path) -> None:
    thin = written(
        tmp_path / "thin.yaml",
        "five-bar",
        ("tube: [40 mm, 4 mm]", "tube: [= outer, 12 mm]"),
        ("  base: 300 mm", "  outer: 40 mm\n  turn: 0 deg\n  shift: 0 mm\n  base: 300 mm"),
        ("at: [= base/2, 0, 0]", "at: [= base/2 + shift, 0, 0]\n    rotate: {z: = turn}"),
    )
    machine = Machine(thin, points=POINTS)
    outer, turn, shift = (machine.parameters[n] for n in ("outer", "turn", "shift"))
    assert 0.024 <= outer.low < 0.025
    assert outer.high == 0.08
    assert [turn.low, turn.high] == pytest.approx([-np.pi / 6, np.pi / 6])
    assert shift.low == -shift.high
    assert 0.01 < shift.high < 1.0
    assert_same_as_map(thin, machine, {"turn": 0.1, "shift": 0.02})
    machine.variant({"outer": outer.low})


def test_parts_from_cad_are_known_to_take_their_time() -> None:
    known = RobotFile("orthoglide-cad").dependence()
    assert known.solved == {"L", "d", "foot"}
    assert known.following == {"across"}
    assert RobotFile("five-bar").dependence().solved == frozenset()


@pytest.mark.parametrize(
    ("name", "model"),
    [("five-bar", "refined"), ("five-bar", "simplified"), ("delta", "refined")],
)
def test_a_pose_is_what_analyse_pose_finds(name: str, model: Model) -> None:
    machine = machine_of(name)
    chosen = machine.parameters[next(iter(machine.parameters))]
    values = {chosen.name: 1.02 * chosen.value}
    variant = machine.variant(values)
    pose = {d: value + 0.021 * (i + 1) for i, (d, value) in enumerate(variant.home.items())}
    found = variant.at(pose).result(model)
    given = {chosen.name: in_si(values[chosen.name], chosen.unit)}
    expected = analyse_pose(load_robot(name, given), pose, model=model)
    assert found.status is expected.status is Status.OK
    assert found.compliance is not None
    assert expected.compliance is not None
    size = np.abs(expected.compliance).max()
    np.testing.assert_allclose(found.compliance, expected.compliance, rtol=1e-8, atol=1e-9 * size)
    np.testing.assert_allclose(found.tool, expected.tool, atol=1e-12)
    # Rods between ball joints may spin, in one way or the other.
    assert found.joints.keys() == expected.joints.keys()
    motors = {n: angle for n, angle in expected.joints.items() if n.startswith("motor")}
    assert motors
    assert {n: found.joints[n] for n in motors} == pytest.approx(motors, abs=1e-9)
    assert found.method == expected.method
    for load, deflection in expected.deflections.items():
        np.testing.assert_allclose(
            found.deflections[load], deflection, rtol=1e-6, atol=1e-6 * np.abs(deflection).max()
        )


def test_a_pose_out_of_reach_says_so(five_bar: Machine) -> None:
    view = five_bar.variant().at({"x": 0.0, "y": 0.8})
    assert not view.reached
    assert np.isnan(view.q).all()
    assert view.modes() is None
    assert view.static_shape("push") is None
    for model in five_bar.models:
        result = view.result(model)
        assert result.status is Status.UNREACHABLE
        assert "y = 0.8 m" in result.reason


def test_a_pose_keeps_the_assembly_mode_beyond_the_workspace(five_bar: Machine) -> None:
    # The elbows stay outside, however far the tool goes.
    variant = five_bar.variant()
    for x in np.linspace(-0.3, 0.3, 7):
        joints = variant.at({"x": float(x), "y": 0.25}).result().joints
        assert joints["elbow_left.rz"] < 0.0 < joints["elbow_right.rz"]


def test_coordinates_that_do_not_fit_are_refused(five_bar: Machine) -> None:
    variant = five_bar.variant()
    with pytest.raises(PoseError, match="no tool coordinate"):
        variant.at({"u": 0.0})
    with pytest.raises(PoseError, match="cannot have z"):
        variant.at({"z": 0.1})
    assert variant.at({"z": 0.0}).asked == variant.home


@pytest.mark.parametrize("name", ["five-bar", "hexapod-cubic", "biglide"])
def test_the_static_shape_moves_the_tool_by_its_compliance(name: str) -> None:
    machine = machine_of(name)
    variant = machine.variant()
    pose = {d: value + 0.03 for d, value in variant.home.items()}
    view = variant.at(pose)
    compliance = view.result().compliance
    assert compliance is not None
    modes = view.modes()
    assert modes is not None
    for load in machine.loads:
        shape = view.static_shape(load)
        assert shape is not None
        assert shape.shape == (modes.shapes.shape[0], 1)
        expected = compliance @ variant.robot.loads[load].wrench
        twist = tool_twist(variant.modal, view.q, shape)[:, 0]
        np.testing.assert_allclose(twist, expected, rtol=0, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(tool_twist(variant.modal, view.q, modes.shapes), modes.tool)


def test_no_static_shape_where_a_load_moves_the_tool_freely(tmp_path: Path) -> None:
    loose = written(
        tmp_path / "loose.yaml",
        "five-bar",
        ("to: right_arm.base\n    drive: 2e4 N m/rad", "to: right_arm.base"),
    )
    view = Machine(loose, points=POINTS).variant().at({"x": 0.05})
    assert view.static_shape("push") is None
    assert view.static_shape("lift") is not None


def test_frequencies_are_those_of_the_map() -> None:
    machine = machine_of("five-bar")
    values = {"distal": 0.37}
    variant = machine.variant(values)
    given = {"distal": in_si(0.37, "mm")}
    dataset = map_workspace(load_robot("five-bar", given), points=POINTS, frequencies=True)
    for model in machine.models:
        expected = dataset.frequency_first.sel(model=model).values.ravel()
        found = variant.quantity("frequency_first", model)
        np.testing.assert_allclose(found, expected, rtol=3e-4)


def test_the_worst_posture_is_named(five_bar: Machine) -> None:
    variant = five_bar.variant({"base": 0.5})
    for name, load, pick in (
        ("deflection_translation", "push", np.nanmax),
        ("stiffness_translation_min", None, np.nanmin),
    ):
        values = variant.quantity(name, "refined", load)
        assert np.isnan(values).any()
        worst = variant.worst(name, "refined", load)
        assert worst is not None
        assert worst == (np.flatnonzero(values == worst[1])[0], pick(values))


def test_names_that_do_not_exist_are_refused(five_bar: Machine) -> None:
    variant = five_bar.variant()
    for name, load in (("deflection", "push"), ("deflection_xy", "pull"), ("deflection_xy", None)):
        with pytest.raises(StiffkitError):
            variant.quantity(name, "refined", load)


def test_poses_are_a_grid_or_a_list(five_bar: Machine, tmp_path: Path) -> None:
    variant = five_bar.variant()
    assert variant.is_grid
    assert tuple(len(values) for values in variant.axes.values()) == variant.shape
    np.testing.assert_array_equal(
        variant.poses, [grid.ravel() for grid in np.meshgrid(*variant.axes.values(), indexing="ij")]
    )
    np.testing.assert_array_equal(variant.points[:, :2], variant.poses.T)
    assert not variant.points[:, 2].any()
    listed = written(
        tmp_path / "listed.yaml",
        "five-bar",
        (
            "workspace: {x: [-150 mm, 150 mm], y: [300 mm, 450 mm]}",
            "workspace: {points: {x: [0, 100 mm], y: [400 mm, 350 mm]}}",
        ),
    )
    few = Machine(listed).variant({"base": 0.31})
    assert not few.is_grid
    assert few.axes == {}
    assert few.shape == (2,)
    assert few.reached.all()


def test_a_robot_without_parameters_has_one_variant(tmp_path: Path) -> None:
    plain = written(
        tmp_path / "plain.yaml",
        "five-bar",
        ("parameters:\n", ""),
        ("  base: 300 mm          # between the two motors\n", ""),
        ("  proximal: 200 mm      # length of the arms\n", ""),
        ("  distal: 350 mm        # length of the rods\n", ""),
        ("= base/2", "150 mm"),
        ("= -base/2", "-150 mm"),
        ("= proximal", "200 mm"),
        ("= distal", "350 mm"),
    )
    machine = Machine(plain, points=POINTS)
    assert not machine.parameters
    assert machine.variant().quantity("deflection_xy", "refined", "push").max() > 0.0
