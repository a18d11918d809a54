"""Reading by somebody else's library, in a process of its own.

These libraries print, warn and exit as they please, and crash the process on files that are cut
off or damaged. In a child process all that stays there: what comes back is either the content of
the file or one error. The child may use as much memory as is free, not more.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import FileError, StiffkitError
from stiffkit.identify.readers.content import FieldFile

CHILD = "stiffkit.identify.readers.child"
ARRAYS, ERROR = "content.npz", "error.json"
"""What the child leaves behind."""


def read_isolated(reader: str, path: Path, bulk: Path | None = None) -> FieldFile:
    """Return what the module ``reader`` of this package reads from a file, in a child process.

    ``bulk`` is a second file, for formats whose results come without coordinates. Raises
    ``FileError`` for whatever goes wrong with the file, ``StiffkitError`` where the library is
    not installed.
    """
    with tempfile.TemporaryDirectory(prefix="stiffkit-") as folder:
        beside = [] if bulk is None else [str(bulk.resolve())]
        done = subprocess.run(  # noqa: S603 - our own interpreter, file names as arguments
            [sys.executable, "-P", "-m", CHILD, reader, str(path.resolve()), folder, *beside],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            env=_environment(),
            check=False,
        )
        failure = Path(folder, ERROR)
        if failure.exists():
            raise _told_error(json.loads(failure.read_text(encoding="utf-8")), path)
        if done.returncode != 0 or not Path(folder, ARRAYS).exists():
            raise _crash(path, done.returncode, done.stderr)
        return _load(Path(folder, ARRAYS), path)


def _environment() -> dict[str, str]:
    """Return the child's environment: this very package, no threads, no warnings."""
    home = str(Path(__file__).parents[3])
    paths = [home, *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    quiet = {"PYTHONPATH": os.pathsep.join(paths), "PYTHONWARNINGS": "ignore"}
    return {**os.environ, **threads, **quiet}


def _told_error(told: Mapping[str, Any], path: Path) -> StiffkitError:
    """Return the error that the child wrote down."""
    if told["path"] is None:
        return StiffkitError(told["what"], mend=told["mend"])
    where = path if told["path"] == str(path.resolve()) else told["path"]
    return FileError(told["what"], path=where, line=told["line"], mend=told["mend"])


def _crash(path: Path, status: int, stderr: bytes) -> FileError:
    """Return the error of a child that ended without a word."""
    reason = f"status {status}"
    if status < 0:
        reason = signal.Signals(-status).name
    lines = stderr.decode("utf-8", "replace").strip().splitlines()
    last = f": {lines[-1]}" if lines and status > 0 else ""
    return FileError(
        f"the reader ended with {reason}{last}",
        path=path,
        mend="the file is cut off, damaged or of another format: export it again",
    )


def _load(arrays: Path, path: Path) -> FieldFile:
    """Return the content that the child wrote."""
    with np.load(arrays, allow_pickle=False) as stored:
        told = json.loads(str(stored["told"]))
        groups = {
            group: {name: stored[f"{group}{place}"] for place, name in enumerate(told[group])}
            for group in ("cases", "sets", "facets")
        }
        return FieldFile(path, told["format"], stored["ids"], stored["points"], **groups)
