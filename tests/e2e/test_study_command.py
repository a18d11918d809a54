"""Long studies from the command line: killed, resumed, spread over processes and a cluster."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from stiffkit.compiled import heyoka_available

from .commandline import ENDS_WITHIN, STIFFKIT, output_of, refusal_of, run

STUDY = """\
study: Arms of the five-bar
robot: five-bar
vary:
  proximal: {from: 180 mm, to: 220 mm, count: 8}
  distal: {from: 300 mm, to: 400 mm, count: 10}
postures: 300
results:
  weakest: {min: stiffness_translation_min}
  worst: {max: deflection_translation, load: push}
"""
CHUNKS = 20

pytestmark = pytest.mark.skipif(not heyoka_available(), reason="takes long without a compiler")


@pytest.fixture
def here(tmp_path: Path) -> Path:
    (tmp_path / "arms.yaml").write_text(STUDY, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return the table of the study by one process that nobody disturbs, in other chunks."""
    here = tmp_path_factory.mktemp("undisturbed")
    (here / "arms.yaml").write_text(STUDY, encoding="utf-8")
    told = output_of("study", "run", "arms.yaml", "-o", "out", "--chunk", "33", cwd=here)
    assert "80 geometries" in told
    assert "table: out/table.nc" in told
    return table_of(here)


def table_of(here: Path) -> dict[str, bytes]:
    """Return the bytes of everything in a table."""
    import xarray as xr

    with xr.open_dataset(here / "out" / "table.nc", engine="h5netcdf") as table:
        return {
            str(name): repr(v.values.tolist()).encode() if v.dtype == object else v.values.tobytes()
            for name, v in table.variables.items()
        }


def finished(here: Path) -> int:
    return len(list((here / "out" / "chunks").glob("*.npz")))


@contextmanager
def working(here: Path, *arguments: str, until: int) -> Iterator[subprocess.Popen[str]]:
    """Give a study command at work, once so many chunks are finished, and end it in any case."""
    process = subprocess.Popen(
        [STIFFKIT, "study", *arguments],
        cwd=here,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        wait_for(lambda: finished(here) >= until or process.poll() is not None)
        assert process.poll() is None, process.communicate()
        yield process
    finally:
        process.kill()
        process.communicate()


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + ENDS_WITHIN
    while not condition():
        assert time.monotonic() < deadline, "nothing happened"
        time.sleep(0.005)


def children(pid: int) -> list[int]:
    """Return the processes that a process has started, which are at work on chunks."""
    listed = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    workers = [p for p in listed if b"spawn_main" in Path(f"/proc/{p}/cmdline").read_bytes()]
    return [int(p) for p in workers]


RUN = ("run", "arms.yaml", "-o", "out", "--chunk", "4")


def test_killed_twice_and_resumed(here: Path, undisturbed: dict[str, bytes]) -> None:
    with working(here, *RUN, until=3) as process:
        process.kill()
        process.wait()
    first = finished(here)
    with working(here, "resume", "out", until=first + 3) as process:
        process.kill()
        process.wait()
    second = finished(here)
    assert first < second < CHUNKS
    status = json.loads(output_of("study", "status", "out", "--json", cwd=here))
    assert status["chunks_finished"] == second
    assert status["chunks"] == CHUNKS
    assert status["table"] is None
    before = {p.name: p.stat().st_mtime_ns for p in (here / "out" / "chunks").glob("*.npz")}
    output_of("study", "resume", "out", cwd=here)
    after = {p.name: p.stat().st_mtime_ns for p in (here / "out" / "chunks").glob("*.npz")}
    assert before.items() <= after.items(), "a finished chunk was computed again"
    assert table_of(here) == undisturbed


def test_interrupted_it_says_how_to_go_on(here: Path) -> None:
    with working(here, *RUN, until=2) as process:
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=ENDS_WITHIN)
    assert process.returncode == 130
    assert "chunks are kept" in message
    assert "stiffkit study resume out" in message
    assert "Traceback" not in message
    assert not list(here.rglob("*.partial"))
    assert "go on with: stiffkit study resume out" in output_of("study", "status", "out", cwd=here)


def test_a_worker_that_dies_is_replaced(here: Path, undisturbed: dict[str, bytes]) -> None:
    with working(here, *RUN, "--workers", "2", until=2) as process:
        os.kill(children(process.pid)[0], signal.SIGKILL)
        _, message = process.communicate(timeout=ENDS_WITHIN)
    assert process.returncode == 0, message
    assert table_of(here) == undisturbed


def test_workers_end_with_the_command(here: Path) -> None:
    with working(here, *RUN, "--workers", "2", until=1) as process:
        workers = children(process.pid)
        assert len(workers) == 2
        process.kill()
        process.wait()

    def ended(pid: int) -> bool:
        try:
            return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
        except FileNotFoundError:
            return True

    wait_for(lambda: all(map(ended, workers)))


def test_a_disk_that_is_full(here: Path, undisturbed: dict[str, bytes]) -> None:
    message = refusal_of("study", *RUN, cwd=here, limit="-f 10")
    assert "reference.npz" in message
    assert "File too large" in message
    assert "mend: " in message
    ended = run("study", *RUN, cwd=here)
    assert ended.returncode == 0, ended.stderr
    assert table_of(here) == undisturbed


def test_on_a_cluster_whose_workers_die(here: Path, undisturbed: dict[str, bytes]) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
    ) as cluster:
        address = cluster.scheduler_address
        with working(here, *RUN, "--cluster", address, until=2) as process:
            os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
            _, message = process.communicate(timeout=ENDS_WITHIN)
    assert process.returncode == 0, message
    assert "dashboard: http://" in message
    assert table_of(here) == undisturbed


def test_what_is_wrong_is_told_at_once(here: Path) -> None:
    assert "there is no study" in refusal_of("study", "resume", "nowhere", cwd=here)
    assert "does not answer" in refusal_of(
        "study", *RUN, "--cluster", "tcp://127.0.0.1:9", cwd=here
    )
    assert "no result 'worts'" in refusal_of("study", *RUN, "--by", "worts", cwd=here)
    assert "'worst'" in refusal_of("study", *RUN, "--by", "worts", cwd=here)
