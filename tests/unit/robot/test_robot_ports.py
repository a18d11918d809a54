"""Elastic links with more than two ports in robot files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.errors import FileError
from stiffkit.link import MATERIALS, beam_compliance, round_bar
from stiffkit.robot import Robot, load_robot
from stiffkit.study import analyse_pose, summarise

Array = NDArray[np.float64]
Load = Callable[[str], Robot]

BEAM = beam_compliance(0.1, round_bar(0.02), MATERIALS["steel"])


def yoke() -> Array:
    """Return the compliance of two beams from one base: along x, and turned by 90 deg about z."""
    turn = np.kron(np.eye(2), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    k = np.zeros((12, 12))
    k[:6, :6], k[6:, 6:] = BEAM, turn @ BEAM @ turn.T
    return k


ROBOT = f"""\
robot: Yoke
links:
  yoke:
    compliance:
      ports:
        arm: {{at: [100 mm, 0, 0]}}
        side: {{at: [0, 100 mm, 0], rotate: {{z: 90 deg}}}}
      matrix: {yoke().tolist()}
    mass: 2 kg
  hand: {{rigid: {{length: 50 mm}}, mass: 1 kg}}
joints:
  root: {{fixed: true, from: base, to: yoke}}
  spring:
    spherical: true
    from: base
    at: [0, 100 mm, 0]
    to: yoke.side
    elastic: {{x: 1e6 N/m}}
  wrist: {{revolute: z, from: yoke.arm, to: hand, drive: 1e4 N m/rad}}
tool: {{at: hand.tip}}
"""


@pytest.fixture
def load(tmp_path: Path) -> Load:
    def write_and_load(text: str) -> Robot:
        path = tmp_path / "robot.yaml"
        path.write_text(text, encoding="utf-8")
        return load_robot(path)

    return write_and_load


def test_joints_attach_to_any_port(load: Load) -> None:
    robot = load(ROBOT)
    link = robot.links["yoke"]
    assert list(link.ports) == ["base", "arm", "side"]
    assert link.other_ports == ("arm", "side")
    np.testing.assert_allclose(link.ports["side"].rotation[:, 0], [0.0, 1.0, 0.0], atol=1e-15)
    assert link.compliance is not None
    np.testing.assert_array_equal(link.compliance, yoke())
    assert (robot.joints["wrist"].from_port, robot.joints["spring"].to_port) == ("arm", "side")


def test_the_general_assembly_takes_them_and_check_says_so(load: Load) -> None:
    robot = load(ROBOT)
    assert dict(summarise(robot).facts)["stiffness, refined"].startswith("general assembly")
    # The arm bends as a beam of 100 mm, whatever is done to the side: the base is held.
    arm = np.eye(6)
    arm[1, 5], arm[2, 4] = 0.05, -0.05
    drive = np.zeros((6, 6))
    drive[5, 5] = 1e-4
    expected = arm @ (BEAM + drive) @ arm.T
    size = np.sqrt(np.diag(expected))
    found = np.array(analyse_pose(robot).compliance)
    np.testing.assert_allclose(
        found / np.outer(size, size), expected / np.outer(size, size), atol=1e-9
    )


@pytest.mark.parametrize(
    ("old", "new", "key", "told"),
    [
        ("to: yoke.side", "to: yoke.sides", "joints.spring.to", "did you mean 'side'"),
        ("yoke.arm, to", "yoke.tip, to", "joints.wrist.from", "has no port 'tip'"),
        ("side: {at", "base: {at", "links.yoke.compliance.ports.base", "which is held"),
        ("      ports:", "      length: 1\n      ports:", "links.yoke.compliance", "both given"),
        (
            "        side: {at: [0, 100 mm, 0], rotate: {z: 90 deg}}\n",
            "",
            "matrix",
            "6 are expected",
        ),
    ],
)
def test_ports_that_do_not_fit(load: Load, old: str, new: str, key: str, told: str) -> None:
    assert ROBOT.count(old) == 1
    with pytest.raises(FileError) as caught:
        load(ROBOT.replace(old, new))
    assert key in caught.value.key
    assert told in str(caught.value)


def test_a_copy_has_the_same_ports(load: Load) -> None:
    text = ROBOT.replace("  hand:", "  other: {like: yoke}\n  hand:").replace(
        "  wrist:", "  weld: {fixed: true, from: yoke.side, to: other.side}\n  wrist:"
    )
    assert load(text).links["other"].other_ports == ("arm", "side")
