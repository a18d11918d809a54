"""Assembly modes followed against closed form: never the other branch, as far as the reach goes."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.errors import AssemblyError
from stiffkit.kinematics import Kinematics, Postures, Status
from stiffkit.robot import Robot, load_robot
from stiffkit.spatial import exp_rotation
from stiffkit.stiffness import Stiffness

Array = NDArray[np.float64]
Load = Callable[..., Robot]

needs_heyoka = pytest.mark.skipif(
    importlib.util.find_spec("heyoka") is None, reason="heyoka is not installed"
)

ARM = """
robot: Planar arm of two links
links:
  upper: {rigid: {length: 0.5}}
  lower: {rigid: {length: 0.3}}
joints:
  shoulder: {revolute: z, from: base, to: upper.base, drive: 1e4}
  elbow: {revolute: z, from: upper.tip, to: lower.base, drive: 1e4}
tool: {at: lower.tip}
home: {x: 0.3, y: 0.4, elbow: 1.8}
"""
L1, L2 = 0.5, 0.3


def two_bar(
    x: Array, y: Array, l1: float = L1, l2: float = L2, *, bend: float = 1.0
) -> tuple[Array, Array]:
    """Return shoulder and elbow angles of an arm; NaN beyond its reach.

    J. J. Craig, Introduction to Robotics, section 4.4.
    """
    cosine = (x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2)
    with np.errstate(invalid="ignore"):
        elbow = bend * np.arccos(cosine)
    shoulder = np.arctan2(y, x) - np.arctan2(l2 * np.sin(elbow), l1 + l2 * np.cos(elbow))
    return shoulder, elbow


def assert_angles(found: Array, expected: Array, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(np.angle(np.exp(1j * (found - expected))), 0.0, atol=tolerance)


def grid(low: tuple[float, float], high: tuple[float, float], n: int) -> Array:
    x, y = np.meshgrid(*(np.linspace(a, b, n) for a, b in zip(low, high, strict=True)))
    return np.stack([x.ravel(), y.ravel()])


def joint(kinematics: Kinematics, postures: Postures, name: str) -> Array:
    return np.asarray(postures.joints[kinematics.joint_names.index(name)])


def catalogue_text(name: str) -> str:
    source = load_robot(name).source
    assert source is not None
    return Path(source).read_text(encoding="utf-8")


# Over the whole reach.


@pytest.mark.parametrize("bend", [1.0, -1.0])
def test_arm_over_its_whole_reach(robot_of: Load, bend: float) -> None:
    """The base is a hole in the workspace, which straight lines from home run into."""
    kinematics = Kinematics(robot_of(ARM.replace("elbow: 1.8", f"elbow: {1.8 * bend}")))
    poses = grid((-0.9, -0.9), (0.9, 0.9), 43)
    found = kinematics.solve(poses)
    r = np.hypot(*poses)
    assert not found.reached[(r > L1 + L2 + 1e-6) | (r < L1 - L2 - 1e-6)].any()
    within = (r < L1 + L2 - 1e-3) & (r > L1 - L2 + 1e-3)
    assert found.reached[within].all()
    shoulder, elbow = two_bar(poses[0], poses[1], bend=bend)
    assert_angles(joint(kinematics, found, "shoulder.rz")[within], shoulder[within])
    assert_angles(joint(kinematics, found, "elbow.rz")[within], elbow[within])
    np.testing.assert_allclose(found.tool[:2, within], poses[:, within], atol=1e-10)


def five_bar_angles(poses: Array) -> dict[str, Array]:
    """Return the angles of the catalogue's five-bar with both elbows outward."""
    x, y = poses
    left, elbow_left = two_bar(x + 0.15, y, 0.2, 0.35, bend=-1.0)
    right, elbow_right = two_bar(x - 0.15, y, 0.2, 0.35, bend=1.0)
    return {
        "motor_left.rz": left,
        "elbow_left.rz": elbow_left,
        "motor_right.rz": right,
        "elbow_right.rz": elbow_right,
        "wrist.rz": right + elbow_right - left - elbow_left,
    }


@pytest.mark.parametrize("side", [0.42, 0.28])
def test_five_bar_over_its_whole_reach(side: float) -> None:
    """Two rings overlap, and there is no straight way from home to what lies behind their holes.

    In the narrow box the way there leaves the box.
    """
    kinematics = Kinematics(load_robot("five-bar"))
    poses = grid((-side, -0.55), (side, 0.55), 45)
    found = kinematics.solve(poses)
    radii = np.stack([np.hypot(poses[0] + x, poses[1]) for x in (-0.15, 0.15)])
    margin = np.minimum(0.55 - radii, radii - 0.15).min(axis=0)
    assert not found.reached[margin < -1e-6].any()
    inside = margin > 2e-3
    assert found.reached[inside].all()
    for name, expected in five_bar_angles(poses).items():
        assert_angles(joint(kinematics, found, name)[inside], expected[inside])


def test_hexapod_legs_have_the_lengths_that_the_pose_demands() -> None:
    robot = load_robot("hexapod-cubic")
    kinematics = Kinematics(robot)
    rng = np.random.default_rng(0)
    poses = kinematics.home.tool + np.diag([0.05] * 3 + [0.15] * 3) @ rng.uniform(-1, 1, (6, 30))
    found = kinematics.solve(poses)
    assert found.reached.all()
    np.testing.assert_allclose(found.tool, poses, atol=1e-10)
    for n in range(poses.shape[1]):
        R, p = exp_rotation(poses[3:, n]), poses[:3, n]
        for k in range(1, 7):
            foot = robot.joints[f"foot_{k}"].T_from_joint.position
            ball = R @ robot.joints[f"ball_{k}"].T_to_joint.position + p
            stroke = joint(kinematics, found, f"drive_{k}.x")[n]
            assert 0.4 + stroke == pytest.approx(np.linalg.norm(ball - foot), abs=1e-10)


def test_delta_motors() -> None:
    """Against the closed form of one leg: a circle of the elbow and a sphere around the wrist."""
    kinematics = Kinematics(load_robot("delta"))
    rng = np.random.default_rng(0)
    poses = np.array([[0.0], [0.0], [-0.5]]) + 0.1 * rng.uniform(-1, 1, (3, 25))
    found = kinematics.solve(poses)
    assert found.reached.all()
    for k, phi in enumerate(np.radians([0.0, 120.0, 240.0]), start=1):
        u = np.cos(phi) * poses[0] + np.sin(phi) * poses[1] - 0.07
        v = -np.sin(phi) * poses[0] + np.cos(phi) * poses[1]
        w = poses[2]
        # |(u - 0.25 cos a, v, w + 0.25 sin a)| = 0.55 with the arm turned by a about its motor.
        c = (u**2 + v**2 + w**2 + 0.25**2 - 0.55**2) / (2 * 0.25)
        expected = np.arctan2(-w, u) - np.arccos(c / np.hypot(u, w))
        assert_angles(joint(kinematics, found, f"motor_{k}.ry"), expected)


# Limits of reach, where two branches meet.


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, -2.5])
@pytest.mark.parametrize("limit", [L1 + L2, L1 - L2])
def test_the_limit_of_reach(robot_of: Load, angle: float, limit: float) -> None:
    """Exactly at the limit the arm is straight or folded; a millionth beyond is out of reach."""
    kinematics = Kinematics(robot_of(ARM))
    direction = np.array([[np.cos(angle)], [np.sin(angle)]])
    outward = 1.0 if limit > 0.5 else -1.0
    at = kinematics.solve(limit * direction)
    assert at.reached.all()
    np.testing.assert_allclose(at.tool[:2], limit * direction, atol=1e-9)
    assert kinematics.solve((limit - 1e-7 * outward) * direction).reached.all()
    outside = kinematics.solve((limit + 1e-6 * outward) * direction)
    assert not outside.reached.any()
    assert np.isnan(outside.coordinates).all()
    assert np.isnan(outside.joints).all()


def test_lines_along_a_hole_never_change_the_branch(robot_of: Load) -> None:
    """Lines from home that pass the hole, or cut into it, at all distances from its edge."""
    kinematics = Kinematics(robot_of(ARM))
    home = np.array([0.3, 0.4])
    distance = np.hypot(*home)
    off_the_edge = np.concatenate([[0.0], *(s * np.logspace(-10, -1.3, 14) for s in (-1, 1))])
    for sense, further in ((-1.0, 1.3), (1.0, 1.05), (1.0, 1.6)):
        angle = np.arctan2(home[1], home[0]) + np.pi
        angle = angle + sense * np.arcsin((L1 - L2 + off_the_edge) / distance)
        targets = home[:, None] + further * distance * np.stack([np.cos(angle), np.sin(angle)])
        for target in targets.T:
            found = kinematics.solve(target[:, None])
            if L1 - L2 + 1e-6 < np.hypot(*target) < L1 + L2 - 1e-6:
                assert found.reached.all()
                _, elbow = two_bar(target[:1], target[1:])
                assert_angles(joint(kinematics, found, "elbow.rz"), elbow, 1e-6)


def test_a_pose_beyond_reach_has_a_status(robot_of: Load) -> None:
    kinematics = Kinematics(robot_of(ARM))
    postures = kinematics.solve(np.array([[0.3, 2.0], [0.4, 0.0]]))
    np.testing.assert_array_equal(postures.reached, [True, False])
    found = Stiffness(kinematics, "simplified").at(postures)
    assert found.status[1] == Status.UNREACHABLE
    assert np.isnan(found.lower[:, 1]).all()


def test_wanted_poses_only(robot_of: Load) -> None:
    kinematics = Kinematics(robot_of(ARM))
    wanted = np.array([True, False, True])
    found = kinematics.solve(np.array([[0.3, 0.31, 0.32], [0.4, 0.4, 0.4]]), wanted)
    np.testing.assert_array_equal(found.reached, wanted)


# Orientation of the tool, as far as half a turn.

WRIST = """
robot: Arm with a wrist
parameters: {turn: 0 deg}
links:
  upper: {rigid: {length: 0.5}}
  lower: {rigid: {length: 0.4}}
  hand: {rigid: {length: 0.2}}
joints:
  shoulder: {revolute: z, from: base, to: upper.base, drive: 1e4}
  elbow: {revolute: z, from: upper.tip, to: lower.base, drive: 1e4}
  wrist: {revolute: z, from: lower.tip, to: hand.base, drive: 1e4}
tool: {at: hand.base}
home: {x: 0.6, y: 0.2, rz: = turn, elbow: 90 deg}
"""


@pytest.mark.parametrize("turn", [0.5, 1.6, 3.0, np.pi, np.pi - 1e-12, -np.pi, -3.0, 4.0, 6.2])
def test_the_tool_turns_as_far_as_is_asked(robot_of: Load, turn: float) -> None:
    """Half a turn away the equations of orientation hold too, and must not be taken for it."""
    found = Kinematics(robot_of(WRIST)).solve_at({"rz": turn})
    assert found.reached.all()
    np.testing.assert_allclose(found.tool[:2, 0], [0.6, 0.2], atol=1e-10)
    expected = exp_rotation([0, 0, turn])
    np.testing.assert_allclose(exp_rotation(found.tool[3:, 0]), expected, atol=1e-9)


@pytest.mark.parametrize("turn", ["0 deg", "179 deg", "180 deg", "-120 deg"])
@pytest.mark.parametrize("hints", ["elbow: 90 deg", "shoulder: 0, elbow: 1, wrist: -1"])
def test_tool_coordinates_at_home_are_met_exactly(robot_of: Load, turn: str, hints: str) -> None:
    robot = robot_of(WRIST.replace("elbow: 90 deg", hints), {"turn": turn})
    tool = Kinematics(robot).home.tool[:, 0]
    np.testing.assert_allclose(tool[:2], [0.6, 0.2], atol=1e-10)
    expected = exp_rotation([0, 0, robot.parameters["turn"].value])
    np.testing.assert_allclose(exp_rotation(tool[3:]), expected, atol=1e-9)


def test_a_spherical_joint_in_the_tree(robot_of: Load) -> None:
    """A body on a ball joint takes any orientation; its tool point moves with it."""
    robot = robot_of(
        "robot: Ball\n"
        "links: {rod: {rigid: {length: 0.3}}}\n"
        "joints: {ball: {spherical: true, from: base, to: rod.base}}\n"
        "tool: {at: rod.tip}\n"
        "home: {rx: 0, ry: 0, rz: 0}\n"
        "workspace: {rx: [-1, 1], ry: [-1, 1], rz: [-1, 1]}\n"
    )
    kinematics = Kinematics(robot)
    assert kinematics.asked == ("rx", "ry", "rz")
    turns = np.random.default_rng(0).uniform(-1.6, 1.6, (3, 40))
    found = kinematics.solve(turns)
    assert found.reached.all()
    np.testing.assert_allclose(found.coordinates, turns, atol=1e-9)
    for turn, p in zip(turns.T, found.tool[:3].T, strict=True):
        np.testing.assert_allclose(p, exp_rotation(turn) @ [0.3, 0, 0], atol=1e-10)


def test_preferred_coordinates_are_solved_for() -> None:
    by_pose = Kinematics(load_robot("five-bar"))
    rz = float(by_pose.solve_at({"x": 0.05, "y": 0.38}).tool[5, 0])
    by_turn = Kinematics(load_robot("five-bar"), prefer=("rz", "x"))
    assert by_turn.asked == ("x", "rz")
    found = by_turn.solve_at({"x": 0.05, "rz": rz})
    np.testing.assert_allclose(found.tool[:, 0], [0.05, 0.38, 0, 0, 0, rz], atol=1e-9)


# Putting together.


def test_a_loop_that_cannot_close_is_named(robot_of: Load) -> None:
    text = catalogue_text("five-bar").replace("base: 300 mm", "base: 1200 mm")
    with pytest.raises(AssemblyError) as error:
        Kinematics(robot_of(text.replace("x: 0, y: 400 mm, ", "")))
    message = str(error.value)
    assert "cannot be put together at its home posture" in message
    assert "stays open by" in message
    assert "'wrist'" in message
    assert "mend:" in message


@pytest.mark.parametrize("left", [-80.0, 80.0])
@pytest.mark.parametrize("right", [-80.0, 80.0])
def test_hints_choose_the_assembly_mode(robot_of: Load, left: float, right: float) -> None:
    text = catalogue_text("five-bar").replace("elbow_right: 80 deg", f"elbow_right: {right} deg")
    kinematics = Kinematics(robot_of(text.replace("-80 deg, elbow_r", f"{left} deg, elbow_r")))
    for name, hint in (("elbow_left.rz", left), ("elbow_right.rz", right)):
        assert np.sign(joint(kinematics, kinematics.home, name)[0]) == np.sign(hint)


# Kernels of other robots in the same process.


@needs_heyoka
def test_drives_on_other_joints_do_not_take_the_wrong_code(robot_of: Load) -> None:
    """The same joints, but another spanning tree."""
    text = catalogue_text("five-bar")
    moved = text.replace("    drive: 2e4 N m/rad\n", "")
    moved = moved.replace("to: left_rod.base}", "to: left_rod.base, drive: 1e4}")
    moved = moved.replace("to: right_rod.tip}", "to: right_rod.tip, drive: 1e4}")
    trees = set()
    for robot in (robot_of(text), robot_of(moved)):
        kinematics = Kinematics(robot, backend="heyoka")
        trees.add(tuple(chord.name for chord in kinematics.tree.chords))
        found = kinematics.solve_at({"x": 0.05})
        for name, expected in five_bar_angles(np.array([[0.05], [0.4]])).items():
            assert_angles(joint(kinematics, found, name), expected)
    assert len(trees) == 2


WEDGE = """
robot: Wedge
parameters: {turn: 30 deg}
links: {carriage: {rigid: {ports: {}}}, wedge: {rigid: {ports: {}}}}
joints:
  slide:
    {prismatic: x, from: base, rotate: {z: 30 deg}, to: carriage, to_rotate: {z: 30 deg}, drive: 1}
  face: {prismatic: x, from: carriage, rotate: {z: 30 deg}, to: wedge, to_rotate: {z: 30 deg}}
  guide: {prismatic: x, from: base, rotate: {z: = turn}, to: wedge, to_rotate: {z: = turn}}
tool: {at: carriage}
home: {x: 0}
"""


@needs_heyoka
def test_equations_that_hold_by_chance_are_not_left_out_of_other_robots(robot_of: Load) -> None:
    """Three parallel slides leave out an equation that slides at an angle to each other need."""
    for turn in ("30 deg", "75 deg"):
        kinematics = Kinematics(robot_of(WEDGE, {"turn": turn}), backend="heyoka")
        found = kinematics.solve_at({"x": 0.1})
        stroke = 0.1 / np.cos(np.radians(30))
        assert joint(kinematics, found, "slide.x")[0] == pytest.approx(stroke, abs=1e-9)
        wedge = stroke + joint(kinematics, found, "face.x")[0]
        assert joint(kinematics, found, "guide.x")[0] == pytest.approx(wedge, abs=1e-9)
    assert wedge == pytest.approx(0.0, abs=1e-9)
