"""Reductions fused into the sweep: the table of a study of many geometries, stage by stage.

Worst case, mean, percentile and share above a threshold of each geometry are computed while
sweeping, so that memory holds one block of postures. Each robot has a process of its own.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.clock import KernelClock, timed
from benchmarks.measure import cost, peak_bytes
from stiffkit.study.sweep import (
    Column,
    Processes,
    StudyDirectory,
    StudySpec,
    Varied,
    create_study,
    engine,
)
from stiffkit.study.sweep.closing import Closing
from stiffkit.study.sweep.family import Family
from stiffkit.study.sweep.work import compute_chunk

VARIED = {
    "biglide": (Varied("L1", (0.83, 0.93), "mm"), "f_y"),
    "delta": (Varied("rod", (0.54, 0.56), "mm"), "push"),
    "orthoglide": (Varied("L", (0.305, 0.315), "mm"), "push"),
    "hexapod-cubic": (Varied("edge", (0.39, 0.41), "mm"), "push"),
}
"""What differs from geometry to geometry, and a load case, for each robot."""
GEOMETRIES = 200
POSTURES = 1000
CHUNKS = 10
PROCESSES = 2


@dataclass(frozen=True)
class Reductions:
    """What a study takes, by one process; seconds of a processor where nothing else is said."""

    robot: str
    postures: int
    wall: float
    """s."""
    cpu: float
    geometries: float
    """Making robots of parameters."""
    closing: float
    """Newton's method, kernels and all that is around them."""
    compliances: float
    reducing: float
    """Statistics, and what of quantities is computed for them."""
    kernels: float
    """Inside compiled code, of closing and compliances."""
    peak_bytes: int
    wall_two: float
    """s, by two processes, which have begun before."""

    @property
    def ratio(self) -> float:
        """All over kernels."""
        return self.cpu / self.kernels


def spec_of(robot: str) -> StudySpec:
    """Return the study of a robot."""
    varied, load = VARIED[robot]
    return StudySpec(
        title=f"Benchmark of {robot}",
        robot=robot,
        varied=(varied,),
        sample=GEOMETRIES,
        seed=1,
        postures=POSTURES,
        models=("refined",),
        frequency_postures=0,
        columns=(
            Column("weakest", "min", "stiffness_translation_min"),
            Column("typical", "mean", "stiffness_translation_min"),
            Column("nearly_worst", "percentile", "deflection_translation", load, 95.0),
            Column("soft", "share above", "deflection_translation", load, 1e-5),
        ),
    )


def measure(robot: str) -> Reductions:
    """Return what a process of its own measures."""
    code = f"from benchmarks.reductions import print_measured; print_measured({robot!r})"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return Reductions(**json.loads(done.stdout))


def print_measured(robot: str) -> None:
    """Measure in this process, and print the result as JSON."""
    clock, seconds = KernelClock(), Counter[str]()
    clock.install()
    timed(Family, "geometry", seconds, "geometries")
    timed(Closing, "homes", seconds, "closing")
    timed(Closing, "postures", seconds, "closing")
    timed(engine, "compliances", seconds, "compliances")
    with tempfile.TemporaryDirectory() as folder:
        spec = spec_of(robot)
        study = create_study(Path(folder, "study"), spec, chunk_size=GEOMETRIES // CHUNKS)
        values = np.concatenate([study.values(i) for i in range(study.n_chunks)], axis=1)
        given = study.job.plain(), study.reference(), values
        # The machine code is made before.
        compute_chunk(*given)
        clock.seconds.clear()
        seconds.clear()
        taken = cost(lambda: compute_chunk(*given))
        parts, kernels, peak = dict(seconds), sum(clock.seconds.values()), peak_bytes()
        two = _by_processes(study)
    print(
        json.dumps(
            asdict(
                Reductions(
                    *(robot, GEOMETRIES * math.prod(study.shape), taken.wall, taken.cpu),
                    *(parts["geometries"], parts["closing"], parts["compliances"]),
                    *(taken.cpu - sum(parts.values()), kernels, peak, two),
                )
            )
        )
    )


def _by_processes(study: StudyDirectory) -> float:
    """Return how long two processes take, by the time between the chunks that they finish."""
    chunks = [(i, study.values(i)) for i in range(study.n_chunks)]
    results = Processes(PROCESSES).run(study.job.plain(), study.reference(), chunks)
    finished = [time.perf_counter() for _ in results]
    steady = finished[PROCESSES - 1 :]
    return (steady[-1] - steady[0]) / (len(steady) - 1) * len(chunks)
