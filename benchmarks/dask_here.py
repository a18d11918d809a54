"""A Dask cluster on this machine: a scheduler and workers, each a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
_PATIENCE = 60.0
"""Seconds for the workers to be there."""


@dataclass(frozen=True, eq=False)
class DaskHere:
    """A cluster that is running."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


@contextmanager
def dask_here(workers: int, folder: Path) -> Iterator[DaskHere]:
    """Give a cluster whose workers are not replaced when they die, and end it afterwards."""
    address_file = folder / "scheduler.json"
    with ExitStack() as stack:
        scheduler = stack.enter_context(
            _process(
                *("-m", "distributed.cli.dask_scheduler", "--scheduler-file", str(address_file)),
                *("--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0"),
            )
        )
        started = [
            stack.enter_context(
                _process(
                    *("-m", "distributed.cli.dask_worker", "--scheduler-file", str(address_file)),
                    *("--nthreads", "1", "--no-nanny", "--no-dashboard"),
                    *("--local-directory", str(folder)),
                )
            )
            for _ in range(workers)
        ]
        address = _address(address_file)
        if workers:
            _wait(address, workers)
        yield DaskHere(address, scheduler, started)


@contextmanager
def idle_workers(address: str, count: int) -> Iterator[None]:
    """Give workers of a scheduler that share one process, for tasks that do nothing."""
    with _process("-m", "benchmarks.idle_workers", address, str(count)):
        _wait(address, count)
        yield


def processor_seconds(process: subprocess.Popen[bytes]) -> float:
    """Return the seconds of processors that a process has used so far."""
    fields = Path(f"/proc/{process.pid}/stat").read_text("ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def _process(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    given = os.environ.get("PYTHONPATH")
    found = [str(ROOT), *([given] if given else [])]
    settings = {
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        # Many workers in one process would do little else than look at what they are doing.
        "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    }
    process = subprocess.Popen(
        [sys.executable, *arguments],
        cwd=ROOT,
        env=os.environ | settings | {"PYTHONPATH": os.pathsep.join(found)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _address(file: Path) -> str:
    deadline = time.monotonic() + _PATIENCE
    while not file.exists():
        if time.monotonic() > deadline:
            raise TimeoutError("Dask's scheduler did not start")
        time.sleep(0.05)
    return str(json.loads(file.read_text("utf-8"))["address"])


def _wait(address: str, workers: int) -> None:
    from distributed import Client

    with Client(address, set_as_default=False) as client:  # type: ignore[no-untyped-call]
        client.wait_for_workers(workers, timeout=_PATIENCE)


def on_each(address: str, function: Callable[..., object], *arguments: object) -> None:
    """Call a function of a module once on each worker."""
    from distributed import Client

    with Client(address, set_as_default=False) as client:  # type: ignore[no-untyped-call]
        client.run(function, *arguments)
