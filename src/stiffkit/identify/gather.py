"""What a specification names, read and put together: files, load cases, nodes, weights."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stiffkit.errors import FileError
from stiffkit.files import suggest
from stiffkit.identify.field import Field
from stiffkit.identify.readers import (
    FieldFile,
    merge_cases,
    read_field_file,
    read_node_sets,
    with_node_sets,
)
from stiffkit.identify.selection import Selection, field_of, select
from stiffkit.identify.spec import FieldSource, LoadSource, NodeChoice, Spec, blamed_on
from stiffkit.identify.weights import area_weights, volume_weights
from stiffkit.progress import Progress
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array

EQUAL = "equal weights"


@dataclass(frozen=True, eq=False)
class Chosen:
    """The field of some nodes, in link axes, and the choice in words."""

    field: Field
    words: str
    weights_words: str


def read_files(spec: Spec, progress: Progress) -> FieldFile:
    """Return all load cases and sets that a specification names as one file, in m.

    Raises FileError where a file cannot be read or does not fit the others.
    """
    files = []
    for done, source in enumerate(spec.fields):
        progress(f"reading {source.path.name}", done / len(spec.fields))
        files.append(_taken(source, several=len(spec.fields) > 1))
    with blamed_on(spec.place("fields")):
        merged = merge_cases(files) if len(files) > 1 else files[0]
    for source in spec.sets:
        merged = with_node_sets(merged, read_node_sets(source.path))
    return merged.scaled(spec.length, spec.displacement)


def _taken(source: FieldSource, several: bool) -> FieldFile:
    """Return a file with the load cases that are taken from it, by the names they get."""
    file = read_field_file(source.path, format=source.format, bulk=source.bulk)
    names = tuple(file.cases) if source.cases is None else source.cases
    for name in names:
        if name not in file.cases:
            raise source.place.error(
                f"{source.path} has no load case '{name}'", suggest(name, file.cases)
            )
    cases = {name: file.cases[name] for name in names}
    if source.name is not None and len(cases) != 1:
        raise source.place.error(
            f"'name' is for one load case, and {source.path} has {len(cases)}",
            f"leave it out, or take one of {', '.join(cases)} by 'cases'",
        )
    if source.name is not None or (several and len(cases) == 1):
        cases = {source.name or source.path.stem: next(iter(cases.values()))}
    return replace(file, cases=cases)


def loads_of(spec: Spec, file: FieldFile) -> tuple[tuple[str, ...], Array]:
    """Return the names of the m load cases that have a load, and their wrenches (m, 6).

    Wrenches are in N and N m at the reference point, in the axes of the files. Raises FileError
    for a load of no load case, and where a list is not as long as there are load cases.
    """
    given = spec.loads
    if isinstance(given, Mapping):
        _check_names(given, tuple(file.cases))
        names = tuple(name for name in file.cases if name in given)
        return names, np.stack([given[name].wrench for name in names])
    if len(given) != len(file.cases):
        raise spec.place("loads").error(
            f"there are {len(given)} loads and {len(file.cases)} load cases",
            f"give the loads by name: {', '.join(file.cases)}",
        )
    return tuple(file.cases), np.stack([load.wrench for load in given])


def _check_names(given: Mapping[str, LoadSource], cases: tuple[str, ...]) -> None:
    for name, load in given.items():
        if name not in cases:
            raise load.place.error(f"the fields have no load case '{name}'", suggest(name, cases))


def choose(file: FieldFile, choice: NodeChoice, names: tuple[str, ...], T_base: Frame) -> Chosen:
    """Return the field of the chosen nodes in the axes of the link, in some load cases.

    ``T_base`` is the link's frame in the axes of the file, which is in m. Raises FileError at the
    choice where it holds no nodes, or nodes that no rotation can be seen from.
    """
    with blamed_on(choice.place):
        selection = select(file, *choice.regions)
        weights, words = _weights(file, selection, choice.weights)
        field = field_of(file, selection, names, weights)
    if field.node_count < len(selection.rows):
        words += f"; {field.node_count} nodes count"
    return Chosen(_in_link_axes(field, T_base), selection.words, words)


def _weights(file: FieldFile, selection: Selection, kind: str) -> tuple[Array | None, str]:
    if kind == "equal":
        return None, EQUAL
    found = (area_weights if kind == "area" else volume_weights)(file, selection)
    return found.values, found.words


def _in_link_axes(field: Field, T_file_base: Frame) -> Field:
    R = T_file_base.rotation
    if np.array_equal(R, np.eye(3)) and not T_file_base.position.any():
        return field
    points = (field.points - T_file_base.position) @ R
    return Field(points, field.displacements @ R, field.weights, field.case_names, field.nodes)


def content_hash(path: Path) -> str:
    """Return the SHA-256 of a file's bytes. Raises FileError where it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise FileError(f"cannot be read: {error.strerror}", path=path) from None
