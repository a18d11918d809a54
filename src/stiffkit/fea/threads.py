"""How many threads a solve gets."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np


@contextmanager
def threads(n: int) -> Iterator[None]:
    """Let NGSolve use ``n`` threads; none is started for one."""
    from ngsolve import SetNumThreads, TaskManager

    if n <= 1:
        yield
        return
    SetNumThreads(n)
    with TaskManager():
        yield


def idle_cores(limit: int = 4) -> int:
    """Return how many cores have nothing to do, at least 1 and at most ``limit``."""
    try:
        cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[0]
    except (AttributeError, OSError):
        return 1
    return int(np.clip(round(cores - load), 1, limit))
