import numpy as np
import pytest

from stiffkit.spatial import (
    Frame,
    Screw,
    axis_rotation,
    exp_rotation,
    log_rotation,
    shift_compliance,
    shift_stiffness,
    skew,
    twist_shift,
)
from stiffkit.spatial.rotation import Array

RANDOM = np.random.default_rng(5)


def random_frame() -> Frame:
    return Frame(exp_rotation(RANDOM.normal(size=3)), RANDOM.normal(size=3))


def random_compliance() -> Array:
    root = RANDOM.normal(size=(6, 6))
    return np.asarray(root @ root.T)


def test_skew_is_the_cross_product() -> None:
    a, b = RANDOM.normal(size=(2, 3))
    np.testing.assert_allclose(skew(a) @ b, np.cross(a, b))


def test_rotation_about_z_turns_x_to_y() -> None:
    np.testing.assert_allclose(axis_rotation("z", np.pi / 2) @ [1, 0, 0], [0, 1, 0], atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 3.0, np.pi - 1e-9, np.pi])
def test_log_undoes_exp(angle: float) -> None:
    w = angle * np.array([2.0, -1.0, 2.0]) / 3.0
    R = exp_rotation(w)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(exp_rotation(log_rotation(R)), R, atol=1e-12)
    assert np.linalg.norm(log_rotation(R)) == pytest.approx(angle, abs=1e-12)


def test_frames_chain_and_invert() -> None:
    T_A_B, T_B_C = random_frame(), random_frame()
    p_C = RANDOM.normal(size=3)
    np.testing.assert_allclose((T_A_B @ T_B_C).point(p_C), T_A_B.point(T_B_C.point(p_C)))
    np.testing.assert_allclose(T_A_B.inverse.point(T_A_B.point(p_C)), p_C)


def test_twist_shift_is_what_a_small_rigid_motion_does() -> None:
    twist = 1e-6 * RANDOM.normal(size=6)
    P, Q = RANDOM.normal(size=(2, 3))
    moved = P + twist[:3] + exp_rotation(twist[3:]) @ (Q - P)
    at_Q = twist_shift(Q - P) @ twist
    np.testing.assert_allclose(at_Q[:3], moved - Q, rtol=1e-5)
    np.testing.assert_array_equal(at_Q[3:], twist[3:])


def test_a_turn_about_z_lifts_a_point_on_x_along_y() -> None:
    np.testing.assert_allclose(
        twist_shift([2, 0, 0]) @ [0, 0, 0, 0, 0, 1], [0, 2, 0, 0, 0, 1], atol=0
    )


def test_work_does_not_depend_on_the_point() -> None:
    twist_P, wrench_Q = RANDOM.normal(size=(2, 6))
    X = twist_shift(RANDOM.normal(size=3))
    assert (X.T @ wrench_Q) @ twist_P == pytest.approx(wrench_Q @ (X @ twist_P))


def test_shifted_compliance_moves_the_same_body_the_same_way() -> None:
    k_B, T_A_B = random_compliance(), random_frame()
    R, p = T_A_B.rotation, T_A_B.position
    wrench_A = RANDOM.normal(size=6)
    force, moment = wrench_A[:3], wrench_A[3:]
    # The same load at B's origin in B's axes, its deflection, and that carried back to A's origin.
    moment_at_B = moment - np.cross(p, force)
    twist_B = k_B @ np.concatenate([R.T @ force, R.T @ moment_at_B])
    turn = R @ twist_B[3:]
    expected = np.concatenate([R @ twist_B[:3] + np.cross(turn, -p), turn])
    np.testing.assert_allclose(shift_compliance(k_B, T_A_B) @ wrench_A, expected)


def test_shifted_stiffness_is_the_inverse_of_shifted_compliance() -> None:
    k, T = random_compliance(), random_frame()
    product = shift_stiffness(np.linalg.inv(k), T) @ shift_compliance(k, T)
    np.testing.assert_allclose(product, np.eye(6), atol=1e-8)


def test_shifting_there_and_back() -> None:
    k, T = random_compliance(), random_frame()
    np.testing.assert_allclose(shift_compliance(shift_compliance(k, T), T.inverse), k, rtol=1e-9)


def test_lever_makes_a_torsion_spring_a_deflection() -> None:
    k = np.zeros((6, 6))
    k[5, 5] = 1e-4
    at_tip = shift_compliance(k, Frame.at(-0.5))
    assert at_tip[1, 1] == pytest.approx(1e-4 * 0.5**2)
    assert at_tip[1, 5] == pytest.approx(1e-4 * 0.5)


def test_translation() -> None:
    screw = Screw.of_twist([0, -3, 0, 0, 0, 0], [1, 2, 3])
    assert screw.kind == "translation"
    assert screw.pitch == np.inf
    assert screw.describe() == "translates along y"
    oblique = Screw.of_twist([3, 4, 0, 0, 0, 1e-9], [0, 0, 0])
    assert oblique.describe() == "translates along (0.600, 0.800, 0.000)"


def test_rotation() -> None:
    # A turn about z through (0.12, 0, 0), seen at (0.12, 0.2, 0.05).
    axis_point, P = np.array([0.12, 0, 0]), np.array([0.12, 0.2, 0.05])
    twist = -2 * twist_shift(P - axis_point) @ [0, 0, 0, 0, 0, 1]
    screw = Screw.of_twist(twist, P)
    assert screw.kind == "rotation"
    assert screw.pitch == 0.0
    np.testing.assert_allclose(screw.direction, [0, 0, 1])
    np.testing.assert_allclose(screw.point, [0.12, 0, 0.05], atol=1e-15)
    assert screw.describe() == "turns about an axis along z through (120, 0, 50) mm"
    assert screw.describe("m") == "turns about an axis along z through (0.12, 0, 0.05) m"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_screw(sign: float) -> None:
    axis = np.array([2.0, 1.0, -2.0]) / 3.0
    axis_point, P = np.array([0.1, -0.2, 0.3]), np.array([1.0, 0.5, -0.4])
    pitch = 0.025
    twist = sign * twist_shift(P - axis_point) @ np.concatenate([pitch * axis, axis])
    screw = Screw.of_twist(twist, P)
    assert screw.kind == "screw"
    assert screw.pitch == pytest.approx(pitch)
    np.testing.assert_allclose(screw.direction, axis)
    np.testing.assert_allclose(np.cross(screw.point - axis_point, axis), 0, atol=1e-12)
    assert (P - screw.point) @ axis == pytest.approx(0, abs=1e-12)
    words = screw.describe()
    assert words.startswith("screws about an axis along (0.667, 0.333, -0.667) through (")
    assert words.endswith("mm, with 25 mm/rad")


def test_left_handed_screw_keeps_its_pitch() -> None:
    assert Screw.of_twist([-0.1, 0, 0, 1, 0, 0], [0, 0, 0]).pitch == pytest.approx(-0.1)
    assert Screw.of_twist([0.1, 0, 0, -1, 0, 0], [0, 0, 0]).pitch == pytest.approx(-0.1)


def test_length_decides_between_translation_and_rotation() -> None:
    twist = [1.0, 0, 0, 0, 0, 1e-4]
    assert Screw.of_twist(twist, [0, 0, 0], length=1.0).kind == "rotation"
    assert Screw.of_twist(twist, [0, 0, 0], length=1e-3).kind == "translation"


def test_a_rounding_error_does_not_make_a_screw() -> None:
    twist = [1e-9, 0.3, 1e-9, 1e-10, 0, 1.0]
    screw = Screw.of_twist(twist, [0, 0, 0], length=0.5)
    assert screw.describe() == "turns about an axis along z through (-300, 0, 0) mm"


def test_zero_is_no_motion() -> None:
    with pytest.raises(ValueError, match="no direction"):
        Screw.of_twist(np.zeros(6), np.zeros(3))
