"""Lowest four natural frequencies: the fast model against a dense solve of the full one."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from benchmarks.measure import median_cost
from stiffkit.compiled import BatchFunction
from stiffkit.robot import load_robot
from stiffkit.study import Analysis
from stiffkit.study.grid import pose_grid
from stiffkit.study.map import postures_of
from stiffkit.vibration import Discretisation, FastModes, ModalModel

Array = NDArray[np.float64]

N_MODES = 4
BATCH = 8_192
SAMPLES = 500


@dataclass(frozen=True)
class VibrationRates:
    """Postures per second and thread, of a processor's time."""

    robot: str
    basis: int
    error: float
    """Largest relative error of the fast model at the postures that it was checked at."""
    good: bool
    """Whether maps use the fast model; otherwise it is not compiled here either."""
    interpreted: float
    """By the fast model, its kernel by NumPy: maps of less than
    `stiffkit.compiled.function.WORTH_COMPILING_LARGE` postures."""
    compiled: float | None
    """The same with the kernel compiled."""
    kernel: float | None
    """The compiled kernel alone: without the eigenvalues of its small matrices."""
    compile_seconds: float | None
    """Tracing and compiling, s of a processor."""
    steps: int | None
    """Elementary steps that the kernel was compiled from."""
    dense: float
    """From coordinates to frequencies by the full model: matrices, and a dense solve for the lowest
    modes alone."""
    eigen: float
    """The dense solve by itself, with the matrices given."""
    unknowns: int
    """Of the dense solve: 20 consistent elements for each link, nothing reduced."""


def measure(name: str) -> VibrationRates:
    """Return the rates of a robot."""
    analysis = Analysis(load_robot(name))
    kinematics = analysis.kinematics
    postures = postures_of(analysis, pose_grid(analysis.robot, SAMPLES))
    q = postures.coordinates[:, postures.reached]
    model = ModalModel(kinematics.tree, kinematics.length)
    many = np.resize(q.T, (BATCH, q.shape[0])).T
    fast = FastModes(model, q, N_MODES, backend="numpy")
    interpreted = BATCH / median_cost(partial(fast.frequencies, many), 1).cpu
    full = ModalModel(kinematics.tree, kinematics.length, Discretisation("consistent", 20, None))
    K, M = full.matrices(q[:, 0])
    n = len(K)
    # Mass against stiffness: the largest eigenvalues are those of the lowest modes.
    lowest = partial(eigh, eigvals_only=True, subset_by_index=[n - N_MODES, n - 1])
    compiled = kernel = compile_seconds = steps = None
    if fast.trust.good:
        compiled, kernel, compile_seconds, steps = _compiled(fast, many)
    return VibrationRates(
        *(name, fast.trust.size, fast.trust.error, fast.trust.good, interpreted),
        *(compiled, kernel, compile_seconds, steps),
        1.0 / median_cost(lambda: lowest(*reversed(full.matrices(q[:, 0]))), 3).cpu,
        1.0 / median_cost(lambda: lowest(M, K), 3).cpu,
        n,
    )


def _compiled(fast: FastModes, many: Array) -> tuple[float, float, float, int]:
    """Return rates of all and of the kernel, the time of compiling, and the kernel's steps."""
    function = BatchFunction(fast._function.kernel, "heyoka")
    start = time.process_time()
    compiled = function.compile()
    seconds = time.process_time() - start
    fast._function = function
    return (
        BATCH / median_cost(partial(fast.frequencies, many), 3).cpu,
        BATCH / median_cost(partial(function, many), 3).cpu,
        seconds,
        len(compiled.dc) - compiled.nvars - compiled.nouts,
    )
