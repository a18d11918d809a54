"""Every robot of the catalogue but those from CAD: both models by two ways, over its workspace."""

from __future__ import annotations

import numpy as np
import pytest

from stiffkit.robot import describe_robots, load_robot
from stiffkit.stiffness import full_matrices
from stiffkit.study import Analysis
from stiffkit.study.grid import pose_grid
from stiffkit.study.map import postures_of


@pytest.mark.parametrize("name", [robot.name for robot in describe_robots() if not robot.from_cad])
@pytest.mark.parametrize("model", ["refined", "simplified"])
def test_fast_path_is_the_general_assembly(name: str, model: str) -> None:
    analysis = Analysis(load_robot(name))
    kinematics = analysis.kinematics
    stiffness = analysis.refined if model == "refined" else analysis.simplified
    assert stiffness.method != "assembly"
    postures = postures_of(analysis, pose_grid(analysis.robot, 40))
    found = stiffness.at(postures)
    unit_free = np.diag([1.0 / kinematics.length] * 3 + [1.0] * 3)
    compared = 0
    for n in np.flatnonzero(found.status == 0)[:40]:
        exact = stiffness.assembly.at(postures.coordinates[:, n]).compliance
        assert exact is not None
        expected = unit_free @ exact @ unit_free
        actual = unit_free @ full_matrices(found.lower[:, [n]])[..., 0] @ unit_free
        assert np.abs(actual - expected).max() < 1e-9 * np.abs(expected).max()
        compared += 1
    assert compared > 10
