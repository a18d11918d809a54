"""A large text file, looked at in place: its lines, blocks of equal rows, numbers of lines."""

from __future__ import annotations

import mmap
from pathlib import Path

import numpy as np

from stiffkit.errors import FileError
from stiffkit.identify.readers.columns import Bytes

STRIDE = 1 << 24
"""Bytes looked through at once where lines are counted."""


class Lines:
    """The text of a file, mapped into memory; places are bytes from its start."""

    def __init__(self, path: Path) -> None:
        """Map a file that is not empty."""
        self.path = path
        with path.open("rb") as file:
            self._text = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self.size = len(self._text)

    def line(self, at: int) -> tuple[bytes, int]:
        """Return the line that starts at a place, and where the next one starts."""
        end = self._text.find(b"\n", at)
        end = self.size if end < 0 else end
        return self._text[at:end].rstrip(b"\r"), end + 1

    def find(self, mark: bytes, at: int) -> int | None:
        """Return where the first line that begins with a mark starts, at a line's start or on."""
        found = self._text.find(b"\n" + mark, at - 1)
        return None if found < 0 else found + 1

    def bytes(self, start: int, end: int) -> Bytes:
        """Return characters as numbers, not copied."""
        return np.frombuffer(self._text, np.uint8, end - start, start)

    def rows(self, start: int, end: int, width: int) -> Bytes:
        """Return the lines of a block as rows (n, at least ``width`` + 1) of characters.

        Raises ``FileError`` naming the first line that is not as long as the others, is shorter
        than ``width``, or does not begin with `` -1``.
        """
        _, after = self.line(start)
        length = min(after, end) - start
        if length == 0:
            return np.empty((0, width + 1), np.uint8)
        rows = self.bytes(start, start + (end - start) // length * length).reshape(-1, length)
        fit = (rows[:, :3] == np.frombuffer(b" -1", np.uint8)).all(axis=1)
        fit &= rows[:, -1] == ord("\n")
        if length <= width or not fit.all() or rows.size != end - start:
            row = len(rows) if fit.all() else int(np.argmin(fit))
            raise self.error(
                f"the row is not in its {width} fixed columns",
                start if length <= width else start + row * length,
                mend="the file is damaged or was edited: export it again",
            )
        return rows

    def line_number(self, at: int) -> int:
        """Return the number, from one, of the line that a place is in."""
        pieces = (self._text[a : min(a + STRIDE, at)] for a in range(0, at, STRIDE))
        return 1 + sum(piece.count(b"\n") for piece in pieces)

    def error(self, what: str, at: int, mend: str) -> FileError:
        """Return an error at a place."""
        return FileError(what, path=self.path, line=self.line_number(at), mend=mend)

    def cut_off(self, where: str) -> FileError:
        """Return the error of a file that ends too early."""
        return self.error(
            f"the file ends {where}",
            self.size,
            mend="the solver was stopped or the copy is incomplete: solve or copy again",
        )
