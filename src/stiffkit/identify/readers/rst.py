"""Ansys: displacements, nodes, elements and node components of an ``.rst``.

Each load step is a load case, with its last substep; the shapes of a modal analysis are there
under the name of a mode. Displacements are along the global axes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import optional
from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers.content import FieldFile, Integers, common_nodes, places_of
from stiffkit.identify.readers.isolated import read_isolated

MODAL = 2
"""The number of a modal analysis in the header."""
SHAPES = {
    **dict.fromkeys((5, 22), ("triangle", "triangle6")),
    **dict.fromkeys((9, 23), ("quad", "quad8")),
    **dict.fromkeys((10, 24), ("tetra", "tetra10")),
    **dict.fromkeys((12, 25), ("hexahedron", "hexahedron20")),
    **dict.fromkeys((13, 26), ("wedge", "wedge15")),
    **dict.fromkeys((14, 27), ("pyramid", "pyramid13")),
}
"""Kinds of elements, without and with mid-side nodes, by VTK's numbers.

The library gives some elements with mid-side nodes the number of those without.
"""


def read_rst(path: Path) -> FieldFile:
    """Return the displacements and the mesh of a result file, through a child process."""
    return read_isolated("rst", path)


def read(path: Path, _: Path | None = None) -> FieldFile:
    """Return the displacements and the mesh of a result file, in this process."""
    with optional("ansys-mapdl-reader", needed_for="files of this format", extra="fields"):
        from ansys.mapdl import reader
    result = reader.read_binary(str(path))
    tables = {name: result.nodal_displacement(number) for name, number in _cases(result).items()}
    components = result.node_components
    sets = {name.strip(): np.asarray(ids, dtype=np.int64) for name, ids in components.items()}
    ids = common_nodes(path, {name: nodes for name, (nodes, _) in tables.items()})
    points = result.mesh.nodes[places_of(ids, np.asarray(result.mesh.nnum)), :3]
    cases = {name: values[:, :3] for name, (_, values) in tables.items()}
    return FieldFile(path, "rst", ids, points, cases, sets, _facets(result.grid))


def _cases(result: Any) -> dict[str, int]:
    """Return the number of the result of each load case: the last substep of each load step."""
    header = result._resultheader
    steps = np.asarray(header["ls_table"])[: result.n_results]
    if header["kan"] == MODAL:
        return {f"mode {number + 1}": number for number in range(len(steps))}
    return {f"load step {step}": number for number, (step, *_) in enumerate(steps.tolist())}


def _facets(grid: Any) -> dict[str, Integers]:
    """Return the elements by kind; one that lacks a mid-side node counts by its corners."""
    numbers = np.asarray(grid.point_data["ansys_node_num"], dtype=np.int64)
    cells: dict[str, list[Integers]] = {}
    for vtk, places in grid.cells_dict.items():
        if vtk not in SHAPES:
            continue
        linear, quadratic = SHAPES[vtk]
        corners, size = ELEMENTS[linear].size, ELEMENTS[quadratic].size
        nodes = numbers[places]
        # The library makes up nodes without a number where mid-side nodes are missing.
        whole = (nodes > 0).all(axis=1) & (nodes.shape[1] == size)
        cells.setdefault(quadratic, []).append(nodes[whole])
        cells.setdefault(linear, []).append(nodes[~whole, :corners])
    held = {kind: [part for part in parts if len(part)] for kind, parts in cells.items()}
    return {kind: np.concatenate(parts) for kind, parts in held.items() if parts}
