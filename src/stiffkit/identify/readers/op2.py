"""Nastran: displacements of an ``.op2`` and the coordinates, elements and sets of its bulk data.

The result file numbers the nodes but does not place them, so the bulk data must lie beside it
under the same name, or be given. Displacements that a deck puts out in other coordinate systems
(the CD field of GRID) are turned to the basic one. Node sets are SET1 cards (``SET1 4``) and sets
of the case control (``SET 4``), whose numbers are taken for those of nodes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import FileError, optional
from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers.content import (
    Array,
    FieldFile,
    Integers,
    common_nodes,
    merge_sets,
    named_nodes,
)
from stiffkit.identify.readers.isolated import read_isolated
from stiffkit.identify.readers.source import check_file

BULK_SUFFIXES = (".bdf", ".dat", ".nas", ".fem", ".blk", ".bulk", ".pch")
GRID = 1
"""The kind of point that has a place."""
LARGEST_NODE = 100_000_000
RANGE = re.compile(r"\s*(\d+)(?:\s+THRU\s+(\d+))?\s*", re.IGNORECASE)

KINDS = {
    "CTRIA3": ("triangle", "triangle"),
    "CTRIA6": ("triangle", "triangle6"),
    "CQUAD4": ("quad", "quad"),
    "CQUAD8": ("quad", "quad8"),
    "CTETRA": ("tetra", "tetra10"),
    "CPENTA": ("wedge", "wedge15"),
    "CHEXA": ("hexahedron", "hexahedron20"),
    "CPYRAM": ("pyramid", "pyramid13"),
}
"""Cards of elements, without and with all mid-side nodes."""
UPRIGHT_FIRST = {
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
}
"""Where the node of each place stands in Nastran, which has the upright edges before the top."""
CARDS = (
    "GRID",
    "GRDSET",
    *(f"CORD{order}{kind}" for order in "12" for kind in "RCS"),
    *KINDS,
    "SET1",
    "INCLUDE",
    "ENDDATA",
)


def read_op2(path: Path, bulk: Path | None = None) -> FieldFile:
    """Return displacements with their nodes, through a child process.

    ``bulk`` is the bulk data file; without it the one of the same name beside the result file.
    """
    beside = find_bulk(path) if bulk is None else bulk
    check_file(beside)
    return read_isolated("op2", path, beside)


def find_bulk(path: Path) -> Path:
    """Return the bulk data file of the same name, or raise ``FileError``."""
    for other in sorted(path.parent.iterdir()):
        if other.stem == path.stem and other.suffix.lower() in BULK_SUFFIXES and other.is_file():
            return other
    raise FileError(
        "the coordinates are missing: a result file of Nastran does not hold them",
        path=path,
        mend=f"put the bulk data file {path.stem}.bdf beside it, or name that file",
    )


def read(path: Path, bulk: Path | None = None) -> FieldFile:
    """Return displacements with their nodes, in this process."""
    tables = _displacements(path)
    model = _bulk_data(find_bulk(path) if bulk is None else bulk)
    ids = common_nodes(path, {name: nodes for name, (nodes, _) in tables.items()})
    unplaced = [node for node in ids.tolist() if node not in model.nodes]
    if unplaced:
        raise FileError(
            f"{named_nodes(unplaced)} not in the bulk data {model.bdf_filename}",
            path=path,
            mend="give the bulk data that this result was computed from",
        )
    points = np.array([model.nodes[node].get_position_no_xref(model) for node in ids.tolist()])
    cases = {name: _in_basic(model, ids, points, values) for name, (_, values) in tables.items()}
    return FieldFile(path, "op2", ids, points, cases, _sets(model), _facets(model))


def _displacements(path: Path) -> dict[str, tuple[Integers, Array]]:
    """Return nodes (n,) and displacements (n, 3) of each subcase."""
    with optional("pyNastran", needed_for="files of this format", extra="fields"):
        from pyNastran.op2.op2 import OP2
    model = OP2(debug=False)
    model.set_results(["displacements"])
    model.read_op2(str(path), combine=False, build_dataframe=False, skip_undefined_matrices=True)
    tables: dict[str, tuple[Integers, Array]] = {}
    for key, table in model.displacements.items():
        if np.iscomplexobj(table.data):
            continue
        grids = table.node_gridtype[:, 1] == GRID
        last = np.asarray(table.data[-1, grids, :3], dtype=float)
        tables[_case_name(key, tables)] = (np.asarray(table.node_gridtype[grids, 0]), last)
    if not tables:
        raise FileError(
            "it holds no real displacements",
            path=path,
            mend="ask for them in the case control: DISPLACEMENT(PLOT) = ALL, PARAM,POST,-1",
        )
    return tables


def _case_name(key: Any, taken: dict[str, Any]) -> str:
    """Return the name of a load case from pyNastran's key, whose first number is the subcase."""
    name = f"subcase {key[0] if isinstance(key, tuple) else key}"
    again = sum(other == name or other.startswith(f"{name}, ") for other in taken)
    return f"{name}, result {again + 1}" if again else name


def _bulk_data(path: Path) -> Any:
    """Return pyNastran's model of the cards that matter here; others are not looked at."""
    from pyNastran.bdf.bdf import BDF

    for punch in (False, True):
        model = BDF(debug=None)
        model.set_cards(CARDS)
        try:
            model.read_bdf(str(path), validate=False, xref=False, punch=punch)
        except Exception as error:
            if punch:
                first = (str(error).strip().splitlines() or [type(error).__name__])[0]
                raise FileError(
                    f"the bulk data cannot be read: {first[:200]}",
                    path=path,
                    mend="give the bulk data that the result was computed from",
                ) from None
        else:
            if model.nodes:
                break
    return model


def _in_basic(model: Any, ids: Integers, points: Array, values: Array) -> Array:
    """Return displacements in the basic system, node by node where a deck asked for another."""
    basic = values.copy()
    systems = np.array([model.nodes[node].Cd() for node in ids.tolist()])
    for system in np.unique(systems[systems > 0]):
        coord = model.coords[int(system)]
        coord.setup_no_xref(model)
        rows = np.flatnonzero(systems == system)
        axes = np.array([coord.i, coord.j, coord.k])
        local = (points[rows] - coord.origin) @ axes.T
        basic[rows] = _along_axes(coord.type[-1], local, values[rows]) @ axes
    return basic


def _along_axes(kind: str, local: Array, values: Array) -> Array:
    """Return vectors of a rectangular, cylindrical or spherical system along its axes.

    ``local`` (n, 3) are the places along the axes; see the Nastran Quick Reference Guide, CORD2C
    and CORD2S: components (r, theta, z) and (r, theta, phi), theta from z in the latter.
    """
    if kind == "R":
        return values
    azimuth = np.arctan2(local[:, 1], local[:, 0])
    if kind == "C":
        out, around, up = values.T
    else:
        polar = np.arctan2(np.hypot(local[:, 0], local[:, 1]), local[:, 2])
        radial, meridian, around = values.T
        out = np.sin(polar) * radial + np.cos(polar) * meridian
        up = np.cos(polar) * radial - np.sin(polar) * meridian
    x = np.cos(azimuth) * out - np.sin(azimuth) * around
    y = np.sin(azimuth) * out + np.cos(azimuth) * around
    return np.column_stack([x, y, up])


def _facets(model: Any) -> dict[str, Integers]:
    """Return elements by kind; one that lacks a mid-side node counts by its corners."""
    cells: dict[str, list[list[int]]] = {}
    for element in model.elements.values():
        if element.type not in KINDS:
            continue
        linear, quadratic = KINDS[element.type]
        nodes = element.node_ids
        full = len(nodes) == ELEMENTS[quadratic].size and all(nodes)
        kind = quadratic if full else linear
        order = UPRIGHT_FIRST.get(kind, range(ELEMENTS[kind].size))
        cells.setdefault(kind, []).append([nodes[place] for place in order])
    return {kind: np.array(nodes, dtype=np.int64) for kind, nodes in cells.items()}


def _sets(model: Any) -> dict[str, Integers]:
    """Return the sets of the bulk data and of the case control, without numbers of no node."""
    nodes = np.array(sorted(model.nodes), dtype=np.int64)
    merged = merge_sets(*_bulk_sets(model), *_control_sets(model))
    placed = {name: np.intersect1d(numbers, nodes) for name, numbers in merged.items()}
    return {name: numbers for name, numbers in placed.items() if len(numbers)}


def _bulk_sets(model: Any) -> Iterator[dict[str, Integers]]:
    for number, card in model.sets.items():
        if card.type == "SET1":
            yield {f"SET1 {number}": np.array(card.get_ids(), dtype=np.int64)}


def _control_sets(model: Any) -> Iterator[dict[str, Integers]]:
    deck = model.case_control_deck
    for subcase in deck.subcases.values() if deck else ():
        for key, (value, *_) in subcase.params.items():
            if key.startswith("SET "):
                for entry in value:
                    yield {key: _numbers(str(entry))}


def _numbers(entry: str) -> Integers:
    """Return the numbers of one entry of a set: ``7``, or ``7 THRU 20``."""
    ends = RANGE.fullmatch(entry)
    if ends is None:
        return np.empty(0, np.int64)
    first, last = int(ends[1]), int(ends[2] or ends[1])
    return np.arange(first, min(last, LARGEST_NODE) + 1)
