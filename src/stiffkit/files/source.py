"""A file on disk: read safely, and known by its hash."""

from __future__ import annotations

import hashlib
import stat
from dataclasses import dataclass
from pathlib import Path

from stiffkit.errors import FileError

LARGEST_FILE = 1024 * 1024
"""Bytes; more than this is never read."""


@dataclass(frozen=True)
class Source:
    """The text of a file."""

    path: Path
    text: str
    content_hash: str
    """SHA-256 of the file's bytes, in hexadecimal."""


def read_source(path: Path) -> Source:
    """Read a text file.

    Raises FileError where it is no ordinary file, cannot be read, is larger than 1 MiB, or is
    not UTF-8 text.
    """
    content = _read_bytes(path)
    return Source(path, _decode(path, content), hashlib.sha256(content).hexdigest())


def _read_bytes(path: Path) -> bytes:
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            what = "a directory" if stat.S_ISDIR(status.st_mode) else "not an ordinary file"
            raise FileError(f"this is {what}", path=path, mend="give the path of a YAML file")
        if status.st_size > LARGEST_FILE:
            raise _too_large(path)
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise FileError("there is no such file", path=path, mend="check the path") from None
    except (OSError, ValueError) as error:
        # ValueError: a path with a NUL character.
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"cannot be read: {reason}", path=path) from None
    # It may have grown since its size was asked for.
    if len(content) > LARGEST_FILE:
        raise _too_large(path)
    return content


def _too_large(path: Path) -> FileError:
    return FileError(
        f"is larger than {LARGEST_FILE // 1024} KiB",
        path=path,
        mend="files of this kind are small; is this the right one?",
    )


def _decode(path: Path, content: bytes) -> str:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(
            f"is not UTF-8 text (byte {error.start + 1})",
            path=path,
            line=content.count(b"\n", 0, error.start) + 1,
            mend="save it as plain text in UTF-8",
        ) from None
    if "\0" in text:
        raise FileError(
            "is not a text file (it holds NUL characters)",
            path=path,
            line=text.count("\n", 0, text.index("\0")) + 1,
            mend="save it as plain text in UTF-8",
        )
    return text
