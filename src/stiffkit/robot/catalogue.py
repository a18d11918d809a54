"""The robots that come with stiffkit."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stiffkit.errors import FileError
from stiffkit.files.names import suggest
from stiffkit.files.source import read_source
from stiffkit.files.tree import read_tree

_FOLDER = Path(__file__).with_name("catalogue")
_SUFFIX = ".yaml"


def list_robots() -> tuple[str, ...]:
    """Return the names of the catalogue's robots, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*" + _SUFFIX)))


@dataclass(frozen=True)
class CatalogueRobot:
    """A robot of the catalogue, as far as its file tells without being loaded."""

    name: str
    title: str
    from_cad: bool
    """Whether links are solved by finite elements when the robot is loaded for the first time."""


def describe_robots() -> tuple[CatalogueRobot, ...]:
    """Return what the catalogue holds, sorted by name."""
    return tuple(_describe(name) for name in list_robots())


def _describe(name: str) -> CatalogueRobot:
    source = read_source(_FOLDER / (name + _SUFFIX))
    root = read_tree(source)
    title = root.child("robot")
    from_cad = any(key == "cad" for key in _keys(root.plain()))
    return CatalogueRobot(name, "" if title is None else str(title.value), from_cad)


def _keys(plain: object) -> Iterator[str]:
    """Yield every key of a file, however deep."""
    if isinstance(plain, dict):
        yield from plain
        plain = list(plain.values())
    for value in plain if isinstance(plain, list) else ():
        yield from _keys(value)


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
    meant = suggest(path.stem, list_robots())
    if meant.startswith("did you mean"):
        return FileError(what, path=path, mend=f"check the path; of the catalogue: {meant}")
    mend = "check the path; 'stiffkit robots' lists the catalogue"
    return FileError(what, path=path, mend=mend)
