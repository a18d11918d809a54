"""Where a part comes from: a CAD file, a registered parametric part, or a user's own function."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from stiffkit.errors import CadError, FileError
from stiffkit.fea.child import check_installed, run_child, work_folder
from stiffkit.fea.geometry import MM, Part, build_part, build_registered, read_step
from stiffkit.fea.parts import find_part
from stiffkit.files import Entry
from stiffkit.files.write import write_bytes

CAD_SUFFIXES = (".step", ".stp", ".brep")


class PartSource(Protocol):
    """Anything that gives a part."""

    @property
    def name(self) -> str:
        """What the part is called in results."""

    @property
    def kind(self) -> str:
        """How the part is made; results that differ in it differ."""

    def digest(self) -> str:
        """Return the SHA-256 of what the shape depends on. Raises FileError or CadError."""

    def read(self, scale: float | None) -> Part:
        """Return the part, its lengths multiplied by ``scale``. Raises FileError or CadError."""

    def as_plain(self) -> dict[str, Any]:
        """Return what the part comes from as plain values, SI."""


@dataclass(frozen=True)
class CadFile:
    """A part in a STEP or BREP file."""

    path: Path

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

    @property
    def kind(self) -> str:
        """The file's suffix."""
        return self.path.suffix.lower()

    def digest(self) -> str:
        """Return the SHA-256 of the file."""
        return hashlib.sha256(_bytes(self.path)).hexdigest()

    def read(self, scale: float | None) -> Part:
        """Return the part that the file holds."""
        return read_step(self.path, scale=scale)

    def as_plain(self) -> dict[str, Any]:
        """Return the file's path."""
        return {"file": str(self.path)}


@dataclass(frozen=True, eq=False)
class RegisteredPart:
    """A parametric part of this package (`stiffkit.fea.parts`), with all its dimensions.

    Raises `CadError` if there is no such part, or its dimensions do not fit together.
    """

    name: str
    dimensions: Mapping[str, float] = field(default_factory=dict)
    """SI; those that are not given have their defaults."""

    def __post_init__(self) -> None:
        """Fill in the defaults."""
        object.__setattr__(self, "dimensions", find_part(self.name).complete(self.dimensions))

    @property
    def kind(self) -> str:
        """That it is parametric."""
        return "parametric"

    def digest(self) -> str:
        """Return the SHA-256 of name, dimensions and edition."""
        content = [self.name, dict(self.dimensions), find_part(self.name).edition]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def read(self, scale: float | None) -> Part:
        """Build the part in a child process."""
        _no_scale(scale)
        return build_registered(self.name, self.dimensions, self.digest())

    def as_plain(self) -> dict[str, Any]:
        """Return name, dimensions (SI) and edition."""
        edition = find_part(self.name).edition
        return {"part": self.name, "dimensions": dict(self.dimensions), "edition": edition}


@dataclass(frozen=True, eq=False)
class PythonPart:
    """A part that a user's own Python function makes with `netgen.occ`, in a child process.

    The script runs with the user's rights: it is for Python only, and no file can name one.
    """

    script: Path | str
    """The Python file."""
    function: str
    """Its function, which returns a shape."""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    """What the function is called with: anything that JSON can say."""
    unit: float = MM
    """m: the unit of length that the function builds in."""

    @property
    def name(self) -> str:
        """The function's name."""
        return self.function

    @property
    def kind(self) -> str:
        """That it is a script's."""
        return "script"

    def digest(self) -> str:
        """Return the SHA-256 of the script's text, the function's name and the arguments."""
        given = json.dumps([self.function, dict(self.arguments), self.unit], sort_keys=True)
        return hashlib.sha256(_bytes(Path(self.script)) + given.encode()).hexdigest()

    def read(self, scale: float | None) -> Part:
        """Call the function in a child process."""
        _no_scale(scale)
        return build_part(self.script, self.function, self.arguments, unit=self.unit)

    def as_plain(self) -> dict[str, Any]:
        """Return the script's path, the function's name and the arguments."""
        return {
            "script": str(self.script),
            "function": self.function,
            "arguments": dict(self.arguments),
        }


def write_step(part: RegisteredPart, path: Path) -> None:
    """Write a parametric part as STEP, whole or not at all.

    Raises `CadError` if it cannot be built, and `OutputError` if the file cannot be written.
    """
    check_installed()
    with work_folder() as folder:
        job = {"part": part.name, "dimensions": dict(part.dimensions)}
        run_child("export", folder, job, doing=f"{part.name}: writing STEP")
        content = (folder / "part.step").read_bytes()
    write_bytes(content, path)


def read_source_of_part(entry: Entry) -> PartSource:
    """Return the part that a specification names by a file, or by a registered part's name.

    ``entry`` is a text, the name of a file beside the one that it stands in, or a mapping with
    ``part`` and, where they differ from the defaults, ``dimensions``. Raises FileError where there
    is no such file or part, or its dimensions do not fit together.
    """
    if isinstance(entry.node.value, dict):
        return _registered(entry)
    path = entry.path.parent / entry.text()
    if path.suffix.lower() not in CAD_SUFFIXES:
        raise entry.error(
            f"'{entry.text()}' is not the name of a CAD file",
            f"export the part as STEP; names end in {', '.join(CAD_SUFFIXES)}; a parametric part "
            "is named by 'part:'",
        )
    if not path.is_file():
        raise entry.error(
            f"there is no file '{path}'", "its name is taken relative to the file that names it"
        )
    return CadFile(path)


def _registered(entry: Entry) -> RegisteredPart:
    named, given = entry["part"], entry.get("dimensions")
    try:
        part = find_part(named.text())
    except CadError as error:
        raise named.error(error.what, error.mend) from None
    values: dict[str, float] = {}
    for name, value in [] if given is None else given.items():
        try:
            unit = part.dimension(name).unit
        except CadError as error:
            raise value.error(error.what, error.mend) from None
        values[name] = value.positive(unit)
    try:
        return RegisteredPart(part.name, values)
    except CadError as error:
        raise (named if given is None else given).error(error.what, error.mend) from None


def _no_scale(scale: float | None) -> None:
    if scale is not None:
        raise CadError(
            "'scale' is for files that state a wrong unit, and this part is built from dimensions",
            mend="remove it, and change the dimensions instead",
        )


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise FileError(f"cannot be read: {error.strerror or error}", path=path) from None
