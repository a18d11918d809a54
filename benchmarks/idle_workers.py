"""So many workers of a Dask scheduler in one process: ``python -m benchmarks.idle_workers``."""

from __future__ import annotations

import asyncio
import sys

from distributed import Worker


async def stay(address: str, count: int) -> None:
    """Start workers, and wait until somebody ends this process."""
    workers = [Worker(address, nthreads=1, dashboard=False, name=f"idle {i}") for i in range(count)]
    await asyncio.gather(*workers)
    await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(stay(sys.argv[1], int(sys.argv[2])))
