"""The robot file of a design: the user's own, with other values of its parameters."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

from stiffkit import __version__
from stiffkit.errors import FileError, OutputError
from stiffkit.files import Node, Source, read_source, read_tree, suggest
from stiffkit.files.edit import Keys, replace_values
from stiffkit.files.expressions import is_expression
from stiffkit.files.parameters import Given, resolve
from stiffkit.files.write import write_bytes
from stiffkit.robot.catalogue import find_robot, list_robots
from stiffkit.units import Value, is_unit, parse_quantity, parse_unit, shorten

_MOST_DIGITS = 20
"""Enough for any float in any unit to be read back as it was."""


def write_robot_file(
    path_or_name: str | Path,
    values: Mapping[str, float | str],
    target: Path,
    *,
    folder: Path | None = None,
) -> None:
    """Write a robot file with other values of its parameters, whole or not at all.

    In the text of the file only these values change, and the names of files that it takes where
    the new place asks for it; a comment at the top says where the file comes from. Values are
    written in the unit that the file has them in, with as many digits as it takes to read the same
    float. What is read back is checked before anything is written.

    Args:
        path_or_name: a robot file, or a robot of the catalogue.
        values: of parameters, SI, by name; one that the file gives by an expression becomes a
            number. A text, such as ``= alpha * L10`` or ``310 mm``, is written as it is.
        target: the file to write; another one that is there is replaced.
        folder: where the file will stand in the end, if it is moved there later.

    Raises:
        FileError: if the robot file cannot be read, has no such parameter, or gives its value where
            it cannot be replaced.
        OutputError: if a value cannot be written, or the file cannot.
    """
    path = find_robot(path_or_name)
    if target.exists() and target.samefile(path):
        raise OutputError(
            f"{target} is the robot file itself", mend="give the new file another name"
        )
    source = read_source(path)
    robot = _RobotText(source)
    place = (target.parent if folder is None else folder).resolve()
    text = robot.with_values(values, place)
    name = f"{path.stem} of the catalogue" if _is_of_catalogue(path) else _beside(path, place)
    line_break = "\r\n" if "\r\n" in source.text else "\n"
    comment = line_break.join(robot.origin(name, values))
    write_bytes(f"{comment}{line_break}{text}".encode(), target)


class _RobotText:
    """The text of a robot file, and what in it can change."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.root = read_tree(source)
        self.given = _parameters(self.root)
        self.values = resolve(self.given)

    def with_values(self, values: Mapping[str, float | str], place: Path) -> str:
        """Return the text with other parameters, as it has to be in the folder ``place``."""
        for name, value in values.items():
            if name not in self.given:
                raise FileError(
                    f"the robot has no parameter '{name}'",
                    path=self.source.path,
                    mend=suggest(name, self.given),
                )
            if not isinstance(value, str) and not math.isfinite(value):
                raise OutputError(f"parameter {name} has no value that could be written: {value}")
        changes: dict[Keys, str] = {
            ("parameters", name): _written(name, value, self.values[name])
            for name, value in values.items()
            if not self._says(name, value)
        }
        changes |= self._moved_names(place)
        text = replace_values(self.source, changes)
        self._check(text, values, changes)
        return text

    def origin(self, name: str, values: Mapping[str, float | str]) -> Iterator[str]:
        """Yield the lines of the comment that says where the new file comes from."""
        changed = {one: value for one, value in values.items() if not self._says(one, value)}
        how = "with other values of:" if changed else "with the same values of its parameters."
        yield f"# Made by stiffkit {__version__} from {shorten(name, 200)}, {how}"
        for one, value in changed.items():
            before = shorten(str(self.given[one]))
            yield f"#   {one}: {_written(one, value, self.values[one])}, before: {before}"
        yield f"# SHA-256 of that file: {self.source.content_hash}"

    def _says(self, name: str, value: float | str) -> bool:
        """Tell whether the file gives a parameter this value, and not by an expression."""
        given = self.given[name]
        if isinstance(value, str) or (isinstance(given, str) and is_expression(given)):
            return given == value
        return parse_quantity(given).si == value

    def _moved_names(self, place: Path) -> dict[Keys, str]:
        """Return the names of files, relative to ``place``."""
        way = _way(self.source.path.resolve().parent, place)
        if way == ".":
            return {}
        return {
            keys: f"{way}/{name}"
            for keys, name in _file_names(self.root)
            if not Path(name).is_absolute()
        }

    def _check(
        self, text: str, values: Mapping[str, float | str], changes: Mapping[Keys, str]
    ) -> None:
        """Raise OutputError where a text does not say what the file says with other values."""
        root = read_tree(Source(self.source.path, text, ""))
        meant = {
            name: value if isinstance(value, str) else Value(value, self.values[name].dims)
            for name, value in values.items()
        }
        expected = resolve({**self.given, **meant})
        found = resolve(_parameters(root))
        wrong = [name for name in expected if found[name].si != expected[name].si]
        old, new = self.root.plain(), root.plain()
        for keys in changes:
            _take_out(old, keys)
            _take_out(new, keys)
        if wrong or old != new:
            raise OutputError(
                f"the parameters {', '.join(wrong or values)} cannot be written into the text of "
                f"{self.source.path} so that they are read again as they are",
                mend="give them in the robot file as plain quantities, each on a line of its own",
            )


def _parameters(root: Node) -> dict[str, Given]:
    section = root.child("parameters")
    given = {} if section is None else section.plain()
    if not isinstance(given, dict):
        return {}
    return {name: value for name, value in given.items() if isinstance(value, str | int | float)}


def _file_names(root: Node) -> Iterator[tuple[Keys, str]]:
    """Yield the places of a robot file that name another file, and what stands there."""
    repeated = root.child("repeat")
    count = len(repeated.value) if repeated is not None and isinstance(repeated.value, list) else 0
    sections: list[Keys] = [("links",), *(("repeat", n, "links") for n in range(count))]
    for section in sections:
        links = _at(root, section)
        for name in links.value if links is not None and isinstance(links.value, dict) else ():
            for ending in (("compliance",), ("cad",), ("cad", "file")):
                keys: Keys = (*section, name, *ending)
                found = _at(root, keys)
                if found is not None and isinstance(found.value, str):
                    yield keys, found.value


def _at(root: Node, keys: Keys) -> Node | None:
    node: Node | None = root
    for key in keys:
        node = None if node is None else node.child(key)
    return node


def _take_out(plain: object, keys: Keys) -> None:
    """Clear what stands in plain values under a path of keys."""
    for key in keys[:-1]:
        plain = plain[key]  # type: ignore[index]
    plain[keys[-1]] = None  # type: ignore[index]


def _written(name: str, value: float | str, like: Value) -> str:
    """Return a value in the unit of another, with the fewest digits that are read as the same."""
    return value if isinstance(value, str) else _quantity(name, value, like)


def _quantity(name: str, si: float, like: Value) -> str:
    if like.unit and not is_unit(like.unit):
        raise OutputError(
            f"parameter {name} cannot be written: no text says its unit, {like.unit}",
            mend="vary the parameters that its expression takes instead",
        )
    with localcontext(prec=40):
        exact = Fraction(si) / parse_unit(like.unit).factor
        number = Decimal(exact.numerator) / Decimal(exact.denominator)
    for digits in range(1, _MOST_DIGITS + 1):
        with localcontext(prec=digits):
            text = f"{_decimal(+number)} {like.unit}".rstrip()
        if parse_quantity(text).si == si:
            return text
    raise OutputError(f"parameter {name} cannot be written in {like.unit or 'SI'}: {si}")


def _decimal(number: Decimal) -> str:
    """Return a number as people write it: 310, 0.25, 8.5e8."""
    if number == 0 or -4 <= number.adjusted() < 6:
        return f"{number:f}"
    return f"{number:e}".replace("e+", "e")


def _is_of_catalogue(path: Path) -> bool:
    return path.stem in list_robots() and path == find_robot(path.stem)


def _beside(path: Path, place: Path) -> str:
    return f"{_way(path.resolve().parent, place)}/{path.name}".removeprefix("./")


def _way(to: Path, place: Path) -> str:
    """Return the path from one folder to another, relative where there is such a way."""
    try:
        return Path(os.path.relpath(to, place)).as_posix()
    except ValueError:
        # Another drive of Windows.
        return to.as_posix()
