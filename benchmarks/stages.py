"""A static map from the robot to a dataset in memory, stage by stage, against its kernels.

Each robot and number of threads is measured in a process of its own. It first makes one map, which
compiles the kernels, and touches as much memory as the map needs: on a virtual machine, memory that
has not been used lately costs a second a gigabyte, whoever asks for it, and that is not measured.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.clock import KernelClock
from benchmarks.measure import Cost, cost, peak_bytes
from stiffkit.compiled import limited_threads
from stiffkit.robot import load_robot
from stiffkit.study import Analysis, map_workspace, write_dataset
from stiffkit.study.grid import pose_grid
from stiffkit.study.map import postures_of

POINTS = {"biglide": 1_000_000, "delta": 300_000, "orthoglide": 300_000, "hexapod-cubic": 300_000}
REPEATS = 3


@dataclass(frozen=True)
class Stages:
    """What a map of both models takes, in seconds; medians of a few maps."""

    robot: str
    threads: int
    postures: int
    first: float
    """The first map of the process, from the robot's file: home posture and compilation too."""
    wall: float
    """Another map, dataset in memory."""
    cpu: float
    """The same, seconds of processors."""
    kernels: dict[str, float]
    """Of that, seconds of processors inside compiled kernels, by name."""
    closure: float
    """Wall time of loop closure alone: poses to postures."""
    writing: float
    """Wall time of writing the dataset to disk."""
    dataset_bytes: int
    peak_bytes: int

    @property
    def ratio(self) -> float:
        """End to end over kernels, seconds of processors."""
        return self.cpu / sum(self.kernels.values())


def measure(name: str, threads: int) -> Stages:
    """Return what a process of its own measures."""
    code = f"from benchmarks.stages import print_measured; print_measured({name!r}, {threads})"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return Stages(**json.loads(done.stdout))


def print_measured(name: str, threads: int) -> None:
    """Measure in this process, and print the result as JSON."""
    clock = KernelClock()
    clock.install()
    points = POINTS[name]
    begin = time.perf_counter()
    analysis = Analysis(load_robot(name))

    def work() -> Any:
        return map_workspace(analysis, points=points, frequencies=False, threads=threads)

    dataset = work()
    first = time.perf_counter() - begin
    size = dataset.nbytes
    runs: list[Cost] = []
    kernels: list[dict[str, float]] = []
    for _ in range(REPEATS):
        del dataset
        np.empty(size // 8 + 1)[::512] = 0.0
        clock.seconds.clear()
        kept: list[Any] = []
        runs.append(cost(lambda kept=kept: kept.append(work())))  # type: ignore[misc]
        kernels.append(dict(clock.seconds))
        dataset = kept[0]
    closure = _closure(analysis, points, threads)
    with tempfile.TemporaryDirectory() as folder:
        writing = cost(lambda: write_dataset(dataset, Path(folder))).wall
    by_ratio = sorted(range(REPEATS), key=lambda i: runs[i].cpu / sum(kernels[i].values()))
    middle = by_ratio[REPEATS // 2]
    measured = Stages(
        name,
        threads,
        int(dataset["status"].isel(model=0).size),
        first,
        statistics.median(run.wall for run in runs),
        runs[middle].cpu,
        kernels[middle],
        closure,
        writing,
        size,
        peak_bytes(),
    )
    print(json.dumps(asdict(measured)))


def _closure(analysis: Analysis, points: int, threads: int) -> float:
    grid = pose_grid(analysis.robot, points)
    with limited_threads(threads):
        return statistics.median(
            cost(lambda: postures_of(analysis, grid)).wall for _ in range(REPEATS)
        )
