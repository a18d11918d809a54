"""What the literature says of the catalogue's robots: degrees of freedom, isotropy, softness."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from stiffkit.robot import describe_robots, load_robot
from stiffkit.stiffness import full_matrices
from stiffkit.study import Analysis, analyse_modes, analyse_pose
from stiffkit.study.grid import pose_grid
from stiffkit.study.map import postures_of


class Expected(NamedTuple):
    """Kutzbach's count, degrees of freedom, of them idle, and what the tool can be asked for."""

    counted: int
    mobility: int
    idle: int
    asked: str


# Kutzbach's count is 6 bodies - sum of what the joints block; the degree of over-constraint is what
# the true mobility exceeds it by. Three revolutes or more that are parallel, or meet in a point,
# block three directions more often than needed for each loop.
MOBILITY = {
    "3-puu": Expected(3, 3, 0, "x y z"),
    # Three loops of ball joints: each rod may spin (R. Clavel, 1988).
    "delta": Expected(9, 9, 6, "x y z"),
    "five-bar": Expected(-1, 2, 0, "x y"),
    "biglide": Expected(-1, 2, 0, "x y"),
    "biglide-beams": Expected(-1, 2, 0, "x y"),
    "biglide-elastic-tool": Expected(-1, 2, 0, "x y"),
    "biglide-scaled": Expected(-1, 2, 0, "x y"),
    "hexapod-cubic": Expected(6, 6, 0, "x y z rx ry rz"),
    # PRPaR legs: each keeps two rotations, three more than six in all, and each of the three planar
    # parallelograms has three of its own (A. Pashkevich et al., 2009, call it over-constrained).
    "orthoglide": Expected(-9, 3, 0, "x y z"),
    "orthoglide-table-7": Expected(-9, 3, 0, "x y z"),
    "orthoglide-multi-beam": Expected(-9, 3, 0, "x y z"),
    # Each PRRR leg keeps two rotations (X. Kong, C. Gosselin, "Type Synthesis of Parallel
    # Mechanisms", Springer, 2007).
    "tripteron": Expected(0, 3, 0, "x y z"),
    # Planar, two loops with three excess constraints each (J.-P. Merlet, Parallel Robots).
    "3-rrr": Expected(-3, 3, 0, "x y rz"),
    # Not over-constrained: each leg keeps one rotation (L.-W. Tsai, 1996).
    "3-upu": Expected(3, 3, 0, "x y z"),
    "gough-stewart": Expected(6, 6, 0, "x y z rx ry rz"),
    # Three of the parallel module and three of the wrist.
    "tricept": Expected(6, 6, 0, "x y z rx ry rz"),
    "serial-6r": Expected(6, 6, 0, "x y z rx ry rz"),
    # Spherical, three excess constraints in each of two loops (C. Gosselin, J.-F. Hamel, 1994).
    "agile-eye": Expected(-3, 3, 0, "rx ry rz"),
}
NEW = ["orthoglide", "orthoglide-multi-beam", "orthoglide-table-7", "tripteron", "3-rrr", "3-upu"]
NEW += ["gough-stewart", "tricept", "serial-6r", "agile-eye"]


@pytest.mark.parametrize("name", [robot.name for robot in describe_robots() if not robot.from_cad])
def test_degrees_of_freedom(name: str) -> None:
    kinematics = Analysis(load_robot(name)).kinematics
    mobility, expected = kinematics.mobility, MOBILITY[name]
    assert mobility.counted == expected.counted
    assert mobility.numeric == expected.mobility
    assert mobility.over_constraint == expected.mobility - expected.counted
    assert mobility.idle == expected.idle
    assert mobility.tool == expected.mobility - expected.idle
    assert kinematics.asked == tuple(expected.asked.split())


@pytest.mark.parametrize("name", NEW)
def test_the_workspace_is_reached_and_the_robot_is_a_machine(name: str) -> None:
    analysis = Analysis(load_robot(name))
    postures = postures_of(analysis, pose_grid(analysis.robot, 60))
    found = analysis.refined.at(postures)
    assert np.mean(found.status == 0) >= 0.95
    assert analysis.robot.loads
    # No link without mass, and a frequency that a machine of this kind has.
    assert not [link.name for link in analysis.robot.links.values() if not link.mass]
    frequencies = analyse_modes(analysis.robot, n=4).frequencies_hz
    assert 10.0 < frequencies[0] < 150.0
    assert np.isfinite(frequencies).all()
    # N/m, in the weakest direction at home.
    home = analyse_pose(analysis.robot)
    assert home.translation is not None
    assert 2e4 < home.translation.stiffness[0] < 5e7
    assert home.free_motions == ()


def test_a_tripteron_is_isotropic_everywhere() -> None:
    """X. Kong, C. Gosselin, 2007: its Jacobian is the identity, whatever the posture."""
    analysis = Analysis(load_robot("tripteron"))
    postures = postures_of(analysis, pose_grid(analysis.robot, 60))
    found = full_matrices(analysis.simplified.at(postures).lower)
    drive = analysis.robot.parameters["drive"].value
    expected = np.eye(3)[..., None] / drive
    assert np.abs(found[:3, :3] - expected).max() < 1e-9 / drive
    assert np.abs(postures.tool[3:]).max() < 1e-9


def test_an_agile_eye_is_isotropic_at_home() -> None:
    """C. Gosselin, J.-F. Hamel, 1994: at the reference posture the Jacobian is the identity."""
    analysis = Analysis(load_robot("agile-eye"))
    k = analyse_pose(analysis.robot, model="simplified").compliance
    assert k is not None
    motor = analysis.robot.parameters["motor"].value
    assert np.abs(k[3:, 3:] - np.eye(3) / motor).max() < 1e-9 / motor
    # All axes meet in the tool point, so drives alone never let it move away.
    assert np.abs(k[:3]).max() < 1e-12 / motor


@pytest.mark.parametrize("name", ["orthoglide", "tripteron", "3-upu"])
def test_translational_robots_keep_their_orientation(name: str) -> None:
    analysis = Analysis(load_robot(name))
    postures = postures_of(analysis, pose_grid(analysis.robot, 60))
    assert postures.reached.all()
    home = analysis.kinematics.home.tool[3:]
    assert np.abs(postures.tool[3:] - home).max() < 1e-9
