"""Lowest four natural frequencies: the fast model against a dense solve of the full one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import eigh

from benchmarks.measure import seconds
from stiffkit.robot import load_robot
from stiffkit.study import Analysis
from stiffkit.study.grid import pose_grid
from stiffkit.study.map import postures_of
from stiffkit.vibration import Discretisation, FastModes, ModalModel

N_MODES = 4
BATCH = 20_000


@dataclass(frozen=True)
class VibrationRates:
    """Postures per second and thread."""

    robot: str
    basis: int
    fast: float
    dense: float
    """From coordinates to frequencies by the full model: matrices, and a dense solve for the lowest
    modes alone."""
    eigen: float
    """The dense solve by itself, with the matrices given."""
    unknowns: int
    """Of the dense solve: 20 consistent elements for each link, nothing reduced."""
    error: float
    """Largest relative error of the fast model at the postures that it was checked at."""


def measure(name: str) -> VibrationRates:
    """Return the rates of a robot."""
    analysis = Analysis(load_robot(name))
    kinematics = analysis.kinematics
    postures = postures_of(analysis, pose_grid(analysis.robot, 2000))
    q = postures.coordinates[:, postures.reached]
    fast = FastModes(ModalModel(kinematics.tree, kinematics.length), q, N_MODES)
    many = np.resize(q.T, (BATCH, q.shape[0])).T
    full = ModalModel(kinematics.tree, kinematics.length, Discretisation("consistent", 20, None))
    K, M = full.matrices(q[:, 0])
    n = len(K)
    # Mass against stiffness: the largest eigenvalues are those of the lowest modes.
    lowest = partial(eigh, eigvals_only=True, subset_by_index=[n - N_MODES, n - 1])
    dense = seconds(lambda: lowest(*reversed(full.matrices(q[:, 0]))), 3)
    eigen = seconds(lambda: lowest(M, K), 3)
    return VibrationRates(
        name,
        fast.trust.size,
        BATCH / seconds(partial(fast.frequencies, many), 3),
        1.0 / dense,
        1.0 / eigen,
        n,
        fast.trust.error,
    )
