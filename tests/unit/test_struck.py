"""Passive joints as eq. 25 of Briot 2009 prints them, against condensed ones."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.errors import PoseError
from stiffkit.link import MATERIALS, beam_compliance, beam_line, rectangle
from stiffkit.link.superelement import Struck, lumped_superelement
from stiffkit.robot import load_robot
from stiffkit.spatial import twist_shift
from stiffkit.study import analyse_modes
from stiffkit.vibration import struck_robot

Array = NDArray[np.float64]

RZ = np.array([[0.0], [0.0], [0.0], [0.0], [0.0], [1.0]])


def test_a_spring_with_a_row_struck_out_is_equation_25() -> None:
    """The tip of a link of three bodies whose first spring is beside a joint at its base."""
    length = 0.4
    line = beam_line(length, rectangle(0.02, 0.03), MATERIALS["steel"], 2.0)
    element = lumped_superelement(line, 3, None, Struck(RZ, np.zeros((6, 0))))
    piece = beam_compliance(length / 2.0, rectangle(0.02, 0.03), MATERIALS["steel"])
    to_middle = shift(-length / 4.0)
    S = to_middle @ piece @ to_middle.T
    keep = np.diag([1.0, 1, 1, 1, 1, 0])
    K_R = keep @ np.linalg.inv(S) @ keep  # eq. 25
    first, second = shift(3.0 * length / 4.0), shift(length / 4.0)
    expected = first @ np.linalg.pinv(K_R) @ first.T + second @ S @ second.T
    np.testing.assert_allclose(element.compliance, expected, rtol=1e-8, atol=1e-16)
    assert "eq. 25" in element.rule


def shift(a: float) -> Array:
    """Carry a twist by ``a`` along x."""
    return twist_shift(np.array([a, 0.0, 0.0]))


@pytest.mark.parametrize("name", ["five-bar", "delta"])
def test_struck_springs_are_stiffer_and_the_more_elements_the_less(name: str) -> None:
    condensed = analyse_modes(load_robot(name), model="lumped").frequencies_hz
    errors = []
    for n_elements in (4, 7, 12):
        struck = analyse_modes(load_robot(name), model="lumped-eq25", n_elements=n_elements)
        same = analyse_modes(load_robot(name), model="lumped", n_elements=n_elements)
        ratio = struck.frequencies_hz / same.frequencies_hz
        assert (ratio > 1.0 - 1e-9).all()
        errors.append(float(np.max(ratio - 1.0)))
    assert errors[0] > errors[1] > errors[2] > 0.0
    assert condensed.size == 4


def test_a_joint_strikes_one_spring_only() -> None:
    """The elbow strikes the rod and not the arm, the wrist only the right rod."""
    robot, plain = struck_robot(load_robot("five-bar"), 20), load_robot("five-bar")
    softness = {}
    for name in ("left_arm", "left_rod", "right_rod"):
        before, after = plain.links[name].compliance, robot.links[name].compliance
        assert before is not None
        assert after is not None
        softness[name] = after[1, 1] / before[1, 1]
    assert softness["left_arm"] == pytest.approx(1.0, abs=1e-9)
    assert softness["right_rod"] < softness["left_rod"] < 0.999


def test_too_few_elements_are_refused() -> None:
    with pytest.raises(PoseError, match="too few"):
        analyse_modes(load_robot("five-bar"), model="lumped-eq25", n_elements=3)


def test_it_is_labelled() -> None:
    found = analyse_modes(load_robot("biglide"), model="lumped-eq25")
    assert found.model == "lumped-eq25"
    assert "eq. 25" in found.rules["leg_1"]
    assert "equivalent beam's" in found.rules["leg_1"]
    assert "eq. 25" not in analyse_modes(load_robot("biglide"), model="lumped").rules["leg_1"]
