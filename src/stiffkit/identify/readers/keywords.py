"""The lines of an input deck in Abaqus's language, as keywords with their options and data.

CalculiX, and exports of Gmsh, PrePoMax, HyperMesh and many others, share it (Abaqus Keywords Guide,
"Input syntax rules"): a keyword line begins with ``*``, a comment with ``**``, words do not
distinguish upper and lower case, data are parted by commas.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stiffkit.errors import FileError
from stiffkit.identify.readers.source import check_file

OPTION = re.compile(r'\s*([^=,]+?)\s*(?:=\s*("[^"]*"|[^,]*?)\s*)?(?:,|$)')
DEEPEST = 8
"""Most levels of files that include others."""


@dataclass(frozen=True)
class Keyword:
    """One keyword: its name in upper case, its options, and its lines of data."""

    name: str
    options: dict[str, str]
    data: list[str]
    path: Path
    line: int

    def error(self, what: str, mend: str, below: int = 0) -> FileError:
        """Return an error at the keyword's line, or so many lines of data ``below``."""
        return FileError(
            what, path=self.path, line=self.line + below, key=f"*{self.name}", mend=mend
        )

    def rows(self) -> Iterator[list[str]]:
        """Return the words of each line of data, without empty ones at the end."""
        for line in self.data:
            words = [word.strip() for word in line.rstrip().rstrip(",").split(",")]
            if words != [""]:
                yield words


def read_keywords(path: Path, level: int = 0) -> Iterator[Keyword]:
    """Return the keywords of a deck and of the files it includes.

    Included files must lie in the deck's own directory or below it.
    """
    check_file(path)
    current: Keyword | None = None
    for number, line in enumerate(_lines(path), 1):
        if line.startswith("**") or not line.strip():
            continue
        if not line.lstrip().startswith("*"):
            if current is not None:
                current.data.append(line)
            continue
        if current is not None:
            yield from _with_included(current, level)
        name, _, options = line.lstrip()[1:].partition(",")
        current = Keyword(" ".join(name.upper().split()), _options(options), [], path, number)
    if current is None:
        raise FileError("there are no keywords", path=path, mend="give an input deck, *NODE, *NSET")
    yield from _with_included(current, level)


def _lines(path: Path) -> Iterator[str]:
    with path.open(encoding="utf-8", errors="replace", newline=None) as file:
        yield from file


def _options(text: str) -> dict[str, str]:
    """Return options by name in upper case; those without a value are empty."""
    found = OPTION.findall(text.strip())
    return {name.upper(): value.strip('"') for name, value in found}


def _with_included(keyword: Keyword, level: int) -> Iterator[Keyword]:
    """Return a keyword, or in place of *INCLUDE those of the file."""
    if keyword.name != "INCLUDE":
        yield keyword
        return
    home = keyword.path.parent.resolve()
    other = (home / keyword.options.get("INPUT", "")).resolve()
    if level >= DEEPEST or not other.is_relative_to(home) or other.is_dir():
        raise keyword.error(
            f"the file '{keyword.options.get('INPUT', '')}' is not followed",
            mend="put it beside the deck, and let no file include itself",
        )
    yield from read_keywords(other, level + 1)
