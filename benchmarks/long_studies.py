"""The benchmarks of long studies, as tables."""

from __future__ import annotations

from typing import Any

from benchmarks import cluster, reductions, simulation
from benchmarks.machine import Machine
from benchmarks.table import show

STUDIES = ((4_000, 4), (100_000, 20), (100_000, 100), (100_000, 1000), (10_000_000, 1000))
"""Geometries of 1000 postures, and workers, of the studies that are simulated."""
CHUNKS = (4, 16, 64, 256, 1024, 4096)


def run_reductions(_this: Machine) -> list[Any]:
    """Tables of long studies: worst case, mean, percentile and share, while sweeping."""
    rows = [reductions.measure(name) for name in reductions.VARIED]
    show(
        f"Reductions while sweeping, {reductions.GEOMETRIES} geometries, refined model; seconds of"
        " a processor, by one process; walls by one and by two",
        (
            *("robot", "postures", "all", "geometries", "closing", "compliances", "reducing"),
            *("kernels", "all/kernels", "postures/s", "peak, GB", "wall", "wall, two"),
        ),
        [
            (
                *(r.robot, r.postures, r.cpu, r.geometries, r.closing, r.compliances, r.reducing),
                *(r.kernels, r.ratio, r.postures / r.cpu, r.peak_bytes / 1e9, r.wall, r.wall_two),
            )
            for r in rows
        ],
    )
    return rows


def run_cluster(_this: Machine) -> list[Any]:
    """A study on a cluster of Dask on this machine, its workers killed too."""
    rows = cluster.measure_runs()
    show(
        f"A study of {cluster.SPEC.n_geometries} geometries, 1000 postures each, on a cluster of"
        " Dask; workers 0: without one. CPU: seconds of processors",
        (
            *("workers", "killed", "chunks", "table identical", "wall, s", "geometries/s"),
            *("workers CPU", "scheduler CPU", "command CPU", "processors at work"),
        ),
        [
            (
                *(r.workers, r.killed, r.chunks, "yes" if r.identical else "NO", r.wall),
                *(r.geometries_per_second, r.workers_cpu, r.scheduler_cpu, r.command_cpu, r.busy),
            )
            for r in rows
        ],
    )
    return rows


def run_scheduling(_this: Machine) -> list[Any]:
    """What chunks cost to schedule, and what follows for many machines."""
    costs, work = cluster.measure_costs(), cluster.measure_work()
    show(
        "Chunks without work on a cluster of Dask, ms of a processor for each (resting: share of a"
        " processor that the scheduler uses for its workers)",
        ("workers", "scheduler", "command", "resting"),
        [(c.workers, 1e3 * c.scheduler, 1e3 * c.command, c.resting) for c in costs],
    )
    show(
        "Computing chunks, 1000 postures for each geometry, ms of a processor",
        ("for a chunk", "for a geometry", "spread", "first chunk of a worker"),
        [(1e3 * work.constant, 1e3 * work.per_geometry, work.spread, 1e3 * work.first)],
    )
    serial = max(cost.serial for cost in costs)
    rows = simulation.simulated(STUDIES, CHUNKS, work, serial)
    show(
        f"Simulated: one process gives out chunks, {1e3 * serial:.1f} ms each; efficiency by"
        " geometries of a chunk",
        ("geometries", "workers", *map(str, CHUNKS), "chosen", "efficiency", "minutes"),
        [
            (
                *(geometries, workers),
                *(simulation.efficiency(rows, geometries, workers, n) for n in CHUNKS),
                *simulation.chosen(rows, geometries, workers),
            )
            for geometries, workers in STUDIES
        ],
    )
    return [*costs, work, *rows]
