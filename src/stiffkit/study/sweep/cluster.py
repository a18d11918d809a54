"""Chunks on a cluster of Dask: https://distributed.dask.org."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import StiffkitError, optional
from stiffkit.study.sweep.engine import Rows
from stiffkit.study.sweep.executors import Chunk
from stiffkit.study.sweep.work import Reference, as_given, compute_chunk

Array = NDArray[np.float64]

_AHEAD = 4
"""Chunks that each thread of the cluster is given, and is given anew when half of them are done:
none waits for the next, and the scheduler gets a few long messages in place of many short ones."""
_FEWEST = 8
_PATIENCE = 10.0
"""Seconds that a scheduler has to answer."""
_ASKED_EVERY = 1.0
"""Seconds after which the number of threads is asked for again: the answer is long where they are
many."""


class Cluster:
    """The workers of a scheduler that is running already."""

    def __init__(self, address: str, tell: Callable[[str], None]) -> None:
        """Take the scheduler's address, such as tcp://host:8786, and what is told news.

        Raises StiffkitError where Dask is not installed, or the scheduler does not answer.
        """
        with optional("Dask's 'distributed'", needed_for="a cluster", extra="cluster"):
            from distributed import Client as Connection
        try:
            connect: Any = Connection
            self._client = connect(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise StiffkitError(
                f"the scheduler at {address} does not answer: {error}",
                mend="start one with 'dask scheduler', and workers with 'dask worker ADDRESS"
                " --nthreads 1'",
            ) from None
        tell(f"dashboard: {self._client.dashboard_link}")

    def run(
        self, job: dict[str, Any], reference: Reference, chunks: Sequence[Chunk]
    ) -> Generator[tuple[int, Rows], None, None]:
        """Yield the rows of each chunk, see `Executor`."""
        import distributed

        client: Any = self._client
        try:
            # A task like others, so that it can be had again where the worker that has it dies;
            # each worker fetches it once, from another one. Its name does not begin like the
            # chunks': Dask would not see that these are all alike, and think about each one.
            name = f"stiffkit-{job['key'][:12]}"
            shared = client.submit(as_given, reference, key=f"reference-{name}", pure=False)
            waiting = list(reversed(chunks))
            running: dict[str, int] = {}
            collect: Any = distributed.as_completed
            finished = collect(loop=client.loop)
            threads = _Threads(client)

            def fill() -> None:
                most = max(_FEWEST, _AHEAD * threads.count())
                if not waiting or 2 * len(running) > most:
                    return
                given = [waiting.pop() for _ in range(min(len(waiting), most - len(running)))]
                keys = [f"{name}-{number}" for number, _ in given]
                running.update(zip(keys, (number for number, _ in given), strict=True))
                values = [values for _, values in given]
                n = len(given)
                finished.update(
                    client.map(compute_chunk, [job] * n, [shared] * n, values, key=keys, pure=False)
                )

            fill()
            for future in finished:
                try:
                    rows = future.result()
                except distributed.KilledWorker as error:
                    raise StiffkitError(
                        f"workers died again and again: {error}",
                        mend="see whether they have enough memory, and their logs",
                    ) from None
                yield running.pop(future.key), rows
                future.release()
                fill()
        finally:
            client.close()


class _Threads:
    """Counts the threads of all workers, which come and go."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._asked = -math.inf
        self._count = 0

    def count(self) -> int:
        now = time.monotonic()
        if now - self._asked >= _ASKED_EVERY:
            self._asked, self._count = now, sum(self._client.nthreads().values())
        return self._count
