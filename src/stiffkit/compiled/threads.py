"""Spreading work over the threads of this process: compiled code and NumPy let others run.

Work is cut into blocks whose size does not depend on the number of threads, and each block writes
to its own part of the results, so the numbers are the same, bit for bit, with any number of them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from contextvars import ContextVar

from stiffkit.errors import StiffkitError

_limit: ContextVar[int | None] = ContextVar("threads", default=None)
"""The number of threads that `limited_threads` asks for; 1 within a thread of `over_blocks`."""


def thread_count() -> int:
    """Return how many threads `over_blocks` uses.

    It is what `limited_threads` says, else the environment variable STIFFKIT_THREADS, else the
    number of processors that this process may run on. Raises StiffkitError if the variable is no
    whole number above zero.
    """
    limit = _limit.get()
    if limit is not None:
        return limit
    named = os.environ.get("STIFFKIT_THREADS")
    if named is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else _processors()
    if not named.isdecimal() or int(named) == 0:
        raise StiffkitError(
            f"the environment variable STIFFKIT_THREADS is '{named}'",
            mend="set it to a whole number above zero, such as 4, or not at all",
        )
    return int(named)


def _processors() -> int:
    return os.cpu_count() or 1


@contextmanager
def limited_threads(count: int | None) -> Iterator[None]:
    """Let `over_blocks` use ``count`` threads inside this context; None leaves it as it is.

    Raises ValueError if ``count`` is below one.
    """
    if count is not None and count < 1:
        raise ValueError(f"{count} threads were asked for; ask for at least one")
    token = _limit.set(_limit.get() if count is None else count)
    try:
        yield
    finally:
        _limit.reset(token)


def over_blocks(
    n: int,
    size: int,
    work: Callable[[slice], object],
    done: Callable[[int], object] | None = None,
) -> None:
    """Do some work for each block of at most ``size`` out of ``n`` postures.

    ``done`` is called in this thread with the number of postures that are finished. What ``work``
    raises is raised here, once the blocks that have begun are finished; the others are left.
    """
    blocks = [slice(start, min(start + size, n)) for start in range(0, n, size)]
    threads = min(thread_count(), len(blocks))
    told = done or (lambda _count: None)
    finished = 0
    if threads <= 1:
        for block in blocks:
            work(block)
            finished += block.stop - block.start
            told(finished)
        return
    # Work within a thread is not spread again.
    with ThreadPoolExecutor(threads, initializer=_limit.set, initargs=(1,)) as pool:
        running = {pool.submit(work, block): block for block in blocks}
        try:
            for future in as_completed(running):
                future.result()
                finished += running[future].stop - running[future].start
                told(finished)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
