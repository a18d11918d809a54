"""Singular and degenerate mechanisms: named by what moves freely."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from stiffkit.kinematics import Status
from stiffkit.robot import Robot, load_robot
from stiffkit.study import Analysis, analyse_pose, summarise

CATALOGUE = files("stiffkit.robot").joinpath("catalogue")


def variant(directory: Path, name: str, *changes: tuple[str, str]) -> Robot:
    """A catalogue robot with pieces of its file replaced."""
    text = CATALOGUE.joinpath(f"{name}.yaml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = directory / "variant.yaml"
    path.write_text(text)
    return load_robot(path)


def test_five_bar_with_collinear_distal_links(tmp_path: Path) -> None:
    # Elbows 600 mm apart hold rods of 300 mm in one line: the tool can leave it sideways.
    robot = variant(
        tmp_path,
        "five-bar",
        ("distal: 350 mm ", "distal: 300 mm "),
        ("base: 300 mm ", "base: 200 mm "),
        ("workspace: {x: [-150 mm, 150 mm], y: [300 mm, 450 mm]}", ""),
        (
            "home: {x: 0, y: 400 mm, elbow_left: -80 deg, elbow_right: 80 deg}",
            "home: {x: 0, y: 0, motor_left: 180 deg, motor_right: 0 deg,"
            " elbow_left: -180 deg, elbow_right: 180 deg}",
        ),
    )
    for model in ("refined", "simplified"):
        result = analyse_pose(robot, model=model)
        assert result.status is Status.SINGULAR
        assert result.compliance is None
        (motion,) = result.free_motions
        assert "the tool turns about an axis along z through (-300, 0, 0) mm" in motion
        assert "all drives locked" in motion
        assert "elbow_left" in motion


def test_five_bar_singular_inside_its_workspace() -> None:
    # With both elbows on one circle about the tool the rods lie in one line for an ordinary tool.
    analysis = Analysis(load_robot("five-bar"))
    half = 0.15
    height = np.sqrt(0.2**2 - (0.35 - half) ** 2)
    result = analyse_pose(analysis, {"x": 0.0, "y": height})
    assert result.status is Status.SINGULAR
    assert any("the tool" in motion for motion in result.free_motions)


def test_two_parallel_hinges_one_behind_the_other(tmp_path: Path) -> None:
    text = (
        "robot: Arm with a redundant hinge\n"
        "links:\n"
        "  arm: {beam: {length: 300 mm, section: {round: 30 mm}, material: steel}}\n"
        "  knuckle: {rigid: {length: 50 mm}}\n"
        "  rod: {beam: {length: 400 mm, section: {round: 20 mm}, material: steel}}\n"
        "  slide: {rigid: {ports: {}}, mass: 1 kg}\n"
        "joints:\n"
        "  motor: {revolute: z, from: base, to: arm.base, drive: 1e5 N m/rad}\n"
        "  first: {revolute: z, from: arm.tip, to: knuckle.base}\n"
        "  second: {revolute: z, from: knuckle.base, to: rod.base}\n"
        "  pin: {revolute: z, from: rod.tip, to: slide}\n"
        "  rail: {prismatic: x, from: base, to: slide}\n"
        "tool: {at: slide}\n"
        "home: {x: 600 mm, motor: 40 deg}\n"
        "loads: {push: {force: [100 N, 0, 0]}}\n"
    )
    path = tmp_path / "redundant.yaml"
    path.write_text(text)
    once = tmp_path / "once.yaml"
    kept = [line for line in text.splitlines() if "first:" not in line and "knuckle: {" not in line]
    once.write_text("\n".join(kept).replace("from: knuckle.base", "from: arm.tip"))
    redundant, plain = Analysis(load_robot(path)), Analysis(load_robot(once))
    a, b = analyse_pose(redundant), analyse_pose(plain)
    assert a.status is b.status is Status.OK
    assert a.compliance == pytest.approx(b.compliance, rel=1e-9, abs=1e-20)
    (idle,) = redundant.refined.at_home.idle_motions
    assert idle.joints == ["first", "second"]
    assert "first, second" in dict(summarise(redundant).facts)["idle motions"]


@pytest.mark.parametrize(("missing", "n_free"), [((6,), 1), ((5, 6), 2)])
def test_platform_held_by_too_few_legs(
    tmp_path: Path, missing: tuple[int, ...], n_free: int
) -> None:
    kept = [k for k in range(1, 7) if k not in missing]
    lows = ["0 deg", "0 deg", "120 deg", "120 deg", "240 deg", "240 deg"]
    highs = ["-60 deg", "60 deg", "60 deg", "180 deg", "180 deg", "-60 deg"]
    robot = variant(
        tmp_path,
        "hexapod-cubic",
        ("k: [1, 2, 3, 4, 5, 6]", f"k: {kept}"),
        (f"low: [{', '.join(lows)}]", f"low: [{', '.join(lows[k - 1] for k in kept)}]"),
        (f"high: [{', '.join(highs)}]", f"high: [{', '.join(highs[k - 1] for k in kept)}]"),
    )
    result = analyse_pose(robot)
    assert result.status is Status.UNCONTROLLED
    assert result.compliance is None
    assert not result.deflections
    assert len(result.free_motions) == n_free
    assert all(motion.startswith("the tool ") for motion in result.free_motions)
    # The stiffness that is there is semi-definite, with one zero for each free motion.
    assert result.stiffness is not None
    unit_free = np.diag([1.0] * 3 + [5.0] * 3)
    values = np.linalg.eigvalsh(unit_free @ result.stiffness @ unit_free)
    assert np.sum(values < 1e-9 * values[-1]) == n_free
    warnings = " ".join(summarise(robot).warnings)
    assert f"{6 - len(missing)} drives" in warnings or "free motions" in warnings


def test_rods_that_spin_are_idle_and_do_no_harm() -> None:
    analysis = Analysis(load_robot("delta"))
    idle = analysis.refined.at_home.idle_motions
    assert sorted(motion.joints for motion in idle) == sorted(
        [f"elbow_{side}_{k}", f"wrist_{side}_{k}"] for side in ("left", "right") for k in (1, 2, 3)
    )
    assert analyse_pose(analysis).status is Status.OK


def test_home_that_is_singular_is_said(tmp_path: Path) -> None:
    robot = variant(
        tmp_path,
        "five-bar",
        ("home: {x: 0, y: 400 mm, elbow_left: -80 deg, elbow_right: 80 deg}", "home: {x: 0, y: 0}"),
    )
    assert any("singular" in warning for warning in summarise(robot).warnings)


def test_what_a_model_holds_rigidly_is_nothing_and_not_a_small_number() -> None:
    """The simplified Orthoglide does not turn at all: no 1e34 N m/rad, and no noise beside it."""
    result = analyse_pose(load_robot("orthoglide"), model="simplified")
    assert result.status is Status.OK
    assert result.compliance is not None
    assert result.rotation is not None
    assert np.isinf(result.rotation.stiffness).all()
    assert result.stiffness is None
    np.testing.assert_array_equal(result.compliance - np.diag(np.diag(result.compliance)), 0.0)
    np.testing.assert_array_equal(np.diag(result.compliance)[3:], 0.0)
