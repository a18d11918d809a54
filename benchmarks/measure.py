"""Taking times."""

from __future__ import annotations

import statistics
import subprocess
import time
from collections.abc import Callable, Sequence


def seconds(work: Callable[[], object], repeats: int = 5) -> float:
    """Return the median time of some work, after one run that is not counted."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def process_seconds(command: Sequence[str], repeats: int = 5) -> float:
    """Return the median wall time of a whole process."""
    return seconds(lambda: subprocess.run(command, check=True, capture_output=True), repeats)
