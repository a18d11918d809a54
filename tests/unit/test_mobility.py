"""Degrees of freedom of linkages that are known for them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffkit.kinematics import Kinematics
from stiffkit.robot import DIRECTIONS, Robot, load_robot

Load = Callable[..., Robot]

FOUR_BAR = """
robot: Planar four-bar linkage
links:
  crank: {rigid: {length: 0.2}}
  coupler: {rigid: {length: 0.5}}
  rocker: {rigid: {length: 0.4}}
joints:
  a: {revolute: z, from: base, to: crank.base, drive: 1e4}
  b: {revolute: z, from: crank.tip, to: coupler.base}
  c: {revolute: z, from: base, at: [0.45, 0, 0], to: rocker.base}
  d: {revolute: z, from: coupler.tip, to: rocker.tip}
tool: {at: coupler.tip}
home: {a: 60 deg}
"""

# Opposite links are equal, and lengths are as the sines of the twists.
BENNETT = """
robot: Bennett linkage
parameters: {a: 0.3 m, alpha: 40 deg, beta: 70 deg, b: = a * sin(beta) / sin(alpha)}
links:
  first: {rigid: {ports: {end: {at: [= b, 0, 0], rotate: {x: = beta}}}}}
  second: {rigid: {ports: {end: {at: [= a, 0, 0], rotate: {x: = alpha}}}}}
  third: {rigid: {ports: {end: {at: [= b, 0, 0], rotate: {x: = beta}}}}}
joints:
  j1: {revolute: z, from: base, at: [= a, 0, 0], rotate: {x: = alpha}, to: first, drive: 1e4}
  j2: {revolute: z, from: first.end, to: second}
  j3: {revolute: z, from: second.end, to: third}
  j4: {revolute: z, from: third.end, to: base}
tool: {at: second}
home: {j1: 70 deg}
"""

# Two chains of three parallel hinges, in planes at right angles; the platform goes up and down.
SARRUS = """
robot: Sarrus linkage
links:
  platform: {rigid: {ports: {}}}
repeat:
  - for: {k: [1, 2], phi: [0 deg, 90 deg]}
    links:
      "lower_{k}": {rigid: {length: 0.3}}
      "upper_{k}": {rigid: {length: 0.3}}
    joints:
      "foot_{k}": {revolute: y, from: base, rotate: {z: = phi}, to: "lower_{k}.base"}
      "knee_{k}": {revolute: y, from: "lower_{k}.tip", to: "upper_{k}.base"}
      "top_{k}": {revolute: y, from: "upper_{k}.tip", to: platform, to_rotate: {z: = phi}}
tool: {at: platform}
home: {foot_1: -40 deg, knee_1: -100 deg, foot_2: -40 deg, knee_2: -100 deg}
"""

# The outer axes of each leg are parallel, and so are the inner ones (L.-W. Tsai, 1996).
THREE_UPU = """
robot: Tsai's 3-UPU
parameters: {radius: 0.4 m}
links:
  platform: {rigid: {ports: {}}}
repeat:
  - for: {k: [1, 2, 3], phi: [0 deg, 120 deg, 240 deg]}
    links:
      "lower_{k}": {rigid: {ports: {}}}
      "upper_{k}": {rigid: {ports: {}}}
    joints:
      "foot_{k}":
        universal: [y, z]
        from: base
        at: [= radius * cos(phi), = radius * sin(phi), 0]
        rotate: {z: = phi}
        to: "lower_{k}"
      "drive_{k}": {prismatic: x, from: "lower_{k}", to: "upper_{k}", drive: 1e6}
      "top_{k}":
        universal: [z, y]
        from: "upper_{k}"
        to: platform
        to_at: [= radius / 2 * cos(phi), = radius / 2 * sin(phi), 0]
        to_rotate: {z: = phi}
tool: {at: platform}
home: {x: 0.05, y: 0.03, z: 0.6}
"""

SEVEN_HINGES = (
    "robot: Redundant arm\nlinks: {"
    + ", ".join(f"l{i}: {{rigid: {{length: 0.2}}}}" for i in range(7))
    + "}\njoints:\n  j0: {revolute: z, from: base, to: l0.base, drive: 1e4}\n"
    + "".join(
        f"  j{i}: {{revolute: {'zyx'[i % 3]}, from: l{i - 1}.tip, to: l{i}.base, drive: 1e4}}\n"
        for i in range(1, 7)
    )
    + "tool: {at: l6.tip}\nhome: {"
    + ", ".join(f"j{i}: {0.3 + 0.2 * i}" for i in range(7))
    + "}\n"
)


def spinning_hexapod() -> str:
    """Return the catalogue's hexapod with ball joints at both ends of each leg."""
    source = load_robot("hexapod-cubic").source
    assert source is not None
    text = Path(source).read_text(encoding="utf-8")
    assert "universal: [y, z]" in text
    return text.replace("universal: [y, z]", "spherical: true")


@pytest.mark.parametrize(
    ("text", "bodies", "loops", "counted", "numeric", "tool", "idle"),
    [
        (FOUR_BAR, 3, 1, -2, 1, 1, 0),
        (BENNETT, 3, 1, -2, 1, 1, 0),
        (SARRUS, 5, 1, 0, 1, 1, 0),
        (THREE_UPU, 7, 2, 3, 3, 3, 0),
        (SEVEN_HINGES, 7, 0, 7, 7, 6, 0),
        (spinning_hexapod(), 13, 5, 12, 12, 6, 6),
    ],
    ids=["four-bar", "Bennett", "Sarrus", "3-UPU", "7R", "6-SPS"],
)
def test_mobility_of_known_linkages(
    robot_of: Load,
    text: str,
    bodies: int,
    loops: int,
    counted: int,
    numeric: int,
    tool: int,
    idle: int,
) -> None:
    mobility = Kinematics(robot_of(text)).mobility
    assert (mobility.n_bodies, mobility.n_loops) == (bodies, loops)
    assert (mobility.counted, mobility.numeric) == (counted, numeric)
    assert (mobility.tool, mobility.idle) == (tool, idle)
    assert mobility.over_constraint == numeric - counted


def test_a_bennett_linkage_moves_as_bennett_says(robot_of: Load) -> None:
    """G. T. Bennett, Engineering 76, 1903: how angles of neighbouring hinges go together."""
    kinematics = Kinematics(robot_of(BENNETT))
    (name,) = kinematics.asked
    start = kinematics.home.tool[DIRECTIONS.index(name), 0]
    found = kinematics.solve((start + np.linspace(-0.05, 0.05, 7))[None])
    assert found.reached.all()
    alpha, beta = np.radians([40.0, 70.0])
    ratio = np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)
    j1, j2 = (found.joints[kinematics.joint_names.index(f"j{i}.rz")] for i in (1, 2))
    np.testing.assert_allclose(np.abs(np.tan(j1 / 2) * np.tan(j2 / 2)), ratio, rtol=1e-7)


def test_a_sarrus_linkage_moves_straight(robot_of: Load) -> None:
    kinematics = Kinematics(robot_of(SARRUS))
    home = kinematics.home.tool[:, 0]
    assert kinematics.asked == ("z",)
    found = kinematics.solve((home[2] + np.linspace(-0.1, 0.05, 7))[None])
    assert found.reached.all()
    others = np.delete(found.tool, 2, axis=0)
    np.testing.assert_allclose(others, np.repeat(others[:, :1], 7, axis=1), atol=1e-9)
