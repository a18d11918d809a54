"""Links of robot files that follow a parameter: ``compliance: {scale: ...}``."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from stiffkit.errors import FileError
from stiffkit.link.stretch import Stretch
from stiffkit.robot import Robot, RobotFile, load_robot

Array = NDArray[np.float64]
Load = Callable[..., Robot]

TEXT = """
robot: Test
parameters: {{alpha: 1, L: = alpha * 300 mm}}
links:
  part:
    compliance:
      {ports}
      {scale}
      matrix: {matrix}
    mass: 2 kg
    center_of_mass: [100 mm, 10 mm, 0]
    inertia: [[0.01, 0, 0], [0, 0.02, 0], [0, 0, 0.02]]
joints: {{hold: {{fixed: true, from: base, to: part}}}}
tool: {{at: part}}
"""
MATRIX = (
    "[[2e-8,0,0,0,0,0],[0,3e-6,0,0,0,1e-5],[0,0,4e-6,0,-1e-5,0],[0,0,0,5e-5,0,0],"
    "[0,0,-1e-5,0,6e-5,0],[0,1e-5,0,0,0,7e-5]]"
)
SCALE = "scale: {reference: 300 mm, rule: constant-section}"


def close(actual: ArrayLike | None, expected: Array) -> None:
    assert actual is not None
    np.testing.assert_allclose(np.asarray(actual), expected, rtol=1e-14)


def text(ports: str = "length: = L", scale: str = SCALE, matrix: str = MATRIX) -> str:
    return TEXT.format(ports=ports, scale=scale, matrix=matrix)


@pytest.mark.parametrize("rule", ["equivalent-beam", "constant-section"])
@pytest.mark.parametrize("ports", ["length: = L", "tip: {at: [0, 0, = L], rotate: {z: 30 deg}}"])
def test_everything_follows_the_length(load: Load, rule: str, ports: str) -> None:
    written = text(ports, SCALE.replace("constant-section", rule))
    plain = load(text(ports, "")).links["part"]
    robot = load(written.replace("alpha: 1,", "alpha: 1.5,"))
    part = robot.links["part"]
    tip = part.ports["tip"].position
    assert np.linalg.norm(tip) == pytest.approx(0.45)
    by = Stretch(tip, 0.3, "equivalent-beam" if rule == "equivalent-beam" else "constant-section")
    assert plain.compliance is not None
    assert plain.center_of_mass is not None
    assert plain.inertia is not None
    close(part.compliance, by.compliance(plain.compliance))
    assert part.mass == pytest.approx(3.0)
    close(part.center_of_mass, by.point(plain.center_of_mass))
    close(part.inertia, by.inertia(plain.inertia))
    (note,) = robot.notes
    assert note.startswith("links.part: given at 0.3 m")
    assert "0.45 m long" in note


def test_at_the_reference_length_nothing_is_said_and_nothing_changes(load: Load) -> None:
    robot, plain = load(text()), load(text(scale=""))
    assert robot.notes == ()
    np.testing.assert_array_equal(
        np.asarray(robot.links["part"].compliance), np.asarray(plain.links["part"].compliance)
    )


def test_a_link_without_mass_stays_without(load: Load) -> None:
    bare = "\n".join(
        line
        for line in text().replace("alpha: 1,", "alpha: 2,").splitlines()
        if not line.lstrip().startswith(("mass", "center", "inertia"))
    )
    part = load(bare).links["part"]
    assert (part.mass, part.center_of_mass, part.inertia) == (None, None, None)


@pytest.mark.parametrize(
    ("written", "told"),
    [
        (text("tip: {at: [0, 0, 0]}"), "the tip lies at the base"),
        (text(scale="scale: {reference: 0, rule: constant-section}"), "must be positive"),
        (text(scale="scale: {reference: 2 kg, rule: constant-section}"), "kg"),
        (text(scale="scale: {reference: 1 m, rule: constant-sections}"), "constant-section"),
        (text(scale="scale: {reference: 1 m}"), "rule"),
        (text(scale="scale: {rule: equivalent-beam}"), "reference"),
        (text(scale="scale: {reference: 1 m, rule: equivalent-beam, at: 1}"), "at"),
    ],
)
def test_wrong_scales(load: Load, written: str, told: str) -> None:
    with pytest.raises(FileError) as caught:
        load(written)
    assert told in str(caught.value)
    assert "scale" in str(caught.value)


def test_several_ports_have_no_one_length(load: Load) -> None:
    rows = np.kron(np.eye(2), np.diag([1e-8, 1e-6, 1e-6, 1e-5, 1e-5, 1e-5])).tolist()
    ports = "ports: {left: {at: [= L, 0, 0]}, right: {at: [= -L, 0, 0]}}"
    with pytest.raises(FileError, match=r"the ports left and right has no one length"):
        load(text(ports, matrix=str(rows)))


def test_only_what_depends_on_the_parameter_is_read_again() -> None:
    file = RobotFile("biglide-scaled")
    one, other = (file.robot({"alpha": alpha}) for alpha in (1.0, 1.2))
    assert one.links["foot_1"] is other.links["foot_1"]
    assert one.links["leg_1"] is not other.links["leg_1"]


@pytest.mark.parametrize("name", ["biglide-scaled", "biglide-beams"])
@pytest.mark.parametrize("alpha", [0.7, 1.0, 1.8])
def test_the_stroke_of_the_scaled_biglides_stays(name: str, alpha: float) -> None:
    robot = load_robot(name, {"alpha": alpha})
    low, high = robot.workspace.ranges["x"]
    assert high - low == pytest.approx(0.85 + 0.775 - 0.92)
    for leg, length, mass in (("leg_1", 0.85, 69.705), ("leg_2", 0.775, 49.366)):
        link = robot.links[leg]
        np.testing.assert_allclose(link.ports["tip"].position, [alpha * length, 0.0, 0.0])
        assert link.mass == pytest.approx(alpha * mass)


def test_at_alpha_1_the_scaled_biglide_is_the_machine() -> None:
    machine, scaled = load_robot("biglide"), load_robot("biglide-scaled")
    for name, link in machine.links.items():
        other = scaled.links[name]
        np.testing.assert_array_equal(np.asarray(link.compliance), np.asarray(other.compliance))
        np.testing.assert_array_equal(np.asarray(link.inertia), np.asarray(other.inertia))
        assert link.mass == other.mass
    for name, joint in machine.joints.items():
        np.testing.assert_allclose(
            joint.T_from_joint.position, scaled.joints[name].T_from_joint.position, atol=1e-15
        )
        np.testing.assert_array_equal(joint.stiffness, scaled.joints[name].stiffness)
    assert machine.workspace.ranges["x"] == pytest.approx(scaled.workspace.ranges["x"])
