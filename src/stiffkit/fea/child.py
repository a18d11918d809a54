"""Work on CAD shapes in a child process, so that a crash of the CAD kernel is an error message.

Parent and child exchange JSON and NumPy files in a folder that is removed afterwards.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from stiffkit.errors import CadError, MissingExtraError

TIMEOUT = 240.0
"""s that the child may take when nothing else is said."""

MEMORY = 6e9
"""bytes that the child may use when nothing else is said."""

_LOG_LINES = 3


def is_installed() -> bool:
    """Tell whether the library that reads, meshes and solves is there."""
    return find_spec("netgen") is not None and find_spec("ngsolve") is not None


def check_installed() -> None:
    """Raise MissingExtraError if the library that reads, meshes and solves is missing."""
    if not is_installed():
        raise MissingExtraError("NGSolve", needed_for="links from CAD", extra="fea")


@contextmanager
def work_folder() -> Iterator[Path]:
    """Make a folder for the exchange with a child; it is removed at the end.

    Raises `CadError` if there is no room for it.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="stiffkit-fea-") as name:
            yield Path(name)
    except OSError as error:
        if error.filename is not None and Path(error.filename).suffix in (".step", ".stp"):
            raise
        raise CadError(
            f"the temporary folder cannot be used: {error.strerror or error}",
            mend="free some disk space, or set TMPDIR to a folder with room",
        ) from error


def run_child(
    task: str,
    folder: Path,
    job: Mapping[str, Any],
    *,
    doing: str,
    timeout: float = TIMEOUT,
    memory: float = MEMORY,
) -> dict[str, Any]:
    """Run a ``task`` of the child (see `stiffkit.fea.worker`) and return its answer.

    ``job`` is what the task needs, as JSON; files lie in ``folder``. ``doing`` says in error
    messages what was tried. Raises `CadError` if the child says so, crashes, takes longer than
    ``timeout`` s or more than ``memory`` bytes.
    """
    answer = folder / "answer.json"
    answer.unlink(missing_ok=True)
    request = {"task": task, "memory": memory, **job}
    (folder / "job.json").write_text(json.dumps(request), encoding="utf-8")
    code = _start_and_wait(folder, doing, timeout)
    said = _read_answer(answer)
    if said is None:
        raise CadError(
            f"{doing} failed: the CAD kernel {_ended(code)}{_last_words(folder / 'log.txt')}",
            mend="check the part in its CAD system (self-intersections, tiny faces, impossible "
            "fillets) and export it again",
        )
    if "error" in said:
        raise CadError(f"{doing} failed: {said['error']}", mend=str(said.get("mend", "")))
    return said


def _start_and_wait(folder: Path, doing: str, timeout: float) -> int:
    """Run the child to its end and return its exit status, negative for a signal."""
    command = [sys.executable, "-m", "stiffkit.fea.worker", str(folder)]
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with (folder / "log.txt").open("wb") as log:
        child = subprocess.Popen(  # noqa: S603 (our own interpreter, our own module)
            command,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**os.environ, **threads, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        try:
            return child.wait(timeout)
        except subprocess.TimeoutExpired as error:
            raise CadError(
                f"{doing} did not end within {timeout:g} s",
                mend="ask for a larger mesh size, suppress small features, or allow more time",
            ) from error
        finally:
            if child.poll() is None:
                child.kill()
                child.wait()


def _read_answer(path: Path) -> dict[str, Any] | None:
    """Return what the child wrote; None if it did not come to write anything whole."""
    try:
        answer = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return answer if isinstance(answer, dict) else None


def _ended(code: int) -> str:
    if code < 0:
        try:
            return f"crashed ({signal.Signals(-code).name})"
        except ValueError:
            return f"crashed (signal {-code})"
    return f"ended with status {code}"


def _last_words(log: Path) -> str:
    """Return the last lines that the child printed, as an appendix to a sentence."""
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    except OSError:
        return ""
    kept = [line.strip() for line in lines if line.strip()][-_LOG_LINES:]
    return f"; its last words: {' | '.join(kept)}" if kept else ""
