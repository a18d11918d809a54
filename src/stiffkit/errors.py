"""The errors that a user of stiffkit can meet.

Each says what is wrong, where, and how to mend it. Commands print them and end with status 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class StiffkitError(Exception):
    """Anything that is wrong with what the user gave, and that the user can mend."""

    def __init__(self, what: str, *, mend: str = "") -> None:
        """Keep ``what`` is wrong and, if known, how to ``mend`` it."""
        super().__init__(what)
        self.what = what
        self.mend = mend

    def __str__(self) -> str:
        """Return all parts in reading order."""
        return f"{self.what}\n  mend: {self.mend}" if self.mend else self.what


class FileError(StiffkitError):
    """A file that cannot be read, or that says something wrong, with the place in it."""

    def __init__(
        self,
        what: str,
        *,
        path: Path | str,
        line: int | None = None,
        key: str = "",
        mend: str = "",
    ) -> None:
        """Keep the place: file, line (from 1) and the key's path, such as ``links.arm.beam``."""
        super().__init__(what, mend=mend)
        self.path = Path(path)
        self.line = line
        self.key = key
        self.others: tuple[FileError, ...] = ()
        """Further errors in the same file that are independent of this one."""

    def __str__(self) -> str:
        """Return ``file:line: key: what`` and the mend; other errors on lines of their own."""
        place = str(self.path) if self.line is None else f"{self.path}:{self.line}"
        key = f"{self.key}: " if self.key else ""
        return "\n".join([f"{place}: {key}{super().__str__()}", *map(str, self.others)])


class UnitError(StiffkitError):
    """A quantity that cannot be read, or that has the wrong dimension."""


class ExpressionError(StiffkitError):
    """An expression that cannot be read or evaluated."""


class LinkError(StiffkitError):
    """A link whose data no body can have."""


class FieldError(StiffkitError):
    """A displacement field, or loads, that no compliance can be told from."""


class CadError(StiffkitError):
    """A part whose geometry, interfaces or mesh cannot be worked with."""


class AssemblyError(StiffkitError):
    """A mechanism that cannot be put together at its home posture."""


class PoseError(StiffkitError):
    """A tool pose or a load that was asked for and does not fit the robot."""


class OutputError(StiffkitError):
    """A result that cannot be written."""


class MissingExtraError(StiffkitError):
    """An optional part of stiffkit that is asked for, and whose library is not installed."""

    def __init__(
        self,
        library: str,
        *,
        needed_for: str,
        extra: str,
        why: str = "is not installed",
        or_: str = "",
    ) -> None:
        """Name the ``library``, what it is ``needed_for``, and the ``extra`` that has it.

        ``or_`` is another way than to install it, if there is one.
        """
        mend = f"{how_to_install(extra)}, {or_}" if or_ else how_to_install(extra)
        super().__init__(f"{library} is needed for {needed_for} and {why}", mend=mend)
        self.extra = extra


def how_to_install(extra: str) -> str:
    """Return the command that installs an optional part."""
    return f"pip install 'stiffkit[{extra}]'"


@contextmanager
def optional(library: str, *, needed_for: str, extra: str, or_: str = "") -> Iterator[None]:
    """Guard the import of an optional library, or of what imports it.

    Raises MissingExtraError, which names the ``extra`` to install, where that fails.
    """
    try:
        yield
    except ModuleNotFoundError:
        raise MissingExtraError(library, needed_for=needed_for, extra=extra, or_=or_) from None
    except ImportError as error:
        why = f"cannot be loaded ({error})"
        raise MissingExtraError(
            library, needed_for=needed_for, extra=extra, why=why, or_=or_
        ) from None
