"""Long studies on a cluster of Dask: workers that die, scaling, and what a chunk costs to schedule.

The scheduler, the workers and the command that collects the rows share the processors of this
machine, so that more workers than processors gain nothing; seconds of processors tell the rest.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from benchmarks.dask_here import DaskHere, dask_here, idle_workers, on_each, processor_seconds
from stiffkit.study.sweep import (
    Cluster,
    Column,
    Executor,
    InProcess,
    StudyDirectory,
    StudySpec,
    Varied,
    create_study,
    open_study,
    run_study,
)
from stiffkit.study.sweep.engine import Rows
from stiffkit.study.sweep.executors import Chunk
from stiffkit.study.sweep.work import Reference, compute_chunk

Array = NDArray[np.float64]

SPEC = StudySpec(
    title="Legs of the Biglide",
    robot="biglide",
    varied=(
        Varied("L1", (0.83, 0.93), "mm"),
        Varied("L2", (0.70, 0.85), "mm"),
        Varied("drive", (2e8, 2e9), "N/m"),
    ),
    sample=1200,
    seed=1,
    postures=1000,
    models=("refined",),
    frequency_postures=0,
    columns=(
        Column("weakest", "min", "stiffness_translation_min"),
        Column("typical", "mean", "stiffness_translation_min"),
        Column("worst", "max", "deflection_translation", "f_y"),
    ),
)
CHUNK = 25
"""Geometries of a chunk: many small chunks, so that what each one costs shows."""
WORKERS = (1, 2, 4)
KILLED = 2
"""Of the most workers; one after a quarter of the chunks, one after half of them."""
SCHEDULED = 300
"""Chunks that nothing is computed for, to see what scheduling costs."""
RESTING = 3.0
"""s for which a scheduler without work is watched."""
IDLE = (4, 32)
SIZES = (1, 8, 64)
"""Geometries of the chunks whose time is measured."""
REPEATS = 5


@dataclass(frozen=True)
class Run:
    """One study from its first chunk to its table, workers ready."""

    workers: int
    """0 for a single process without a cluster."""
    killed: int
    chunks: int
    identical: bool
    """Whether the table is that of the single process, bit for bit."""
    wall: float
    """s."""
    geometries_per_second: float
    workers_cpu: float
    """s of processors; of a worker that was killed, until then."""
    scheduler_cpu: float
    command_cpu: float
    """s of processors, of the process that gives out chunks and writes rows."""

    @property
    def busy(self) -> float:
        """Processors at work, on average."""
        return (self.workers_cpu + self.scheduler_cpu + self.command_cpu) / self.wall


@dataclass(frozen=True)
class ChunkCost:
    """What each chunk takes beside its computing, s of processors."""

    workers: int
    scheduler: float
    command: float
    """Giving it out, reading and checking what comes back, writing it to disk."""
    resting: float
    """Share of a processor that the scheduler needs to hear that its workers are alive."""

    @property
    def serial(self) -> float:
        """s for each chunk that cannot be spread over more machines."""
        return max(self.scheduler, self.command)


@dataclass(frozen=True)
class ChunkWork:
    """What computing a chunk takes, s of a processor."""

    constant: float
    per_geometry: float
    spread: float
    """Standard deviation over mean, of chunks of the largest size measured."""
    first: float
    """Reading the robot file and making the machine code, once for each worker."""

    def seconds(self, geometries: int) -> float:
        """Return what a chunk of so many geometries takes."""
        return self.constant + self.per_geometry * geometries


def measure_runs() -> list[Run]:
    """Return the study by one process, by workers of a cluster, and with two of them killed."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        study = create_study(here / "study", SPEC, chunk_size=CHUNK)
        compute_chunk(*_chunk(study))
        alone = _copy(study, here / "alone")
        runs = [_run(alone, InProcess(), None, 0, alone)]
        for workers, killed in [*((n, 0) for n in WORKERS), (max(WORKERS), KILLED)]:
            own = _copy(study, here / f"{workers} workers, {killed} killed")
            dask_folder = here / f"dask, {workers} workers, {killed} killed"
            dask_folder.mkdir()
            with dask_here(workers, dask_folder) as dask:
                on_each(dask.address, compute_chunk, *_chunk(study))
                cluster = Cluster(dask.address, lambda _text: None)
                executor = Killing(cluster, dask.workers[:killed], study.n_chunks)
                runs.append(_run(own, executor, dask, killed, alone))
        return runs


def _copy(study: StudyDirectory, path: Path) -> StudyDirectory:
    shutil.copytree(study.path, path)
    return open_study(path)


def _chunk(study: StudyDirectory) -> tuple[dict[str, Any], Reference, Array]:
    """Return what the first chunk is computed from."""
    return study.job.plain(), study.reference(), study.values(0)


class Killing:
    """An executor, and workers of it that are killed while it is at work."""

    def __init__(
        self, executor: Executor, victims: Sequence[subprocess.Popen[bytes]], chunks: int
    ) -> None:
        self._executor = executor
        self._at = {(i + 1) * chunks // (2 * len(victims)): v for i, v in enumerate(victims)}

    def run(
        self, job: dict[str, Any], reference: Reference, chunks: Sequence[Chunk]
    ) -> Generator[tuple[int, Rows], None, None]:
        """Yield the rows of each chunk, see `Executor`."""
        for finished, found in enumerate(self._executor.run(job, reference, chunks)):
            if finished in self._at:
                self._at[finished].kill()
            yield found


def _run(
    study: StudyDirectory,
    executor: Executor,
    dask: DaskHere | None,
    killed: int,
    alone: StudyDirectory,
) -> Run:
    before = _cpu(dask)
    start, cpu = time.perf_counter(), time.process_time()
    run_study(study, executor)
    wall, cpu = time.perf_counter() - start, time.process_time() - cpu
    workers, scheduler = np.subtract(_cpu(dask), before).tolist()
    return Run(
        *(len(dask.workers) if dask else 0, killed, study.n_chunks),
        _contents(study) == _contents(alone),
        *(wall, study.spec.n_geometries / wall, workers, scheduler, cpu),
    )


def _cpu(dask: DaskHere | None) -> tuple[float, float]:
    """Return the seconds of processors of all workers, and of the scheduler."""
    if dask is None:
        return 0.0, 0.0
    return sum(map(processor_seconds, dask.workers)), processor_seconds(dask.scheduler)


def _contents(study: StudyDirectory) -> dict[str, bytes]:
    """Return the bytes of everything in a table."""
    import xarray as xr

    with xr.open_dataset(study.table, engine="h5netcdf") as table:
        return {
            str(name): repr(v.values.tolist()).encode() if v.dtype == object else v.values.tobytes()
            for name, v in table.variables.items()
        }


def measure_costs() -> list[ChunkCost]:
    """Return what chunks cost with several numbers of workers, by chunks without work."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        spec = replace(SPEC, sample=SCHEDULED * CHUNK)
        study = create_study(here / "study", spec, chunk_size=CHUNK)
        return [_cost(_copy(study, here / f"{n}"), here / f"dask, {n}", n) for n in IDLE]


def _cost(study: StudyDirectory, folder: Path, workers: int) -> ChunkCost:
    folder.mkdir()
    with dask_here(0, folder) as dask, idle_workers(dask.address, workers):
        cluster = Cluster(dask.address, lambda _text: None)
        resting = _resting(dask)
        _, before = _cpu(dask)
        start, cpu = time.perf_counter(), time.process_time()
        with patch("stiffkit.study.sweep.cluster.compute_chunk", made_up_rows):
            reference, job = study.reference(), study.job.plain()
            chunks = [(i, study.values(i)) for i in range(study.n_chunks)]
            for number, rows in cluster.run(job, reference, chunks):
                study.write_chunk(number, rows)
        wall, cpu = time.perf_counter() - start, time.process_time() - cpu
        _, after = _cpu(dask)
    scheduler = after - before - resting * wall
    return ChunkCost(workers, scheduler / study.n_chunks, cpu / study.n_chunks, resting)


def _resting(dask: DaskHere) -> float:
    """Return the share of a processor that the scheduler uses for workers without work."""
    _, before = _cpu(dask)
    start = time.perf_counter()
    time.sleep(RESTING)
    return (_cpu(dask)[1] - before) / (time.perf_counter() - start)


def made_up_rows(_job: dict[str, Any], _reference: Reference, values: Array) -> Rows:
    """Return rows as large as those of a study: the task of workers that compute nothing."""
    n = values.shape[1]
    columns = {f"column {i}": np.zeros((1, n)) for i in range(len(SPEC.columns))}
    return {"geometry_status": np.zeros(n, dtype=np.int8), "reason": np.full(n, ""), **columns}


def measure_work() -> ChunkWork:
    """Return what chunks of several sizes take in one process."""
    with tempfile.TemporaryDirectory() as folder:
        study = create_study(Path(folder, "study"), SPEC, chunk_size=1)
        job, reference = study.job.plain(), study.reference()
        values = np.concatenate([study.values(i) for i in range(sum(SIZES) * REPEATS)], axis=1)
        first = _processor_time(job, reference, values[:, :1])
        sizes, times = [], []
        for size in SIZES * REPEATS:
            own, values = values[:, :size], values[:, size:]
            sizes.append(size)
            times.append(_processor_time(job, reference, own))
    # Relative errors count: small chunks tell the constant.
    weight = 1.0 / np.array(times)
    per_geometry, constant = np.polyfit(sizes, times, 1, w=weight)
    largest = [t for n, t in zip(sizes, times, strict=True) if n == max(SIZES)]
    spread = float(np.std(largest) / np.mean(largest))
    return ChunkWork(max(float(constant), 0.0), float(per_geometry), spread, first)


def _processor_time(job: dict[str, Any], reference: Reference, values: Array) -> float:
    start = time.process_time()
    compute_chunk(job, reference, values)
    return time.process_time() - start
