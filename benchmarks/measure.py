"""Taking times, and the memory of a process."""

from __future__ import annotations

import re
import resource
import statistics
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Cost:
    """What some work takes."""

    wall: float
    """s that pass."""
    cpu: float
    """s of processors; on a machine that others use, these tell more."""

    def __sub__(self, other: Cost) -> Cost:
        """Return what this work takes beside the other."""
        return Cost(self.wall - other.wall, self.cpu - other.cpu)


def cost(work: Callable[[], object]) -> Cost:
    """Return what some work takes in this process and in those that it starts and waits for."""
    wall, cpu = time.perf_counter(), _processor_seconds()
    work()
    return Cost(time.perf_counter() - wall, _processor_seconds() - cpu)


def median_cost(work: Callable[[], object], repeats: int) -> Cost:
    """Return the medians of what some work takes, after one run that is not counted."""
    work()
    costs = [cost(work) for _ in range(repeats)]
    return Cost(statistics.median(c.wall for c in costs), statistics.median(c.cpu for c in costs))


def _processor_seconds() -> float:
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def seconds(work: Callable[[], object], repeats: int = 5) -> float:
    """Return the median time of some work, after one run that is not counted."""
    return statistics.median(_times(work, repeats))


def fastest_seconds(work: Callable[[], object], repeats: int = 5) -> float:
    """Return the shortest time of some work: what it takes when nobody else is at the machine."""
    return min(_times(work, repeats))


def _times(work: Callable[[], object], repeats: int) -> list[float]:
    """Return the times of some work, after one run that is not counted."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return times


def process_seconds(command: Sequence[str], repeats: int = 5) -> float:
    """Return the median wall time of a whole process."""
    return seconds(lambda: subprocess.run(command, check=True, capture_output=True), repeats)


def peak_bytes() -> int:
    """Return the largest resident memory of this process so far."""
    status = Path("/proc/self/status")
    if status.exists():
        # Unlike getrusage, this does not count what the process was that started this one.
        return 1024 * int(re.findall(r"VmHWM:\s*(\d+) kB", status.read_text("ascii"))[0])
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
