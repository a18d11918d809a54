"""Modes followed over the workspace against the full model's shapes, which know no neighbours.

Briot, Pashkevich, Chablat, "On the optimal design of parallel robots taking into account their
deformations and natural frequencies", ASME IDETC/CIE 2009, figures 10 and 11: the Biglide's first
mode is bending along z, its second one is planar. The two kinds hardly mix at any posture, so that
the direction of the tool's motion says which is which.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from stiffkit.robot import Robot, load_robot
from stiffkit.study import Analysis, map_workspace
from stiffkit.study.grid import pose_grid
from stiffkit.study.map import postures_of
from stiffkit.vibration import SPARE_MODES, FastModes, ModalModel, modes_in_own_axes

Array = NDArray[np.float64]


def shares(robot: Robot, points: int, every: int) -> tuple[NDArray[np.intp], Array, Array]:
    """Postures (k,) of a map, and their frequencies (5, k) and tool directions (5, 3, k) squared.

    By the full model; the direction is that of the tool point's translation.
    """
    analysis = Analysis(robot)
    postures = postures_of(analysis, pose_grid(robot, points))
    chosen = np.flatnonzero(postures.reached)[::every]
    full = ModalModel(analysis.kinematics.tree, analysis.kinematics.length)
    frequencies, directions = [], []
    for modes in full.at_each(postures.coordinates[:, chosen], 5):
        frequencies.append(modes.frequencies_hz)
        directions.append(modes.tool[:3] ** 2 / np.sum(modes.tool[:3] ** 2, axis=0))
    return chosen, np.array(frequencies).T, np.array(directions).transpose(2, 1, 0)


def directions_of_branches(dataset: xr.Dataset, robot: Robot, points: int, every: int) -> Array:
    """Squared tool directions (n, 3, k) of the full model's modes that the branches are."""
    chosen, frequencies, directions = shares(robot, points, every)
    branches = dataset["frequency_of_branch"].sel(model="refined").values
    branches = branches.reshape(len(branches), -1)[:, chosen]
    error = np.abs(frequencies[None] / branches[:, None] - 1.0)
    nearest = error.argmin(axis=1)
    assert error.min(axis=1).max() < 1e-4
    return np.stack([directions[row, :, np.arange(chosen.size)].T for row in nearest])


@pytest.mark.parametrize(
    ("parameters", "across", "planar", "meets"),
    [({}, 0, [1, 3], False), ({"drive": 1e7}, 2, [0, 1], True)],
    ids=["as published", "soft drives"],
)
def test_biglide_bending_along_z_and_planar_mode_never_swap(
    parameters: dict[str, float], across: int, planar: list[int], meets: bool
) -> None:
    robot = load_robot("biglide", parameters=parameters)
    dataset = map_workspace(robot, points=600)
    found = directions_of_branches(dataset, robot, 600, every=7)
    along_z = found[:, 2]
    # A mode that is planar at one posture and along z at another would be two modes.
    # Where their frequencies all but meet, the two mix a little.
    assert (along_z[across] > 0.6).all()
    assert (along_z[planar] < 0.4).all()
    assert (along_z[across] > 0.99).mean() > 0.8
    assert (along_z[planar] < 0.01).mean() > 0.8
    frequency = dataset["frequency"].sel(model="refined").values
    branches = dataset["frequency_of_branch"].sel(model="refined").values
    assert (np.abs(branches - frequency) > 0.1).any() == meets
    assert json.loads(dataset["frequency_of_branch"].attrs["tracking"])["refined"]["jumps"] == 0


def test_five_bar_planar_modes_and_the_one_across_the_plane_never_swap() -> None:
    robot = load_robot("five-bar")
    dataset = map_workspace(robot, points=1500)
    along_z = directions_of_branches(dataset, robot, 1500, every=19)[:, 2]
    assert (along_z[2] > 0.99).all()
    assert (along_z[[0, 1]] < 0.01).all()
    frequency = dataset["frequency"].sel(model="refined").values
    branches = dataset["frequency_of_branch"].sel(model="refined").values
    crossed = np.abs(branches[2] - frequency[2]) > 1e-6
    assert 0.02 < crossed.mean() < 0.3


def test_five_bar_modes_cross_on_its_axis_of_symmetry() -> None:
    # At x = 0 the mirror keeps the modes along x and along y apart; their frequencies cross.
    robot = load_robot("five-bar")
    dataset = map_workspace(robot, points=300)
    along = dataset["frequency_along_y"].sel(model="refined").values
    chosen, frequencies, directions = shares(robot, 300, every=1)
    x = np.broadcast_to(dataset["x"].values[:, None], (dataset.sizes["x"], dataset.sizes["y"]))
    on_axis = np.flatnonzero(np.abs(x.ravel()[chosen]) < 1e-9)
    f, d = frequencies[:4, on_axis], directions[:4, :, on_axis]
    for branch, axis in ((0, 1), (1, 0), (2, 2)):
        one = (d[:, axis] > 0.999) & (f < 200.0)
        assert (one.sum(axis=0) == 1).all()
        assert along[branch] == pytest.approx(f.T[one.T], rel=1e-4)
    assert (along[0] < along[1])[0]
    assert (along[0] > along[1])[-1]


@pytest.mark.parametrize("name", ["biglide", "five-bar", "delta", "hexapod-cubic"])
def test_vectors_of_the_fast_model_are_those_of_the_full_one(name: str) -> None:
    analysis = Analysis(load_robot(name))
    postures = postures_of(analysis, pose_grid(analysis.robot, 400))
    q = postures.coordinates[:, postures.reached]
    full = ModalModel(analysis.kinematics.tree, analysis.kinematics.length)
    fast = FastModes(full, q, 4)
    chosen = np.linspace(0, q.shape[1] - 1, 8).astype(int)
    reduced, exact = fast.modes(q[:, chosen]), modes_in_own_axes(full, q[:, chosen], 6)
    assert reduced.frequencies.shape == (4 + SPARE_MODES, 8)
    assert reduced.frequencies[:4] == pytest.approx(exact.frequencies[:4], rel=1e-4)
    # The spare modes too are good enough for the part of a curve that runs through them.
    assert reduced.frequencies == pytest.approx(exact.frequencies, rel=1e-3)
    # The same products between two postures, but for the mixtures of modes of equal frequency.
    apart = (np.diff(exact.frequencies, axis=0) / exact.frequencies[1:] > 1e-3).all(axis=0)
    one = np.abs(np.einsum("amr,bnr->abmn", reduced.vectors[apart], reduced.vectors[apart]))
    other = np.abs(np.einsum("amr,bnr->abmn", exact.vectors[apart], exact.vectors[apart]))
    assert apart.any()
    assert one == pytest.approx(other, abs=0.02)
