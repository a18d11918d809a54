"""Several errors of one file, told at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from stiffkit.errors import FileError

_MOST_TOLD = 8


class Problems:
    """Collects errors of independent parts of a file."""

    def __init__(self) -> None:
        """Begin with none."""
        self.errors: list[FileError] = []

    @contextmanager
    def collect(self) -> Iterator[None]:
        """Keep an error that is raised inside, and go on."""
        try:
            yield
        except FileError as error:
            self.errors.append(error)

    def check(self) -> None:
        """Raise what has been collected, if anything has."""
        raise_all(self.errors)


def raise_all(errors: Sequence[FileError]) -> None:
    """Raise the error that stands first in the file, with the others in its ``others``.

    Of errors that say the same of the same place, as copies of a wrong link do, one is told.
    """
    if not errors:
        return
    distinct = {str(error): error for error in errors}
    first, *others = sorted(distinct.values(), key=lambda error: error.line or 0)
    first.others = tuple(others[: _MOST_TOLD - 1])
    raise first
