"""CalculiX: displacements, nodes and elements of an ASCII ``.frd``.

Records have fixed columns (G. Dhondt, K. Wittig, CalculiX CrunchiX and GraphiX user's manuals,
"Result Format"), so a block of rows is one array of characters. Each step is a load case, with its
last increment; the shapes of an eigenvalue step are there under the name of a mode.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from stiffkit.errors import FileError
from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers.columns import (
    Array,
    Bytes,
    Integers,
    NotANumberError,
    floats,
    integers,
)
from stiffkit.identify.readers.content import FieldFile, common_nodes, named_nodes, places_of
from stiffkit.identify.readers.lines import Lines

NODES, CELLS, RESULT = b"2C", b"3C", b"100C"
COUNT, FORMAT, ANALYSIS = slice(24, 36), slice(73, 75), slice(56, 58)
"""Columns, in the line above a block, of its number of records, its format and its analysis."""
STEP_NUMBER, MODE_NUMBER = slice(48, 60), slice(24, 36)
"""Columns in the lines 1PSTEP and 1PMODE."""
MARK = 3
"""Columns of the mark that a row starts with: `` -1``, `` -2`` where it goes on, `` -3`` last."""
NUMBER_WIDTH = {b"0": 5, b"1": 10}
"""Columns of a node number in the short and the long format."""
KIND_WIDTH, VALUE_WIDTH = 5, 12
EIGENMODE = b"2"

KINDS = {
    1: "hexahedron",
    2: "wedge",
    3: "tetra",
    4: "hexahedron20",
    5: "wedge15",
    6: "tetra10",
    7: "triangle",
    8: "triangle6",
    9: "quad",
    10: "quad8",
}
UPRIGHT_FIRST = {
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
}
"""Where the node of each place stands in kinds that have the upright edges before the top."""


@dataclass
class _Content:
    """What has been read so far."""

    ids: Integers = field(default_factory=lambda: np.empty(0, np.int64))
    points: Array = field(default_factory=lambda: np.empty((0, 3)))
    nodes: dict[str, Integers] = field(default_factory=dict)
    cases: dict[str, Array] = field(default_factory=dict)
    cells: dict[str, list[Integers]] = field(default_factory=dict)
    step: str = ""
    mode: str = ""


def read_frd(path: Path) -> FieldFile:
    """Return the steps' displacements, the nodes and the elements of a file."""
    lines = Lines(path)
    content = _Content()
    at = 0
    while at < lines.size:
        line, after = lines.line(at)
        key = line[:6].strip()
        if key in (NODES, CELLS, RESULT):
            end = lines.find(b" -3", after)
            if end is None:
                raise lines.cut_off("inside a block")
            _read_block(lines, content, key, at, end)
            _, after = lines.line(end)
        elif line.startswith(b"    1PSTEP"):
            content.step, content.mode = f"step {_word(line, STEP_NUMBER)}", ""
        elif line.startswith(b"    1PMODE"):
            content.mode = f", mode {_word(line, MODE_NUMBER)}"
        elif line.strip() == b"9999":
            return _field(path, content)
        at = after
    raise lines.cut_off("without the line 9999 that closes it")


def _read_block(lines: Lines, content: _Content, key: bytes, at: int, end: int) -> None:
    """Take in what matters of the block whose first line starts ``at`` and that has an ``end``."""
    line, start = lines.line(at)
    if key == RESULT:
        name, start = _result_name(lines, start, end)
        if name != b"DISP":
            return
    width = NUMBER_WIDTH.get(line[FORMAT].strip())
    if width is None:
        raise lines.error(
            "the block is binary; only the ASCII form can be read",
            at,
            mend="write it by *NODE FILE in ccx, without a binary option",
        )
    count = _word(line, COUNT)
    if key == CELLS:
        held = _read_elements(lines, content, start, end, width)
    else:
        rows = lines.rows(start, end, MARK + width + 3 * VALUE_WIDTH)
        held = len(rows)
        ids, values = _numbers(lines, rows, width, start)
        if key == NODES:
            content.ids, content.points = ids, values
        else:
            shape = content.mode or (", mode" if line[ANALYSIS].strip() == EIGENMODE else "")
            name_of_case = (content.step or f"result {len(content.cases) + 1}") + shape
            content.nodes[name_of_case], content.cases[name_of_case] = ids, values
    if count and count != str(held):
        raise lines.error(
            f"the block should have {count} records and has {held}",
            at,
            mend="the file is damaged: solve or export again",
        )


def _result_name(lines: Lines, at: int, end: int) -> tuple[bytes, int]:
    """Return the name of a result and where its rows start, after the lines -4 and -5."""
    name = b""
    while at < end:
        line, after = lines.line(at)
        if line.startswith(b" -4"):
            name = line[MARK:13].strip()
        elif not line.startswith(b" -5"):
            break
        at = after
    return name, at


def _numbers(lines: Lines, rows: Bytes, width: int, start: int) -> tuple[Integers, Array]:
    """Return node numbers (n,) and three values (n, 3) of rows of text."""
    values = MARK + width
    try:
        return (
            integers(rows[:, MARK:values]),
            floats(rows[:, values : values + 3 * VALUE_WIDTH]),
        )
    except NotANumberError as error:
        at = start + error.row * rows.shape[1]
        raise lines.error(
            f"'{error.text}' is not a number", at, mend="the file is damaged: export it again"
        ) from None


def _read_elements(lines: Lines, content: _Content, start: int, end: int, width: int) -> int:
    """Take in the elements of known kinds and return how many there are of any kind."""
    text = lines.bytes(start, end)
    starts = np.concatenate([[0], np.flatnonzero(text == ord("\n"))[:-1] + 1])
    heads = np.flatnonzero(text[starts + 2] == ord("1"))
    try:
        kinds = integers(sliding_window_view(text, KIND_WIDTH)[starts[heads] + MARK + width])
        for number in np.unique(kinds).tolist():
            kind = KINDS.get(number)
            if kind is not None:
                nodes = _element_nodes(text, starts, heads[kinds == number], kind, width)
                content.cells.setdefault(kind, []).append(nodes)
    except (ValueError, IndexError):
        raise lines.error(
            "the block of elements is not in its fixed columns",
            start,
            mend="the file is damaged: export it again",
        ) from None
    return len(heads)


def _element_nodes(
    text: Bytes, starts: Integers, heads: Integers, kind: str, width: int
) -> Integers:
    """Return node numbers (m, k), in VTK's order, from the lines after the heads of elements."""
    size = ELEMENTS[kind].size
    # The short format has 15 numbers in a line, the long one 10.
    per_line = {5: 15, 10: 10}[width]
    parts = []
    for line, first in enumerate(range(0, size, per_line)):
        count = min(per_line, size - first)
        windows = sliding_window_view(text, count * width)
        fields = windows[starts[heads + 1 + line] + MARK].reshape(-1, width)
        parts.append(integers(fields).reshape(-1, count))
    nodes = np.hstack(parts)
    return nodes[:, UPRIGHT_FIRST[kind]] if kind in UPRIGHT_FIRST else nodes


def _word(line: bytes, columns: slice) -> str:
    """Return what stands in some columns."""
    return line[columns].decode("ascii", "replace").strip()


def _field(path: Path, content: _Content) -> FieldFile:
    """Return the field of all that has been read."""
    if not content.cases:
        raise FileError(
            "it holds no displacements",
            path=path,
            mend="ask for them in each step: *NODE FILE, and U in the next line",
        )
    ids = common_nodes(path, content.nodes)
    rows = places_of(ids, content.ids)
    unplaced = rows < 0
    if unplaced.any():
        raise FileError(
            f"{named_nodes(ids[unplaced])} displaced but without coordinates",
            path=path,
            mend="the file is damaged: export it again",
        )
    facets = {kind: np.concatenate(parts) for kind, parts in content.cells.items()}
    return FieldFile(path, "frd", ids, content.points[rows], content.cases, {}, facets)
