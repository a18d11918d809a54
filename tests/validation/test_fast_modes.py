"""The fast model of vibration against the full one, which shares no reduction with it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.robot import load_robot
from stiffkit.study import Analysis
from stiffkit.vibration import FastModes, ModalModel

Array = NDArray[np.float64]

N_RANDOM = 200
N_MODES = 4


def workspace_postures(analysis: Analysis, count: int, seed: int) -> Array:
    """Coordinates of random postures in the workspace's box."""
    kinematics = analysis.kinematics
    workspace = analysis.robot.workspace
    ranges = dict(workspace.ranges)
    if workspace.polygon is not None:
        for name, corners in zip(workspace.polygon_axes, workspace.polygon.T, strict=True):
            # The square inside a hexagon's corners.
            ranges[name] = (0.6 * float(corners.min()), 0.6 * float(corners.max()))
    home = kinematics.home.tool
    rng = np.random.default_rng(seed)
    asked = np.stack(
        [
            rng.uniform(*ranges[d], count)
            if d in ranges
            else np.full(count, home[["x", "y", "z", "rx", "ry", "rz"].index(d), 0])
            for d in kinematics.asked
        ]
    )
    postures = kinematics.solve(asked)
    assert postures.reached.all()
    return postures.coordinates


@pytest.mark.parametrize("name", ["biglide", "five-bar", "delta", "hexapod-cubic"])
def test_four_lowest_frequencies_at_200_random_postures(name: str) -> None:
    analysis = Analysis(load_robot(name))
    full = ModalModel(analysis.kinematics.tree, analysis.kinematics.length)
    fast = FastModes(full, workspace_postures(analysis, 600, seed=1), N_MODES)
    assert fast.trust.good
    q = workspace_postures(analysis, N_RANDOM, seed=2)
    exact = np.array([modes.frequencies_hz for modes in full.at_each(q, N_MODES)]).T
    error = np.abs(fast.frequencies(q) / exact - 1.0)
    worst = np.unravel_index(int(np.argmax(error)), error.shape)
    print(f"{name}: worst {error.max():.2e}, mode {worst[0] + 1}, {exact[worst]:.1f} Hz")
    assert error.max() < 1e-4
