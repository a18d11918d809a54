"""How many threads a solve gets."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_WATCHED = 0.1
"""s for which the cores are watched."""


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
    """Return how many cores have nothing to do just now, at least 1 and at most ``limit``.

    It watches them for a tenth of a second. The load average would do without that, but it counts
    what this process itself did a moment ago.
    """
    before = _ticks()
    time.sleep(_WATCHED)
    busy, idle = (_ticks() - before).sum(axis=0)
    if busy + idle == 0:
        return 1
    cores = len(os.sched_getaffinity(0))
    return int(np.clip(round(cores * idle / (busy + idle)), 1, limit))


def _ticks() -> NDArray[np.int64]:
    """Return the ticks that each core of this process was busy and idle (c, 2); none if unknown."""
    try:
        mine = {f"cpu{core}" for core in os.sched_getaffinity(0)}
        lines = Path("/proc/stat").read_text(encoding="ascii").splitlines()
    except (AttributeError, OSError):
        return np.zeros((0, 2), dtype=np.int64)
    rows = []
    for name, *counts in (line.split() for line in lines):
        if name in mine:
            ticks = [int(count) for count in counts[:8]]
            idle = ticks[3] + ticks[4]
            rows.append([sum(ticks) - idle, idle])
    return np.array(rows, dtype=np.int64).reshape(-1, 2)
