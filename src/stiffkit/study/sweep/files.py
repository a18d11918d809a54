"""Files of a study: whole or not there, and known by a checksum."""

from __future__ import annotations

import hashlib
import io
import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import OutputError

Arrays = Mapping[str, NDArray[np.generic]]
_CHECKSUM = "checksum"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file beside its place and move it there.

    Raises OutputError where that is not possible; the place is then as it was.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        raise OutputError(
            f"{path} cannot be written: {error.strerror or error}",
            mend="make room; the same command then goes on where it stopped",
        ) from error
    finally:
        partial.unlink(missing_ok=True)


def write_arrays(path: Path, arrays: Arrays) -> None:
    """Write arrays with a checksum. Raises OutputError where that is not possible."""
    content = io.BytesIO()
    checksum = np.frombuffer(digest(arrays), dtype=np.uint8)
    np.savez(content, allow_pickle=False, **{**arrays, _CHECKSUM: checksum})
    write_whole(path, content.getvalue())


def read_arrays(path: Path) -> dict[str, NDArray[np.generic]] | None:
    """Return arrays that `write_arrays` wrote; None where they are not there, or damaged."""
    try:
        with path.open("rb") as content, np.load(content, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    checksum = arrays.pop(_CHECKSUM, None)
    if checksum is None or checksum.tobytes() != digest(arrays):
        return None
    return arrays


def digest(arrays: Arrays) -> bytes:
    """Return a hash of arrays with their names, types and shapes."""
    found = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        found.update(f"{name} {array.dtype.str} {array.shape};".encode())
        found.update(array.tobytes())
    return found.digest()


@contextmanager
def alone_in(directory: Path) -> Iterator[None]:
    """Keep other processes from working on the same study.

    Raises OutputError if one does. Whatever ends this process lets others in again.
    """
    try:
        import fcntl
    except ImportError:
        # Windows has no such locks; there it is left to the user.
        yield
        return
    with (directory / ".lock").open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(
                f"another process is working on the study in {directory}",
                mend="wait for it, or end it",
            ) from None
        yield
