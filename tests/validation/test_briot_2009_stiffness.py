"""Briot 2009, section 2: figures 3 and 5.

S. Briot, A. Pashkevich, D. Chablat, "On the optimal design of parallel robots taking into account
their deformations and natural frequencies", ASME IDETC 2009.

The figures' values are not printed; what the text says of them is. Curves are taken over the
workspace x from a - L2 to L1, at P, under 1000 N.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.robot import Robot, load_robot
from stiffkit.spatial import skew
from stiffkit.stiffness import Model, deflection
from stiffkit.study import Analysis

Array = NDArray[np.float64]

A, L1, L2 = 0.92, 0.85, 0.775  # appendix, m
DRIVE = 1e9  # section 2.1, N/m
FORCE = 1000.0  # section 2.2, N

# The outermost samples lie just inside the limits, where the simplified model's x deflection is 0.
X = np.linspace(A - L2, L1, 303)[1:-1]


def biglide() -> Robot:
    return load_robot("biglide")


@cache
def curves(model: Model) -> dict[str, Array]:
    """Deflections (6, n) along x for the loads f_x, f_y, f_z."""
    analysis = Analysis(biglide())
    postures = analysis.kinematics.solve(np.stack([X, np.zeros_like(X)]))
    assert postures.reached.all()
    found = analysis.model(model).at(postures)
    assert (found.status == 0).all()
    return {
        name: deflection(found.lower, load.wrench) for name, load in analysis.robot.loads.items()
    }


def planar(model: Model, load: str) -> Array:
    d = curves(model)[load]
    return np.asarray(np.hypot(d[0], d[1]))


def angles() -> tuple[Array, Array]:
    """Angles of both legs at X from the lengths alone: legs point up from their sliders."""
    return np.arccos(X / L1), np.arccos((X - A) / L2)


def test_the_workspace_ends_where_a_leg_lies_across() -> None:
    # Section 2.1; the right end is L1, not the L1 - a of the captions.
    workspace = biglide().workspace.ranges["x"]
    assert workspace == pytest.approx((A - L2, L1))
    # d = L1 + L2 - a, section 2.3.
    assert workspace[1] - workspace[0] == pytest.approx(L1 + L2 - A)
    analysis = Analysis(biglide())
    beyond = np.array([[A - L2, L1, A - L2 - 1e-6, L1 + 1e-6], [0.0] * 4])
    assert analysis.kinematics.solve(beyond).reached.tolist() == [True, True, False, False]


def test_simplified_model_is_equation_1_with_the_jacobian_in_closed_form() -> None:
    # From P = (L_i cos phi_i, y_i + L_i sin phi_i): dy_i = dy + dx cot(phi_i).
    for n, (phi1, phi2) in enumerate(zip(*angles(), strict=True)):
        inverse = np.array([[1 / np.tan(phi1), 1.0], [1 / np.tan(phi2), 1.0]])
        J = np.linalg.inv(inverse)
        k = J @ J.T / DRIVE
        for load, column in (("f_x", 0), ("f_y", 1)):
            expected = FORCE * k[:, column]
            assert curves("simplified")[load][:2, n] == pytest.approx(expected, rel=1e-9)
    # "the vibrations along z axis are not considered" (section 3.1), nor are deflections.
    assert not curves("simplified")["f_z"].any()


def leg_stiffness(compliances: list[Array], passive: Array) -> Array:
    """Equations 3 and 8: the 6x6 block of the inverse of [[S, Jq], [Jq^T, 0]]."""
    S, q = sum(compliances), passive.shape[1]
    full = np.block([[S, passive], [passive.T, np.zeros((q, q))]])
    return np.linalg.inv(full)[:6, :6]


def moved(k: Array, angle: float, arm: Array) -> Array:
    """A compliance turned about z, and read ``arm`` (3,) away from where it is given."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.kron(np.eye(2), np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
    X_shift = np.eye(6)
    X_shift[:3, 3:] = -skew(arm)
    return np.asarray(X_shift @ R @ k @ R.T @ X_shift.T)


def test_refined_model_is_equations_3_to_9() -> None:
    robot = biglide()
    k = {name: link.compliance for name, link in robot.links.items()}
    assert all(matrix is not None for matrix in k.values())
    loads = np.array([load.wrench for load in robot.loads.values()])
    drive = np.zeros((6, 6))
    drive[1, 1] = 1.0 / DRIVE
    for n, phi in enumerate(zip(*angles(), strict=True)):
        if n % 20:
            continue
        K = np.zeros((6, 6))
        for i, (L, angle) in enumerate(zip((L1, L2), phi, strict=True), start=1):
            arm = L * np.array([np.cos(angle), np.sin(angle), 0.0])
            hinge = np.array([-arm[1], arm[0], 0, 0, 0, 1.0])
            at_P = np.array([0, 0, 0, 0, 0, 1.0])
            passive = np.stack([hinge] if i == 1 else [hinge, at_P], axis=1)
            foot, leg = k[f"foot_{i}"], k[f"leg_{i}"]
            assert foot is not None
            assert leg is not None
            K += leg_stiffness(
                [drive, moved(foot, 0.0, arm), moved(leg, angle, np.zeros(3))], passive
            )
        expected = np.linalg.solve(K, loads.T)
        actual = np.stack([curves("refined")[name][:, n] for name in robot.loads], axis=1)
        assert np.abs(actual - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("load", ["f_x", "f_y"])
def test_planar_deflections_are_about_ten_times_those_of_the_simplified_model(load: str) -> None:
    # Section 2.2: "the planar deformations are about 10 times larger than with the simplified
    # model". Over the middle nine tenths of the workspace; at its ends the two part.
    inner = slice(15, -15)
    ratio = planar("refined", load)[inner] / planar("simplified", load)[inner]
    assert np.median(ratio) == pytest.approx(10.0, abs=1.0)
    assert ratio.min() > 6.0
    assert ratio.max() < 15.0


def test_z_deflections_are_about_three_times_the_planar_ones() -> None:
    # Section 2.2: "the deformations along z axis are 3 times larger than those along x and y axes".
    z = np.abs(curves("refined")["f_z"][2])
    largest = max(planar("refined", "f_x").max(), planar("refined", "f_y").max())
    assert z.max() / largest == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize(("load", "at_least"), [("f_x", 0.98), ("f_y", 0.70)])
def test_the_curves_keep_the_same_profile(load: str, at_least: float) -> None:
    # Section 2.2: "However, the curves keep the same profile." Under f_y both are a valley (see
    # below), but the refined one is steeper to the left, where leg 2 lies across; correlation 0.71.
    profile = np.corrcoef(planar("refined", load), planar("simplified", load))[0, 1]
    assert profile > at_least


@pytest.mark.parametrize("model", ["simplified", "refined"])
def test_shape_of_the_curves(model: Model) -> None:
    # Figures 3 and 5: under f_x the deflection has its maximum inside the workspace and falls to
    # both ends; under f_y it has its minimum inside and rises to both ends.
    x, y = planar(model, "f_x"), planar(model, "f_y")
    peak, valley = int(np.argmax(x)), int(np.argmin(y))
    third = len(X) // 3
    assert third < peak < 2 * third
    assert third < valley < 2 * third
    assert (np.diff(x[:peak]) > 0).all()
    assert (np.diff(x[peak:]) < 0).all()
    assert y[0] > 1.5 * y[valley]
    assert y[-1] > 1.5 * y[valley]


def test_z_deflection_hardly_depends_on_the_posture() -> None:
    # Figure 5, dashed: the feet and legs bend out of the plane alike everywhere.
    z = np.abs(curves("refined")["f_z"][2])
    assert z.max() / z.min() < 1.1
