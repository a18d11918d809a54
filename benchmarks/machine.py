"""What this machine can do: its multiply-add peak, by a loop that nothing else slows down."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass

import numpy as np

from benchmarks.measure import fastest_seconds

CHAINS = 24
"""Independent chains of multiply-adds: enough to hide the time that each one takes."""
LENGTH = 64
WIDTH = 512
"""Numbers side by side: inputs and outputs stay in the first-level cache."""
CALLS = 200
ROW = 4096


@dataclass(frozen=True)
class Machine:
    """One thread of this machine."""

    processors: int
    """That this process may run on."""
    system: str
    python: str
    multiply_adds: float
    """Floating-point operations per second of chains of multiply-adds, two for each."""
    numpy_multiply_adds: float
    """The same by NumPy on arrays of 1000 numbers, for what interpreting costs at best."""
    row_writes: float
    """Bytes per second into the rows of a large array, `ROW` numbers at a time: so maps are written
    down."""


def measure() -> Machine:
    """Return what this machine can do."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return Machine(
        count or 1,
        f"{platform.system()} {platform.machine()}",
        platform.python_version(),
        peak(),
        _numpy(),
        _row_writes(),
    )


def peak() -> float:
    """Return operations per second and thread of compiled chains ``x <- a x + b``.

    LLVM makes one instruction of each multiply and add, over whole registers, as in the kernels.
    """
    import heyoka

    inputs = heyoka.make_vars(*(f"x{i}" for i in range(CHAINS)))
    a, b = heyoka.par[0], heyoka.par[1]
    outputs = list(inputs)
    for _ in range(LENGTH):
        outputs = [a * x + b for x in outputs]
    function = heyoka.cfunc(outputs, inputs)
    x, out = np.ones((CHAINS, WIDTH)), np.empty((CHAINS, WIDTH))
    pars = np.repeat([[0.999], [0.001]], WIDTH, axis=1)

    def work() -> None:
        for _ in range(CALLS):
            function(x, outputs=out, pars=pars, batch_parallel=False)

    return 2.0 * CHAINS * LENGTH * WIDTH * CALLS / fastest_seconds(work)


def _numpy() -> float:
    a, b, c = (np.random.default_rng(0).random(1000) for _ in range(3))

    def work() -> None:
        for _ in range(2000):
            np.multiply(a, b, out=c)
            np.add(c, a, out=c)

    return 2.0 * 2000 * 1000 / fastest_seconds(work)


def _row_writes() -> float:
    array, row = np.zeros((150, 100 * ROW)), np.ones(ROW)

    def work() -> None:
        for start in range(0, array.shape[1], ROW):
            for into in array:
                into[start : start + ROW] = row

    return array.nbytes / fastest_seconds(work, 3)
