"""The appendix of Briot, Pashkevich and Chablat (2009) as printed: three of its matrices are wrong.

S. Briot, A. Pashkevich, D. Chablat, "On the optimal design of parallel robots taking into account
their deformations and natural frequencies", ASME IDETC/CIE 2009.
"""

import numpy as np
import pytest

from stiffkit.link import check_compliance, check_inertia, doubts_compliance, symmetrize
from stiffkit.spatial.rotation import Array

K_FOOT = np.array(
    [
        [1.67e-10, 8.85e-13, -7.78e-14, -2.12e-13, 7.95e-12, 2.50e-12],
        [8.85e-13, 5.87e-9, 6.39e-12, -3.58e-11, -2.12e-11, 3.94e-8],
        [-7.78e-14, 6.39e-12, 5.53e-10, 1.35e-11, -4.49e-9, 1.91e-11],
        [-2.12e-13, -3.58e-11, 1.35e-11, 6.96e-8, 5.28e-11, -2.71e-10],
        [7.95e-12, -2.12e-11, -4.49e-9, 5.28e-11, 8.48e-8, 7.40e-9],
        [2.50e-12, 3.94e-8, 1.91e-11, -2.71e-10, 7.40e-9, 3.16e-9],
    ]
)
K_LEG1 = np.array(
    [
        [2.81e-9, -1.01e-8, -1.41e-9, -1.81e-9, 4.42e-9, 2.92e-8],
        [-1.01e-8, 1.77e-7, -1.83e-9, -2.03e-9, 2.93e-9, -2.90e-7],
        [-1.41e-9, -1.83e-9, 3.19e-8, 4.77e-8, -9.94e-8, -2.27e-9],
        [-1.81e-9, -2.03e-9, 4.77e-8, 1.73e-7, -8.02e-8, -1.18e-9],
        [4.42e-9, 2.93e-9, -9.94e-8, -8.02e-8, 8.13e-7, 3.23e-8],
        [2.92e-8, -2.90e-7, -2.27e-9, -1.18e-9, 3.23e-8, 6.08e-7],
    ]
)
K_LEG2 = np.array(
    [
        [2.71e-10, 1.29e-10, -1.99e-10, 4.68e-9, 1.73e-9, -7.06e-11],
        [1.29e-10, 1.26e-8, -3.88e-13, 1.84e-10, 1.67e-8, -2.12e-8],
        [-1.99e-10, -3.88e-13, 1.07e-9, -1.03e-8, -2.38e-10, 3.71e-13],
        [4.68e-9, 1.84e-10, -1.03e-8, 2.52e-7, 3.62e-9, 4.54e-10],
        [1.73e-9, 1.67e-8, -2.38e-10, 3.62e-9, 7.22e-7, 3.95e-8],
        [-7.06e-11, -2.12e-8, 3.71e-13, 4.54e-10, 3.95e-8, 1.70e-7],
    ]
)
K_TOOL = np.array(
    [
        [1.16e-9, -9.70e-11, -1.33e-11, 6.88e-9, 4.89e-8, -2.64e-9],
        [9.70e-11, 1.33e-9, -1.15e-10, -5.91e-8, -7.11e-9, 1.96e-11],
        [-1.33e-11, -1.15e-10, 5.53e-10, 2.30e-9, 6.52e-10, 2.00e-10],
        [6.88e-9, -5.91e-8, 2.30e-9, 3.77e-6, 4.23e-7, -2.87e-8],
        [4.89e-8, -7.11e-9, 6.52e-10, 4.23e-7, 3.15e-6, -6.94e-8],
        [-2.64e-9, 1.96e-11, 2.00e-10, -2.87e-8, -6.94e-8, 3.29e-6],
    ]
)
J_FOOT = np.diag([0.268, 0.211, 0.261])
J_LEG1 = np.array([[1.187, -0.164, -1.247], [-0.164, 3.022, -0.940], [-1.247, -0.940, 2.646]])
J_LEG2 = np.array([[6.122, 0.014, 0.312], [0.014, 5.848, -0.314], [0.312, -0.314, 0.635]])


@pytest.mark.parametrize("k", [K_LEG1, K_LEG2], ids=["leg 1", "leg 2"])
def test_compliances_of_the_legs_can_stand(k: Array) -> None:
    assert check_compliance(k) == []
    assert doubts_compliance(k) == []


def test_foot_is_indefinite_because_66_is_too_small() -> None:
    assert check_compliance(K_FOOT) == [
        "not positive definite: entries 2,2 = 5.87e-09, 6,6 = 3.16e-09 and 2,6 = 3.94e-08 cannot "
        "stand together: |k26| must stay below sqrt(k22 k66) = 4.31e-09, or k22 above 4.91e-07, "
        "or k66 above 2.64e-07; correct the wrong entry"
    ]


def test_foot_stands_when_66_is_a_hundred_times_larger() -> None:
    k = K_FOOT.copy()
    k[5, 5] = 3.16e-7
    assert check_compliance(k) == []


def test_tool_has_two_signs() -> None:
    assert check_compliance(K_TOOL) == [
        "not symmetric: entry 1,2 = -9.7e-11 and entry 2,1 = 9.7e-11 do not agree; one has the "
        "wrong sign: correct it (symmetrize would make both zero)"
    ]
    assert check_compliance(symmetrize(K_TOOL)) == []


def test_foot_and_leg_2_are_bodies() -> None:
    assert check_inertia(1.0, J_FOOT) == []
    assert check_inertia(49.366, J_LEG2) == []


def test_leg_1_is_no_body_because_of_23() -> None:
    assert check_inertia(69.705, J_LEG1) == [
        "no body has the principal moments 0.324, 2.54 and 3.99 kg m^2: the largest exceeds the "
        "sum of the others by 1.12; entry 2,3 = -0.94 is too large for this diagonal, which "
        "allows at most 0.563"
    ]


def test_leg_1_is_a_body_when_the_point_of_23_moves() -> None:
    J = J_LEG1.copy()
    J[1, 2] = J[2, 1] = -0.094
    assert check_inertia(69.705, J) == []
