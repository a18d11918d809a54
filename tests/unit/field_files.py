"""Displacement files for tests, written as the programs write them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers import FieldFile

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FRD_NUMBERS = {
    "hexahedron": 1,
    "wedge": 2,
    "tetra": 3,
    "hexahedron20": 4,
    "wedge15": 5,
    "tetra10": 6,
    "triangle": 7,
    "triangle6": 8,
    "quad": 9,
    "quad8": 10,
}
FRD_ORDER = {
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
}


def cube(kind: str = "hexahedron", cells: int = 2) -> tuple[Array, Integers]:
    """Points (n, 3) and elements (m, k) of one kind that fill the unit cube."""
    natural = ELEMENTS[kind].nodes[: ELEMENTS[kind].size]
    corners = _in_unit_cube(kind)
    pieces = [
        (corner + np.array(place)) / cells
        for place in np.ndindex(cells, cells, cells)
        for corner in corners
    ]
    assert pieces[0].shape == natural.shape
    points, which = np.unique(np.round(np.concatenate(pieces), 12), axis=0, return_inverse=True)
    return points, which.reshape(len(pieces), -1)


def _in_unit_cube(kind: str) -> list[Array]:
    """The nodes of the elements of a kind that together fill the unit cube."""
    hexahedron = (ELEMENTS["hexahedron"].nodes + 1.0) / 2.0
    parts: dict[str, list[Sequence[int]]] = {
        "hexahedron": [range(8)],
        "wedge": [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)],
        "tetra": [
            (0, 1, 2, 6),
            (0, 2, 3, 6),
            (0, 3, 7, 6),
            (0, 7, 4, 6),
            (0, 4, 5, 6),
            (0, 5, 1, 6),
        ],
    }
    shape = kind.rstrip("0123456789")
    filled = []
    for part in parts[shape]:
        # The linear shape functions at the nodes of the kind carry those to the corners.
        linear = ELEMENTS[shape]
        monomials = np.prod(ELEMENTS[kind].nodes[:, None, :] ** linear.powers, axis=2)
        own = np.prod(linear.nodes[:, None, :] ** linear.powers, axis=2)
        filled.append(monomials @ np.linalg.inv(own) @ hexahedron[list(part)])
    return filled


def field_file(
    points: Array,
    cases: Mapping[str, Array],
    cells: Mapping[str, Integers] | None = None,
    ids: Integers | None = None,
    sets: Mapping[str, Integers] | None = None,
) -> FieldFile:
    """A field; nodes are numbered from 1, elements given by rows of the points."""
    numbers = np.arange(1, len(points) + 1) if ids is None else ids
    facets = {kind: numbers[nodes] for kind, nodes in (cells or {}).items()}
    return FieldFile(Path("made.frd"), "frd", numbers, points, cases, sets or {}, facets)


def frd_text(file: FieldFile, long: bool = True, end: str = "\n") -> str:
    """The text that CalculiX writes of a field, each load case a step."""
    width, form = (10, 1) if long else (5, 0)
    count = len(file.ids)

    def rows(values: Array) -> list[str]:
        numbers = ("".join(f"{x:12.5E}" for x in row) for row in values.tolist())
        return [f" -1{n:{width}d}{text}" for n, text in zip(file.ids, numbers, strict=True)]

    lines = ["    1C", "    1UPGM               CalculiX"]
    lines += [f"    2C{'':18}{count:12d}{'':37}{form}", *rows(file.points), " -3"]
    lines += _frd_elements(file, width, form)
    for step, values in enumerate(file.cases.values(), 1):
        lines.append(f"    1PSTEP{'':14}{step:12d}{1:12d}{step:12d}")
        lines.append(f"  100CL  101 1.000000000{count:12d}{'':20} 0{step:5d}{'':10} {form}")
        lines += [" -4  DISP        4    1", " -5  D1          1    2    1    0"]
        lines += [" -5  ALL         1    2    0    0    1ALL", *rows(values), " -3"]
    return end.join([*lines, " 9999", ""])


def _frd_elements(file: FieldFile, width: int, form: int) -> list[str]:
    per_line = 10 if width == 10 else 15
    lines, number = [], 0
    for kind, nodes in file.facets.items():
        for row in nodes[:, FRD_ORDER.get(kind, list(range(nodes.shape[1])))].tolist():
            number += 1
            lines.append(f" -1{number:{width}d}{FRD_NUMBERS[kind]:5d}    0    1")
            for start in range(0, len(row), per_line):
                part = row[start : start + per_line]
                lines.append(" -2" + "".join(f"{node:{width}d}" for node in part))
    return [f"    3C{'':18}{number:12d}{'':37}{form}", *lines, " -3"] if lines else []


def csv_text(file: FieldFile, delimiter: str = ",", comma: bool = False) -> str:
    """A table of a field, the load cases as columns ``case:ux``."""
    names = ["node", *"xyz", *(f"{case}:u{axis}" for case in file.cases for axis in "xyz")]
    lines = [delimiter.join(names)]
    table = np.hstack([file.points, *file.cases.values()])
    for node, row in zip(file.ids.tolist(), table.tolist(), strict=True):
        words = [str(node), *map(repr, row)]
        text = delimiter.join(words)
        lines.append(text.replace(".", ",") if comma else text)
    return "\n".join([*lines, ""])
