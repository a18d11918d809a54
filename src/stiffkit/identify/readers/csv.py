"""Tables of text: a node per line, with its place and its displacement in one or more load cases.

The first line holds the headings (see ``headings``). Columns are parted by commas, semicolons,
tabs or spaces; with anything but commas, numbers may have a decimal comma. Lines that begin with
``#`` are comments. A column ``case`` names the load case of a line, a column ``set`` the node sets,
parted by spaces or ``|``. Without a column for the node, nodes count from one. Tables that
ParaView exports are read as they are.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import FileError
from stiffkit.identify.readers.content import Array, FieldFile, Integers, common_nodes
from stiffkit.identify.readers.headings import Headings, read_headings

EXAMPLE = "node,x,y,z,ux,uy,uz"
LARGEST_NODE = 2**53
"""Above this, floats no longer tell whole numbers apart."""
ENCODING = "utf-8-sig"


@dataclass(frozen=True)
class _Dialect:
    """How the lines of a table are written; ``start`` counts the lines up to the headings."""

    names: list[str]
    delimiter: str | None
    decimal_comma: bool
    start: int


def read_csv(path: Path) -> FieldFile:
    """Return the nodes, load cases and sets of a table."""
    dialect = _dialect(path)
    try:
        headings = read_headings(dialect.names)
    except ValueError as error:
        raise FileError(
            f"{error} among the columns {', '.join(dialect.names)}",
            path=path,
            line=dialect.start,
            mend=f"name the columns like {EXAMPLE}",
        ) from None
    numbers = _numbers(path, dialect, headings)
    if headings.case is None:
        ids = _node_numbers(path, headings, numbers)
        return _field(path, headings, ids, numbers, _sets(path, dialect, headings, ids))
    return _long_field(path, dialect, headings, numbers, headings.case)


def _field(
    path: Path, headings: Headings, ids: Integers, numbers: Array, sets: dict[str, Integers]
) -> FieldFile:
    """Return the field of a table with a line per node."""
    place, cases = _vectors(headings, numbers)
    named = {name or path.stem: values for name, values in cases.items()}
    return FieldFile(path, "csv", ids, place, named, sets)


def _long_field(
    path: Path, dialect: _Dialect, headings: Headings, numbers: Array, column: int
) -> FieldFile:
    """Return the field of a table with a line per node and load case."""
    labels = _words(path, dialect, headings, column)
    names, first = np.unique(labels, return_index=True)
    rows = {str(name): np.flatnonzero(labels == name) for name in names[np.argsort(first)]}
    parts = {name: numbers[where] for name, where in rows.items()}
    numbered = {name: _node_numbers(path, headings, part) for name, part in parts.items()}
    ids = common_nodes(path, numbered)
    every = np.concatenate(list(numbered.values()))
    in_order = np.argsort(np.concatenate(list(rows.values())), kind="stable")
    sets = _sets(path, dialect, headings, every[in_order])
    cases = {}
    for name, part in parts.items():
        for own, values in _vectors(headings, part)[1].items():
            cases[f"{name}: {own}" if own else name] = values
    place, _ = _vectors(headings, next(iter(parts.values())))
    return FieldFile(path, "csv", ids, place, cases, sets)


def _vectors(headings: Headings, numbers: Array) -> tuple[Array, dict[str, Array]]:
    """Return places (n, 3) and displacements (n, 3) by case from the columns of numbers."""
    at = {column: place for place, column in enumerate(headings.numbers)}
    triples = headings.displacements.items()
    cases = {name: numbers[:, [at[column] for column in triple]] for name, triple in triples}
    return numbers[:, [at[column] for column in headings.place]], cases


def _dialect(path: Path) -> _Dialect:
    """Find out how the table is written, from its headings and the first line below."""
    with path.open(encoding=ENCODING, errors="replace", newline=None) as file:
        lines = ((number, line) for number, line in enumerate(file, 1) if _is_row(line))
        start, header = next(lines, (1, ""))
        _, first = next(lines, (0, ""))
    header = header.rstrip("\n")
    counts = {mark: header.count(mark) for mark in "\t;,"}
    best = max(counts, key=lambda mark: counts[mark])
    delimiter = best if counts[best] else None
    names = _split(header, delimiter)
    if not first:
        raise FileError(
            "there is no line with numbers", path=path, mend=f"begin with a line like {EXAMPLE}"
        )
    if any(re.fullmatch(r"\s*[-+]?[\d.]+([eE][-+]?\d+)?\s*", name) for name in names):
        raise FileError(
            "the first line holds numbers, not the names of the columns",
            path=path,
            line=start,
            mend=f"put a line like {EXAMPLE} on top",
        )
    return _Dialect(names, delimiter, delimiter != "," and "," in first, start)


def _lines(path: Path, dialect: _Dialect) -> Iterator[str]:
    """Return the lines below the headings, with decimal points."""
    with path.open(encoding=ENCODING, errors="replace", newline=None) as file:
        for _ in range(dialect.start):
            next(file)
        for line in file:
            yield line.replace(",", ".") if dialect.decimal_comma else line


def _is_row(line: str) -> bool:
    """Tell whether a line is neither empty nor a comment."""
    return not (line.isspace() or line.startswith("#"))


def _split(line: str, delimiter: str | None) -> list[str]:
    """Return the words of a line, quoted or not."""
    try:
        return next(csv.reader([line], delimiter=delimiter)) if delimiter else line.split()
    except csv.Error:
        return line.split(delimiter)


def _load(
    path: Path, dialect: _Dialect, headings: Headings, columns: list[int], dtype: type
) -> NDArray[Any]:
    """Return some columns of the table, or raise ``FileError`` for the first line without them."""
    try:
        return np.loadtxt(
            filter(_is_row, _lines(path, dialect)),
            dtype=dtype,
            delimiter=dialect.delimiter,
            usecols=columns,
            quotechar='"',
            ndmin=2,
        )
    except ValueError:
        raise _first_fault(path, dialect, headings, columns, dtype) from None


def _numbers(path: Path, dialect: _Dialect, headings: Headings) -> Array:
    """Return the columns of numbers (n, ...), in the order of ``headings.numbers``."""
    return np.asarray(_load(path, dialect, headings, headings.numbers, float))


def _words(path: Path, dialect: _Dialect, headings: Headings, column: int) -> NDArray[np.str_]:
    """Return a column of words (n,)."""
    loaded = _load(path, dialect, headings, [column], str)
    return np.char.strip(loaded[:, 0])


def _node_numbers(path: Path, headings: Headings, numbers: Array) -> Integers:
    """Return the numbers of the nodes, counted from one where the table has none."""
    if headings.node is None:
        return np.arange(1, len(numbers) + 1)
    nodes = numbers[:, 0]
    wrong = ~((np.abs(nodes) < LARGEST_NODE) & (nodes == np.floor(nodes)))
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0])
        raise FileError(
            f"the node number {nodes[row]:g} of table row {row + 1} is not a whole number",
            path=path,
            mend="number the nodes with whole numbers",
        )
    return nodes.astype(np.int64)


def _sets(path: Path, dialect: _Dialect, headings: Headings, ids: Integers) -> dict[str, Integers]:
    """Return the node sets by name."""
    if headings.sets is None:
        return {}
    texts, which = np.unique(_words(path, dialect, headings, headings.sets), return_inverse=True)
    rows: dict[str, list[Integers]] = {}
    for place, text in enumerate(texts.tolist()):
        for name in text.replace("|", " ").split():
            rows.setdefault(name, []).append(ids[which == place])
    return {name: np.unique(np.concatenate(parts)) for name, parts in rows.items()}


def _first_fault(
    path: Path, dialect: _Dialect, headings: Headings, columns: list[int], dtype: type
) -> FileError:
    """Return the error of the first line that does not hold what the columns should."""
    for number, line in enumerate(_lines(path, dialect), dialect.start + 1):
        if not _is_row(line):
            continue
        row = _split(line.rstrip("\n"), dialect.delimiter)
        fault = _fault(row, dialect.names, columns, dtype)
        if fault:
            node = headings.node
            who = "the line"
            if node is not None and node < len(row):
                who = f"node {row[node].strip()[:40]}"
            mend = "fill in the value, or leave the line out"
            return FileError(f"{who} {fault}", path=path, line=number, mend=mend)
    return FileError("the table cannot be read", path=path, mend=f"write it like {EXAMPLE}")


def _fault(row: list[str], names: list[str], columns: list[int], dtype: type) -> str:
    """Return what is wrong with the columns of a line, or nothing."""
    for column in columns:
        name = names[column].strip()
        if column >= len(row) or (dtype is float and not row[column].strip()):
            return f"has no value of '{name}'"
        try:
            dtype(row[column])
        except ValueError:
            return f"has '{row[column].strip()[:40]}' for '{name}', which is no number"
    return ""
