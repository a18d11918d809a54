"""A file before it is read: that it is one, that it fits into memory, and what it looks like."""

from __future__ import annotations

import struct
from pathlib import Path

from stiffkit.errors import FileError

HEAD = 4096
"""Bytes from which a format is recognised."""

WORDS_OF_NO_OTHER = (
    ("mesh", b"<VTKFile"),
    ("mesh", b"# vtk DataFile"),
    ("mesh", b"$MeshFormat"),
    ("mesh", b"<Xdmf"),
    ("mesh", b"\x89HDF\r\n"),
)
ANSYS_RESULT, NASTRAN_MARKERS = 12, (4, 8)
"""The file number of a result file, and the lengths of the first record."""


def check_file(path: Path) -> int:
    """Return the size in bytes of a regular file that holds something.

    Raises ``FileError`` for a missing file, a directory, a device, an empty or a locked file.
    """
    if path.is_dir():
        raise FileError("this is a directory", path=path, mend="give the file in it")
    if not path.exists():
        raise FileError("no such file", path=path, mend="check the name and the directory")
    if not path.is_file():
        raise FileError("this is not a regular file", path=path, mend="give a file on disk")
    try:
        with path.open("rb") as file:
            empty = not file.read(1)
    except OSError as error:
        raise FileError(
            f"it cannot be opened: {error.strerror}", path=path, mend="check the permissions"
        ) from None
    if empty:
        raise FileError("the file is empty", path=path, mend="export it again")
    return path.stat().st_size


def check_memory(path: Path, size: int, bytes_per_byte: float) -> None:
    """Refuse a file that would need more memory than there is."""
    free = available_memory()
    need = int(size * bytes_per_byte)
    if free is not None and need > free:
        raise FileError(
            f"reading its {size / 1e9:.3g} GB takes about {need / 1e9:.3g} GB of memory, "
            f"and {free / 1e9:.3g} GB are free",
            path=path,
            mend="export fewer nodes, results or load cases, or use a larger computer",
        )


def available_memory() -> int | None:
    """Return the bytes that this process could still use; None where the system does not say."""
    try:
        text = Path("/proc/meminfo").read_text(encoding="ascii")
    except OSError:
        return None
    fields = dict(line.split(":", 1) for line in text.splitlines() if ":" in line)
    return int(fields["MemAvailable"].split()[0]) * 1024 if "MemAvailable" in fields else None


def read_head(path: Path) -> bytes:
    """Return the first few kilobytes."""
    with path.open("rb") as file:
        return file.read(HEAD)


def recognise(head: bytes) -> str | None:
    """Return the name of the format that a file's beginning can only be of, or None."""
    if head[:4].isspace() and head[4:6] in (b"1C", b"1U"):
        return "frd"
    for name, word in WORDS_OF_NO_OTHER:
        if word in head[:512]:
            return name
    if len(head) < 12:
        return None
    for order in "<>":
        first, _, number = struct.unpack(f"{order}3i", head[:12])
        if number == ANSYS_RESULT and 0 < first <= 1000:
            return "rst"
        if first in NASTRAN_MARKERS:
            return "op2"
    return None


def is_text(head: bytes) -> bool:
    """Tell whether a beginning is text: no control characters but tabs and line ends."""
    return not any(byte < 32 and byte not in b"\t\n\r\f" for byte in head)
