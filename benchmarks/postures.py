"""Static postures per second and thread, with joint coordinates given."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import seconds
from stiffkit.compiled import BatchFunction
from stiffkit.kinematics import Kinematics
from stiffkit.robot import load_robot
from stiffkit.stiffness import Composition, SimplifiedModel

ROBOTS = ("biglide", "delta", "hexapod-cubic")

COMPILED_BATCH = 200_000
NUMPY_BATCH = 4_096


@dataclass(frozen=True)
class Rates:
    """Rates of one kernel."""

    robot: str
    kernel: str
    compiled: float
    """Postures per second and thread."""
    numpy: float
    single: float
    """The same kernel on one posture at a time, on Python's floats."""
    compile_seconds: float


def measure(name: str) -> list[Rates]:
    """Return the rates of a robot's refined model, simplified model and Newton step."""
    kinematics = Kinematics(load_robot(name))
    home = kinematics.home.coordinates
    tool = kinematics.home.tool[
        [("x", "y", "z", "rx", "ry", "rz").index(d) for d in kinematics.asked]
    ]
    extra = np.zeros((len(kinematics.closure.auxiliary), 1))
    kernels = {
        "refined": (Composition(kinematics.tree, kinematics.length).kernel(), home),
        "simplified": (SimplifiedModel(kinematics.loops).kernel(), home),
        "closure step": (kinematics.closure.newton_step(), np.concatenate([home, extra, tool])),
    }
    rates = []
    for what, (kernel, at) in kernels.items():
        compiled = BatchFunction(kernel, "heyoka")
        start = time.perf_counter()
        compiled.compile()
        compile_seconds = time.perf_counter() - start
        many, some = _around(at, COMPILED_BATCH), _around(at, NUMPY_BATCH)
        interpreted = BatchFunction(kernel, "numpy")
        rates.append(
            Rates(
                name,
                what,
                COMPILED_BATCH / seconds(partial(compiled, many)),
                NUMPY_BATCH / seconds(partial(interpreted, some), 3),
                1.0 / seconds(partial(interpreted, at), 3),
                compile_seconds,
            )
        )
    return rates


def _around(at: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    rng = np.random.default_rng(0)
    return np.asarray(at + 1e-3 * rng.standard_normal((at.shape[0], n)))
