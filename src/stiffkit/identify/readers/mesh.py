"""VTU, and the other formats that meshio reads: VTK, Gmsh, XDMF, MED, Exodus, Tecplot and so on.

Each array of three numbers per point is a load case under its own name; where there is none, three
arrays of one number are, whose names differ in the component only (``push_x``). These formats
number no nodes; here they count from zero, as ParaView does. Point and cell sets, and the physical
groups of Gmsh, become node sets. The files can be packed more than a thousandfold, so reading is
left to a child process whose memory is bounded.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import FileError, optional
from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers.content import Array, FieldFile, Integers, merge_sets
from stiffkit.identify.readers.headings import vector_columns
from stiffkit.identify.readers.isolated import read_isolated

SUFFIXES = (".vtu", ".vtk", ".msh", ".xdmf", ".xmf", ".med", ".e", ".exo", ".ex2", ".tec", ".avs")
PHYSICAL = "gmsh:physical"


def read_mesh(path: Path) -> FieldFile:
    """Return the points, vectors, sets and cells of a file, through a child process."""
    return read_isolated("mesh", path)


def read(path: Path, _: Path | None = None) -> FieldFile:
    """Return the content of a file, in this process; meshio's words become a ``FileError``."""
    mesh = _meshio_read(path)
    points = np.asarray(mesh.points, dtype=float)
    flat = np.zeros((len(points), 3 - points.shape[1]))
    cases = _vectors(mesh)
    if not cases:
        held = ", ".join(mesh.point_data) or "none at all"
        raise FileError(
            f"no array has three numbers per point; arrays of points: {held}",
            path=path,
            mend="export the displacement as a vector of points",
        )
    return FieldFile(
        path,
        "mesh",
        np.arange(len(points)),
        np.hstack([points, flat]),
        cases,
        merge_sets(*_sets(mesh)),
        _facets(mesh),
    )


def _meshio_read(path: Path) -> Any:
    """Return meshio's mesh; it prints and exits where it cannot read."""
    with optional("meshio", needed_for="files of this format", extra="fields"):
        import meshio
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            return meshio.read(path)
    except (meshio.ReadError, SystemExit) as error:
        lines = said.getvalue().strip().splitlines() or [str(error)]
        raise FileError(
            f"meshio cannot read it: {lines[0]}",
            path=path,
            mend="the file is cut off, damaged or of another format: export it again",
        ) from None


def _vectors(mesh: Any) -> dict[str, Array]:
    """Return the arrays of three numbers per point, or those of one that are components."""
    arrays = {str(name): np.asarray(values) for name, values in mesh.point_data.items()}
    held = {name: array for name, array in arrays.items() if array.dtype.kind == "f"}
    count = len(mesh.points)
    vectors = {name: array for name, array in held.items() if array.shape == (count, 3)}
    if vectors:
        return vectors
    scalars = [name for name, array in held.items() if array.shape == (count,)]
    return {
        stem: np.column_stack([held[scalars[place]] for place in triple])
        for stem, triple in vector_columns(scalars).items()
    }


def _facets(mesh: Any) -> dict[str, Integers]:
    """Return the cells of known kinds."""
    blocks: dict[str, list[Integers]] = {}
    for block in mesh.cells:
        if block.type in ELEMENTS and len(block.data):
            blocks.setdefault(block.type, []).append(np.asarray(block.data))
    return {kind: np.concatenate(parts) for kind, parts in blocks.items()}


def _sets(mesh: Any) -> Iterator[dict[str, Integers]]:
    """Return the sets of points, and the points of sets of cells."""
    for name, points in mesh.point_sets.items():
        yield {str(name): np.asarray(points)}
    for name, members in mesh.cell_sets.items():
        for block, cells in zip(mesh.cells, members, strict=False):
            # Block by block the format may leave out those that have no part in the set.
            if cells is not None and len(cells):
                yield {str(name): np.unique(np.asarray(block.data)[cells])}
    if PHYSICAL not in mesh.cell_data:
        return
    groups = {int(tag): str(name) for name, (tag, _) in mesh.field_data.items()}
    for block, tags in zip(mesh.cells, mesh.cell_data[PHYSICAL], strict=True):
        for tag in np.unique(tags):
            name = groups.get(int(tag), f"physical {tag}")
            yield {name: np.unique(np.asarray(block.data)[np.asarray(tags) == tag])}
