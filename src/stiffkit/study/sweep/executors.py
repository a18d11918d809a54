"""Where chunks are computed: in this process, in others beside it, or on a cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import StiffkitError
from stiffkit.study.sweep.engine import Rows
from stiffkit.study.sweep.work import Reference, compute_chunk

Array = NDArray[np.float64]
Chunk = tuple[int, Array]
"""Its number, and the values (k, n) of the varied parameters of its geometries."""

MOST_TRIES = 4
"""How often a chunk is given to a worker before the workers' deaths are held to be its fault."""


class Executor(Protocol):
    """Computes chunks, in any order."""

    def run(
        self, job: dict[str, Any], reference: Reference, chunks: Sequence[Chunk]
    ) -> Generator[tuple[int, Rows], None, None]:
        """Yield the rows of each chunk, with its number, as they are finished.

        What is running ends when the generator is closed. Raises StiffkitError where a chunk cannot
        be computed.
        """
        ...


class InProcess:
    """Chunk by chunk in this process."""

    def run(
        self, job: dict[str, Any], reference: Reference, chunks: Sequence[Chunk]
    ) -> Generator[tuple[int, Rows], None, None]:
        """Yield the rows of each chunk, see `Executor`."""
        for number, values in chunks:
            yield number, compute_chunk(job, reference, values)


class Processes:
    """So many processes on this machine; one that dies is replaced."""

    def __init__(self, workers: int) -> None:
        """Take the number of processes."""
        self.workers = workers

    def run(
        self, job: dict[str, Any], reference: Reference, chunks: Sequence[Chunk]
    ) -> Generator[tuple[int, Rows], None, None]:
        """Yield the rows of each chunk, see `Executor`."""
        waiting = list(reversed(chunks))
        tries: dict[int, int] = {}
        while waiting:
            lost: list[Chunk] = []
            yield from self._until_broken(job, reference, waiting, lost)
            for number, values in lost:
                tries[number] = tries.get(number, 0) + 1
                if tries[number] >= MOST_TRIES:
                    raise StiffkitError(
                        f"worker processes died {MOST_TRIES} times at chunk {number}",
                        mend="see whether there is enough memory; fewer workers, or fewer postures,"
                        " need less",
                    )
                waiting.append((number, values))

    def _until_broken(
        self,
        job: dict[str, Any],
        reference: Reference,
        waiting: list[Chunk],
        lost: list[Chunk],
    ) -> Generator[tuple[int, Rows], None, None]:
        """Yield rows until all is done or a process dies; what is then lost goes into ``lost``."""
        pool = ProcessPoolExecutor(
            self.workers, multiprocessing.get_context("spawn"), _begin, (job, reference)
        )
        running: dict[Future[Rows], Chunk] = {}
        try:
            while waiting or running:
                while waiting and len(running) < 2 * self.workers and not lost:
                    chunk = waiting.pop()
                    try:
                        running[pool.submit(_compute, chunk[1])] = chunk
                    except BrokenProcessPool:
                        lost.append(chunk)
                if not running:
                    return
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    chunk = running.pop(future)
                    try:
                        rows = future.result()
                    except BrokenProcessPool:
                        lost.append(chunk)
                        continue
                    yield chunk[0], rows
        finally:
            # Left alone, the pool would wait for the chunks in hand.
            for process in list((pool._processes or {}).values()):
                process.terminate()
            pool.shutdown(wait=True, cancel_futures=True)


_given: tuple[dict[str, Any], Reference]


def _begin(job: dict[str, Any], reference: Reference) -> None:
    """Make a process a worker: it leaves Ctrl+C to the one that started it, and ends with it."""
    global _given
    _given = job, reference
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _compute(values: Array) -> Rows:
    return compute_chunk(*_given, values)
