"""Loop closure: equations, assembly modes, reach, mobility."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray
from tests.properties.mechanisms import (
    LENGTH,
    Mechanism,
    build,
    joint_specs,
    mechanisms,
    planar_mechanisms,
)

from stiffkit.errors import PoseError
from stiffkit.kinematics import ClosureEquations, Kinematics
from stiffkit.kinematics.coordinates import joint_coordinates, rotation_vectors
from stiffkit.kinematics.frames import joint_motion
from stiffkit.kinematics.numeric import evaluate
from stiffkit.robot import load_robot
from stiffkit.smallmat import vector
from stiffkit.spatial import exp_rotation

Array = NDArray[np.float64]


@given(mechanisms())
def test_equations_hold_where_loops_are_closed(mechanism: Mechanism) -> None:
    tree = mechanism.tree
    closure = ClosureEquations(tree, (), LENGTH)
    q = mechanism.coordinates(tree)
    assert np.abs(evaluate(closure, q, np.empty(0)).residuals).max(initial=0.0) < 1e-12


@given(mechanisms(), planar_mechanisms())
def test_jacobian_is_the_derivative_at_closed_postures(a: Mechanism, b: Mechanism) -> None:
    for mechanism in (a, b):
        tree = mechanism.tree
        closure = ClosureEquations(tree, (), LENGTH)
        q = mechanism.coordinates(tree)
        scales = np.where(closure.translates, LENGTH, 1.0)
        J = evaluate(closure, q, np.empty(0)).jacobian
        for j in range(len(q)):
            step = np.zeros(len(q))
            step[j] = 1e-6 * scales[j]
            up, down = (evaluate(closure, q + s * step, np.empty(0)).residuals for s in (1, -1))
            assert np.abs((up - down) / 2e-6 - J[:, j]).max(initial=0.0) < 1e-6


@given(joint_specs())
def test_coordinates_are_read_off_frames(spec: object) -> None:
    mechanism = build(((spec,),), 3)  # type: ignore[arg-type]
    joint = mechanism.robot.joints["joint0"]
    rng = np.random.default_rng(1)
    q = rng.uniform(-1.7, 1.7, (len(joint.motions), 50))
    frame = joint_motion(joint, vector(q))
    R = np.array([[np.broadcast_to(x, 50) for x in row] for row in frame.R], dtype=float)
    p = np.array([np.broadcast_to(x, 50) for x in frame.p], dtype=float)
    assert joint_coordinates(joint, R, p) == pytest.approx(q, abs=1e-12)


def test_rotation_vectors_up_to_half_a_turn() -> None:
    rng = np.random.default_rng(0)
    axes = rng.normal(size=(3, 200))
    axes /= np.linalg.norm(axes, axis=0)
    for angle in (0.0, 1e-12, 1e-7, 1.0, 3.0, np.pi - 1e-6, np.pi - 1e-9):
        w = angle * axes
        R = np.stack([exp_rotation(column) for column in w.T], axis=2)
        assert rotation_vectors(R) == pytest.approx(w, abs=2e-9)


def five_bar_angles(x: Array, y: Array) -> Array:
    """Closed form of the catalogue's five-bar, both elbows outward: motor and elbow angles."""
    found = []
    for side, turn in ((-1.0, 1.0), (1.0, -1.0)):
        dx, dy = x - side * 0.15, y
        r2 = dx**2 + dy**2
        elbow = np.arccos((r2 - 0.2**2 - 0.35**2) / (2 * 0.2 * 0.35))
        inner = np.arctan2(0.35 * np.sin(elbow), 0.2 + 0.35 * np.cos(elbow))
        found.append((np.arctan2(dy, dx) + turn * inner, -turn * elbow))
    (left, elbow_left), (right, elbow_right) = found
    return np.stack([left, right, elbow_left, elbow_right])


def test_five_bar_stays_in_its_assembly_mode() -> None:
    kinematics = Kinematics(load_robot("five-bar"))
    x, y = (
        a.ravel() for a in np.meshgrid(np.linspace(-0.15, 0.15, 31), np.linspace(0.3, 0.45, 21))
    )
    postures = kinematics.solve(np.stack([x, y]))
    assert postures.reached.all()
    names = ["motor_left.rz", "motor_right.rz", "elbow_left.rz", "elbow_right.rz"]
    found = postures.joints[[kinematics.joint_names.index(name) for name in names]]
    wrong = np.angle(np.exp(1j * (found - five_bar_angles(x, y))))
    assert np.abs(wrong).max() < 1e-9


def test_reach_ends_where_the_arms_are_straight() -> None:
    kinematics = Kinematics(load_robot("five-bar"))
    # Left arm and rod in one line: 550 mm from the left motor.
    angle = np.linspace(0.3, 1.2, 25)
    far = 0.55 * np.stack([np.cos(angle), np.sin(angle)]) + [[-0.15], [0.0]]
    home = np.array([[0.0], [0.4]])
    inside = home + (1 - 1e-6) * (far - home)
    outside = home + (1 + 1e-6) * (far - home)
    assert kinematics.solve(inside).reached.all()
    assert kinematics.solve(far).reached.all()
    beyond = kinematics.solve(outside)
    assert not beyond.reached.any()
    assert np.isnan(beyond.coordinates).all()
    assert np.isnan(beyond.tool).all()


def test_postures_behind_a_hole_are_found_around_it() -> None:
    # Within 150 mm of a motor the arm cannot fold; the way from home through there is barred.
    kinematics = Kinematics(load_robot("five-bar"))
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(-0.3, 0.3, 61), np.linspace(-0.4, 0.45, 86)))
    legs_reach = np.ones(x.size, dtype=bool)
    for side in (-0.15, 0.15):
        r = np.hypot(x - side, y)
        legs_reach &= (r < 0.55 - 1e-3) & (r > 0.15 + 1e-3)
    postures = kinematics.solve(np.stack([x, y]))
    assert not (postures.reached & ~legs_reach)[
        np.minimum(np.hypot(x - 0.15, y), np.hypot(x + 0.15, y)) < 0.149
    ].any()
    below = legs_reach & (y < -0.2)
    assert below.sum() > 500
    assert postures.reached[below].mean() > 0.99


@pytest.mark.parametrize(
    ("name", "counted", "numeric", "tool", "idle", "loops"),
    [
        ("five-bar", -1, 2, 2, 0, 1),
        ("biglide", -1, 2, 2, 0, 1),
        ("hexapod-cubic", 6, 6, 6, 0, 5),
        ("delta", 9, 9, 3, 6, 5),
        ("3-puu", 3, 3, 3, 0, 2),
    ],
)
def test_mobility(name: str, counted: int, numeric: int, tool: int, idle: int, loops: int) -> None:
    m = Kinematics(load_robot(name)).mobility
    assert (m.counted, m.numeric, m.tool, m.idle, m.n_loops) == (
        counted,
        numeric,
        tool,
        idle,
        loops,
    )
    assert m.over_constraint == numeric - counted


def test_coordinates_that_follow_are_checked() -> None:
    kinematics = Kinematics(load_robot("biglide"))
    followed = kinematics.solve_at({"x": 0.5, "z": 0.0})
    assert followed.reached[0]
    with pytest.raises(PoseError, match=r"cannot have z = 0\.1 m"):
        kinematics.solve_at({"x": 0.5, "z": 0.1})


def test_a_translating_platform_keeps_its_orientation() -> None:
    for name in ("delta", "3-puu"):
        kinematics = Kinematics(load_robot(name))
        home = kinematics.home.tool[:3]
        rng = np.random.default_rng(0)
        postures = kinematics.solve(home + rng.uniform(-0.04, 0.04, (3, 50)))
        assert postures.reached.all()
        assert np.abs(postures.tool[3:]).max() < 1e-9


def test_backends_find_the_same_postures() -> None:
    asked = np.random.default_rng(0).uniform(-0.03, 0.03, (6, 40))
    robot = load_robot("hexapod-cubic")
    found = []
    for backend in ("numpy", "heyoka"):
        kinematics = Kinematics(robot, backend=backend)
        found.append(kinematics.solve(asked + kinematics.home.tool))
    assert found[0].reached.all()
    assert found[0].joints == pytest.approx(found[1].joints, abs=1e-10)


ARM = """
robot: Arm
links:
  upper: {rigid: {length: 0.5}}
  lower: {rigid: {length: 0.3}}
joints:
  shoulder: {revolute: z, from: base, to: upper.base, drive: 1e4}
  elbow: {revolute: z, from: upper.tip, to: lower.base, drive: 1e4}
tool: {at: lower.tip}
home: {x: 0.3, y: 0.4, elbow: 1}
"""


def test_a_single_pose_behind_a_hole_is_found_around_it(tmp_path: Path) -> None:
    # The arm cannot reach within 200 mm of its base, which lies between home and this pose.
    path = tmp_path / "arm.yaml"
    path.write_text(ARM)
    kinematics = Kinematics(load_robot(path))
    posture = kinematics.solve_at({"x": -0.4, "y": -0.4})
    assert posture.reached[0]
    elbow = posture.joints[kinematics.joint_names.index("elbow.rz"), 0]
    assert np.cos(elbow) == pytest.approx((0.32 - 0.5**2 - 0.3**2) / (2 * 0.5 * 0.3))
    assert np.sin(elbow) > 0.0
    assert not kinematics.solve_at({"x": 0.1, "y": 0.1}).reached[0]


def test_no_poses_at_all() -> None:
    kinematics = Kinematics(load_robot("five-bar"))
    assert len(kinematics.solve(np.empty((2, 0)))) == 0
