"""A study on very many workers, simulated from what was measured on a few.

One server gives out chunks and takes rows back, one after the other; each worker holds a few chunks
and computes them in turn. Times of chunks are a constant and so much for each geometry, and spread
like those measured. What is left out: the network, and workers that die.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.cluster import SPEC, ChunkWork
from stiffkit.study.sweep.directory import chunk_size_of

AHEAD = 4
"""Chunks that each worker holds, as in `stiffkit.study.sweep.cluster`."""
MOST_CHUNKS = 100_000
"""Studies of more chunks are not simulated: they are those whose efficiency is low anyway."""


@dataclass(frozen=True)
class Simulated:
    """A study on so many workers."""

    geometries: int
    workers: int
    chunk: int
    """Geometries of a chunk."""
    chunk_seconds: float
    """Mean time of computing one."""
    seconds: float
    """From the first chunk given out to the last rows taken."""
    efficiency: float
    """Work of all geometries, over what all workers could have done in this time."""


def simulate(
    geometries: int, workers: int, chunk: int, work: ChunkWork, serial: float
) -> Simulated:
    """Return how a study goes that needs ``serial`` seconds of the one server for each chunk."""
    sizes = np.full(-(-geometries // chunk), chunk)
    sizes[-1] = geometries - chunk * (sizes.size - 1)
    spread = np.random.default_rng(0).normal(1.0, work.spread, sizes.size).clip(0.2)
    times = (work.constant + work.per_geometry * sizes) * spread
    seconds = makespan(times.tolist(), workers, serial, work.first)
    ideal = work.per_geometry * geometries / workers
    return Simulated(
        geometries, workers, chunk, work.seconds(chunk), seconds, float(ideal / seconds)
    )


def makespan(times: Sequence[float], workers: int, serial: float, first: float = 0.0) -> float:
    """Return when the last of some chunks is back, each needing the server for ``serial`` seconds.

    Half of these are for giving it out, half for taking its rows. ``first`` is how long each worker
    prepares, before its first chunk.
    """
    waiting = deque(times)
    free = [first] * workers
    """When each worker is done with what it holds."""
    server = 0.0
    # Each event is a worker that has room for a chunk, or whose rows are ready, by their time.
    events = [(0.0, place, False) for place in range(workers * AHEAD)]
    heapq.heapify(events)
    while events:
        time, place, has_rows = heapq.heappop(events)
        if not waiting and not has_rows:
            continue
        server = max(server, time) + serial * (has_rows + bool(waiting)) / 2.0
        if waiting:
            worker = place % workers
            free[worker] = max(free[worker], server) + waiting.popleft()
            heapq.heappush(events, (free[worker], place, True))
    return server


def simulated(
    studies: Sequence[tuple[int, int]], chunks: Sequence[int], work: ChunkWork, serial: float
) -> list[Simulated]:
    """Return each study (geometries, workers) in chunks of each size, and of the default size."""
    return [
        simulate(geometries, workers, chunk, work, serial)
        for geometries, workers in studies
        for chunk in sorted({*chunks, default_chunk(geometries)})
        if geometries <= MOST_CHUNKS * chunk
    ]


def default_chunk(geometries: int) -> int:
    """Return the geometries of a chunk that a study has if nobody says."""
    return chunk_size_of(replace(SPEC, sample=geometries))


def efficiency(rows: Sequence[Simulated], geometries: int, workers: int, chunk: int) -> str:
    """Return the efficiency of a study in chunks of a size, as text; "-" if not simulated."""
    found = [
        r.efficiency
        for r in rows
        if (r.geometries, r.workers, r.chunk) == (geometries, workers, chunk)
    ]
    return f"{found[0]:.0%}" if found else "-"


def chosen(rows: Sequence[Simulated], geometries: int, workers: int) -> tuple[int, str, float]:
    """Return the default size of a study's chunks, its efficiency, and the minutes it takes."""
    chunk = default_chunk(geometries)
    row = next(
        r for r in rows if (r.geometries, r.workers, r.chunk) == (geometries, workers, chunk)
    )
    return chunk, f"{row.efficiency:.0%}", row.seconds / 60.0
