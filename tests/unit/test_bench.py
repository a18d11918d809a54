"""The benchmarks: what is counted, what is compared, how tables read."""

from __future__ import annotations

import math

import numpy as np
import pytest
from benchmarks.operations import Operations, operations
from benchmarks.peers import case, ours
from benchmarks.table import table

from stiffkit.kinematics import Kinematics
from stiffkit.stiffness import Stiffness, full_matrices


def test_operations_are_counted_once_each() -> None:
    heyoka = pytest.importorskip("heyoka")
    x, y = heyoka.make_vars("x", "y")
    shared = x * y
    outputs = [
        shared + heyoka.sin(x),
        shared - heyoka.sqrt(y),
        1.0 / x,
        heyoka.select(heyoka.lt(x, y), x, -y),
        heyoka.acos(x),
    ]
    counted = operations(heyoka.cfunc(outputs, [x, y]))
    assert counted == Operations(arithmetic=5, functions=2, divisions=2)


def test_an_unknown_step_is_not_passed_over() -> None:
    heyoka = pytest.importorskip("heyoka")
    (x,) = (heyoka.make_vars("x"),)
    with pytest.raises(ValueError, match="exp"):
        operations(heyoka.cfunc([heyoka.exp(x)], [x]))


def test_columns_of_numbers_are_aligned_to_the_right() -> None:
    lines = table(("name", "rate"), [("a", 1234.5), ("long name", 0.5)]).splitlines()
    assert lines == ["name       rate", "a          1234", "long name   0.5"]


def test_the_task_of_the_peers_is_a_mechanism() -> None:
    for posture in case.postures(5):
        for (x, y), length in zip(posture.sliders, case.LENGTHS, strict=True):
            assert math.hypot(posture.x - x, posture.y - y) == pytest.approx(length)
            assert x in (0.0, case.A)
        assert posture.nodes(0, 4)[-1] == pytest.approx((posture.x, posture.y))


def test_our_robot_is_that_of_the_task() -> None:
    kinematics = Kinematics(ours.robot())
    posture = case.postures(3)[0]
    postures = kinematics.solve(np.array([[posture.x], [posture.y]]))
    names = kinematics.joint_names
    for name, (_, y) in zip(("slide_1.y", "slide_2.y"), posture.sliders, strict=True):
        assert postures.joints[names.index(name), 0] == pytest.approx(y)
    k = full_matrices(Stiffness(kinematics).at(postures).lower)[:3, :3, 0]
    # In the plane the legs are bars between hinges, each in series with its drive.
    bars = np.zeros((2, 2))
    for (x, y), length in zip(posture.sliders, case.LENGTHS, strict=True):
        u = np.array([posture.x - x, posture.y - y]) / length
        flexibility = length / (case.E_MODULUS * case.AREA) + u[1] ** 2 / case.DRIVE
        bars += np.outer(u, u) / flexibility
    np.testing.assert_allclose(k[:2, :2], np.linalg.inv(bars), rtol=1e-9)
