"""The robots that come with stiffkit."""

from __future__ import annotations

import os
from pathlib import Path

from stiffkit.errors import FileError
from stiffkit.files.names import suggest

_FOLDER = Path(__file__).with_name("catalogue")
_SUFFIX = ".yaml"


def list_robots() -> tuple[str, ...]:
    """Return the names of the catalogue's robots, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*" + _SUFFIX)))


def find_robot(path_or_name: str | Path) -> Path:
    """Return the path of a robot file.

    A text with a folder or a suffix is a path, a bare name one of the catalogue, or else of a file
    here. Raises FileError where there is no such file or robot.
    """
    path = Path(path_or_name)
    if isinstance(path_or_name, Path) or path.suffix or _has_folder(path_or_name):
        if not os.path.lexists(path):
            raise _not_found(path, "there is no such file")
        return path
    name = path_or_name
    if name in list_robots():
        return _FOLDER / (name + _SUFFIX)
    if name and os.path.lexists(path):
        return path
    raise _not_found(path, "there is no robot of this name in the catalogue, and no such file")


def _has_folder(text: str) -> bool:
    return any(separator and separator in text for separator in ("/", os.sep, os.altsep))


def _not_found(path: Path, what: str) -> FileError:
    return FileError(
        what,
        path=path,
        mend=f"check the path; of the catalogue: {suggest(path.stem, list_robots())}",
    )
