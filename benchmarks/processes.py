"""Whole commands, cold and warm.

Cold: Python's bytecode is made anew and the caches of stiffkit are empty, as after an installation.
Warm: the same command once more. Both are wall times of whole processes.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.kernels import ROBOTS

REPEATS = 3
LONG = 10.0
"""Seconds from which a command is run once warm, not `REPEATS` times."""


@dataclass(frozen=True)
class ProcessTimes:
    """Seconds of one command."""

    command: str
    cold: float
    warm: float
    warm_over_numpy: float
    """Against a process that imports NumPy, warm."""


def measure() -> list[ProcessTimes]:
    """Return the times of the commands that people type."""
    stiffkit = str(Path(sysconfig.get_path("scripts")) / "stiffkit")
    bare = [sys.executable, "-c", "import numpy"]
    with tempfile.TemporaryDirectory() as folder:
        out = str(Path(folder, "map"))
        commands = [
            bare,
            [stiffkit, "--help"],
            *([stiffkit, "pose", name, "--json"] for name in ROBOTS),
            [stiffkit, "map", "biglide", "-o", out],
            [stiffkit, "map", "biglide", "--points", "1000000", "-o", out],
        ]
        times = [(_words(command, out), *_cold_and_warm(command)) for command in commands]
    numpy = times[0][2]
    return [ProcessTimes(words, cold, warm, warm / numpy) for words, cold, warm in times]


def _cold_and_warm(command: Sequence[str]) -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {
            "PYTHONPYCACHEPREFIX": str(Path(folder, "bytecode")),
            "XDG_CACHE_HOME": str(Path(folder, "cache")),
        }
        cold = _seconds(command, environment)
        repeats = REPEATS if cold < LONG else 1
        return cold, statistics.median(_seconds(command, environment) for _ in range(repeats))


def _seconds(command: Sequence[str], environment: dict[str, str]) -> float:
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=environment)
    return time.perf_counter() - start


def _words(command: Sequence[str], out: str) -> str:
    name = Path(command[0]).name
    return " ".join([name, *(word for word in command[1:] if word not in ("-o", out))])
