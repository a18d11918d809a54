"""Files of displacements, as the programs of engineers write them.

One module per format; all return a ``FieldFile`` in the file's own units. Files are data of
strangers: whatever is wrong with one is a ``FileError`` that says where and how to mend it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stiffkit.errors import FileError
from stiffkit.identify.readers.content import FieldFile, merge_cases, merge_sets
from stiffkit.identify.readers.csv import read_csv
from stiffkit.identify.readers.frd import read_frd
from stiffkit.identify.readers.mesh import SUFFIXES as MESH_SUFFIXES
from stiffkit.identify.readers.mesh import read_mesh
from stiffkit.identify.readers.node_sets import Deck, read_node_sets, with_node_sets
from stiffkit.identify.readers.op2 import read_op2
from stiffkit.identify.readers.rst import read_rst
from stiffkit.identify.readers.source import (
    check_file,
    check_memory,
    is_text,
    read_head,
    recognise,
)

__all__ = [
    "FORMATS",
    "Deck",
    "FieldFile",
    "Format",
    "merge_cases",
    "merge_sets",
    "read_field_file",
    "read_node_sets",
    "with_node_sets",
]


@dataclass(frozen=True)
class Format:
    """A kind of file: what it is, its usual suffixes, its reader, and what reading takes.

    ``memory`` is the most bytes of memory that a byte of the file needs; files that would need
    more than is free are refused. ``marked`` formats can be told from their first bytes.
    """

    title: str
    suffixes: tuple[str, ...]
    read: Callable[[Path], FieldFile]
    memory: float
    marked: bool


FORMATS = {
    "csv": Format("table of text", (".csv", ".tsv", ".txt"), read_csv, 8.0, marked=False),
    "frd": Format("CalculiX result", (".frd",), read_frd, 2.5, marked=True),
    "mesh": Format("mesh with point data, read by meshio", MESH_SUFFIXES, read_mesh, 4.0, False),
    "op2": Format("Nastran result", (".op2",), read_op2, 6.0, marked=True),
    "rst": Format("Ansys result", (".rst",), read_rst, 4.0, marked=True),
}
"""The formats by name."""


def read_field_file(
    path: Path | str, *, format: str | None = None, bulk: Path | str | None = None
) -> FieldFile:
    """Return the nodes, displacements, sets and elements of a file, in the file's units.

    The ``format``, a name in ``FORMATS``, is told from the suffix if it is not given; the content
    must agree with it. ``bulk`` names the bulk data of a Nastran result where that does not lie
    beside it under the same name.

    Raises ``FileError`` for a file that cannot be read, ``StiffkitError`` where the library that
    reads the format is not installed.
    """
    path = Path(path)
    size = check_file(path)
    name = _format_of(path, format)
    check_memory(path, size, FORMATS[name].memory)
    if bulk is not None and name == "op2":
        return read_op2(path, Path(bulk))
    return FORMATS[name].read(path)


def _format_of(path: Path, wanted: str | None) -> str:
    """Return the name of a file's format, wanted or by its suffix, if the content agrees."""
    if wanted is not None and wanted not in FORMATS:
        raise FileError(
            f"there is no format '{wanted}'", path=path, mend=f"one of {', '.join(FORMATS)}"
        )
    head = read_head(path)
    seen = recognise(head)
    suffix = path.suffix.lower()
    by_suffix = (name for name, form in FORMATS.items() if suffix in form.suffixes)
    name = wanted or next(by_suffix, None) or seen
    if name is None:
        suffixes = ", ".join(s for form in FORMATS.values() for s in form.suffixes)
        raise FileError(
            f"the format of a file that ends in '{path.suffix}' is not known",
            path=path,
            mend=f"name the format ({', '.join(FORMATS)}) or rename the file: {suffixes}",
        )
    if seen is not None and seen != name:
        raise FileError(
            f"it should be a {FORMATS[name].title} and looks like a {FORMATS[seen].title}",
            path=path,
            mend=f"name the format '{seen}', or give the right file",
        )
    if (FORMATS[name].marked and seen is None) or (name == "csv" and not is_text(head)):
        raise FileError(
            f"it should be a {FORMATS[name].title} and does not begin like one",
            path=path,
            mend="give the right file, or name its format",
        )
    return name
