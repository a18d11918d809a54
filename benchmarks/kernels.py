"""Posture kernels: compiled, interpreted by NumPy, and one posture at a time; operations a second.

Joint coordinates are given, and only the kernel is timed. Chunks of inputs stay in the cache.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import fastest_seconds, seconds
from benchmarks.operations import operations
from stiffkit.compiled import BatchFunction, Kernel
from stiffkit.kinematics import Kinematics
from stiffkit.robot import DIRECTIONS, load_robot
from stiffkit.stiffness import Composition, SimplifiedModel, readings

Array = NDArray[np.float64]

ROBOTS = ("biglide", "delta", "orthoglide", "hexapod-cubic")

COMPILED_BATCH = 65_536
NUMPY_BATCH = 4_096


@dataclass(frozen=True)
class Rates:
    """Rates of one kernel, postures per second and thread."""

    robot: str
    kernel: str
    compiled: float
    numpy: float
    single: float
    """The same kernel on one posture at a time, on Python's floats."""
    compile_seconds: float
    """Tracing and compiling."""
    arithmetic: int
    """Operations of a posture; see `benchmarks.operations` for what is counted."""
    functions: int
    per_second: float
    """Operations per second, sines and cosines not counted."""
    share_of_peak: float
    """Of the multiply-add peak measured in the same run."""


def measure(name: str, peak: float) -> list[Rates]:
    """Return the rates of a robot's kernels; ``peak`` is `benchmarks.machine.peak`."""
    rates = []
    for what, kernel, at in _kernels(name):
        compiled = BatchFunction(kernel, "heyoka")
        start = time.perf_counter()
        function = compiled.compile()
        compile_seconds = time.perf_counter() - start
        counted = operations(function)
        many, some = _around(at, COMPILED_BATCH), _around(at, NUMPY_BATCH)
        interpreted = BatchFunction(kernel, "numpy")
        rate = COMPILED_BATCH / fastest_seconds(partial(compiled, many))
        rates.append(
            Rates(
                name,
                what,
                rate,
                NUMPY_BATCH / seconds(partial(interpreted, some), 3),
                1.0 / seconds(partial(interpreted, at), 3),
                compile_seconds,
                counted.arithmetic,
                counted.functions,
                rate * counted.arithmetic,
                rate * counted.arithmetic / peak,
            )
        )
    return rates


def _kernels(name: str) -> Iterator[tuple[str, Kernel, Array]]:
    """Yield name, kernel and inputs at home (n, 1)."""
    kinematics = Kinematics(load_robot(name))
    home = kinematics.home.coordinates
    tool = kinematics.home.tool[[DIRECTIONS.index(d) for d in kinematics.asked]]
    extra = np.zeros((len(kinematics.closure.auxiliary), 1))
    refined = Composition(kinematics.tree, kinematics.length).kernel()
    yield "closure step", kinematics.closure.newton_step(), np.concatenate([home, extra, tool])
    yield "refined", refined, home
    yield "simplified", SimplifiedModel(kinematics.loops).kernel(), home
    loads = np.array([load.wrench for load in kinematics.robot.loads.values()])
    yield "readings", readings(loads), BatchFunction(refined, "numpy")(home)[:21]


def _around(at: Array, n: int) -> Array:
    scale = 1e-3 * np.maximum(np.abs(at), np.abs(at).max() * 1e-3)
    return np.asarray(at + scale * np.random.default_rng(0).standard_normal((at.shape[0], n)))
