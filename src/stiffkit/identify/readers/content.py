"""What a file of displacements holds, whichever program wrote it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiffkit.errors import FieldError, FileError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

NAMED = 5
"""How many nodes a message names."""
SAME_PLACE = 1e-5
"""Largest difference of a node's place in two files, relative to the size of the body.

Text formats keep six digits.
"""


@dataclass(frozen=True, eq=False)
class FieldFile:
    """Nodes, their displacements in each load case, node sets and elements, in the file's units.

    ``ids`` (n,) are the node numbers, each once; ``points`` (n, 3) their places before loading;
    ``cases`` maps the name of each load case to the displacements (n, 3), in the file's order;
    ``sets`` maps names to node numbers; ``facets`` maps kinds of elements (``quad8``, named and
    ordered as in VTK) to the node numbers (m, k) of these. All arrays are read-only.

    Raises ``FileError`` where numbers are missing, not finite or contradict each other.
    """

    path: Path
    format: str
    ids: Integers
    points: Array
    cases: Mapping[str, Array]
    sets: Mapping[str, Integers] = field(default_factory=dict)
    facets: Mapping[str, Integers] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the content and lock it."""
        store = object.__setattr__
        store(self, "path", Path(self.path))
        store(self, "ids", _locked(self.ids, np.int64))
        store(self, "points", _locked(self.points, np.float64))
        store(self, "cases", _locked_all(self.cases, np.float64))
        store(self, "sets", _locked_all(self.sets, np.int64))
        store(self, "facets", _locked_all(self.facets, np.int64))
        self._check_nodes()
        for name, displacement in self.cases.items():
            self._check_case(name, displacement)

    def rows(self, ids: ArrayLike) -> Integers:
        """Return where nodes stand in ``ids``; -1 for those that the file does not have."""
        return places_of(ids, self.ids)

    def with_sets(self, *more: Mapping[str, ArrayLike]) -> FieldFile:
        """Return the file with further node sets; sets of one name merge."""
        return replace(self, sets=merge_sets(self.sets, *more))

    def scaled(self, length: float, displacement: float | None = None) -> FieldFile:
        """Return the file in other units: points times ``length``, displacements likewise.

        ``length`` and ``displacement`` are the size of the file's units in the new ones, such as
        1e-3 for a file in millimetres that is to be in metres; displacements without a unit of
        their own have that of the points.
        """
        factor = length if displacement is None else displacement
        cases = {name: factor * values for name, values in self.cases.items()}
        return replace(self, points=length * self.points, cases=cases)

    def _check_nodes(self) -> None:
        """Refuse empty files, nodes that are there twice, and places that are no numbers."""
        if len(self.ids) == 0:
            raise self._error("it holds no nodes", "export the nodes with the displacements")
        if self.points.shape != (len(self.ids), 3):
            raise self._error(
                f"{len(self.ids)} nodes have coordinates of shape {self.points.shape}",
                "give three coordinates per node",
            )
        unique, counts = np.unique(self.ids, return_counts=True)
        if len(unique) != len(self.ids):
            raise self._error(
                f"{named_nodes(unique[counts > 1])} more than once", "number each node once"
            )
        self._check_finite("the place", self.points)
        if not self.cases:
            raise self._error(
                "it holds no displacements", "export the displacements of the load cases"
            )

    def _check_case(self, name: str, displacement: Array) -> None:
        """Refuse displacements that are not one finite vector per node."""
        if displacement.shape != self.points.shape:
            raise self._error(
                f"case '{name}': {len(self.ids)} nodes have displacements "
                f"of shape {displacement.shape}",
                "give three components per node",
            )
        self._check_finite(f"case '{name}': the displacement", displacement)

    def _check_finite(self, what: str, values: Array) -> None:
        """Refuse NaN and infinity."""
        wrong = ~np.isfinite(values).all(axis=1)
        if wrong.any():
            raise self._error(
                f"{what} is not a finite number at {named_nodes(self.ids[wrong])}",
                "solve again, or leave these nodes out of the file",
            )

    def _error(self, what: str, mend: str) -> FileError:
        return FileError(what, path=self.path, mend=mend)


def places_of(wanted: ArrayLike, ids: Integers) -> Integers:
    """Return where numbers, of any shape, stand in ``ids`` (n,); -1 where they do not."""
    numbers = np.asarray(wanted, dtype=np.int64)
    if len(ids) == 0:
        return np.full(numbers.shape, -1)
    order = np.argsort(ids, kind="stable")
    place = np.searchsorted(ids, numbers, sorter=order).clip(max=len(ids) - 1)
    rows = order[place]
    return np.where(ids[rows] == numbers, rows, -1)


def merge_sets(*several: Mapping[str, ArrayLike]) -> dict[str, Integers]:
    """Return all sets of nodes; those of one name become one, each node once, ascending."""
    merged: dict[str, Integers] = {}
    for sets in several:
        for name, ids in sets.items():
            merged[name] = np.union1d(merged.get(name, np.empty(0, np.int64)), ids).astype(np.int64)
    return merged


def merge_cases(files: Sequence[FieldFile]) -> FieldFile:
    """Return one file with the load cases of several on the same nodes, in the first's order.

    Cases whose names clash are told apart by their files' names. Sets merge; the elements are
    those of the first file that has any. Raises ``FieldError`` where nodes differ between files.
    """
    first = files[0]
    counts: dict[str, int] = {}
    for name in (name for file in files for name in file.cases):
        counts[name] = counts.get(name, 0) + 1
    cases: dict[str, Array] = {}
    for file in files:
        rows = _same_nodes(first, file)
        for name, displacement in file.cases.items():
            own = name if counts[name] == 1 else f"{file.path.stem}: {name}"
            if own in cases:
                raise FieldError(
                    f"{file.path}: the load case '{own}' is there already",
                    mend="give each file once, and name the files differently",
                )
            cases[own] = displacement[rows]
    facets = next((file.facets for file in files if file.facets), {})
    return replace(first, cases=cases, sets=merge_sets(*(f.sets for f in files)), facets=facets)


def _same_nodes(first: FieldFile, other: FieldFile) -> Integers:
    """Return where the first file's nodes stand in the other, which has the same ones."""
    rows = other.rows(first.ids)
    missing = np.concatenate([first.ids[rows < 0], other.ids[first.rows(other.ids) < 0]])
    if missing.size:
        raise FieldError(
            f"{named_nodes(missing)} only in one of {first.path} and {other.path}",
            mend="export all load cases on the same nodes",
        )
    size = float(np.linalg.norm(np.ptp(first.points, axis=0)))
    apart = np.abs(other.points[rows] - first.points).max(axis=1) > SAME_PLACE * size
    if apart.any():
        raise FieldError(
            f"{named_nodes(first.ids[apart])} not at the same place in {first.path} "
            f"and {other.path}",
            mend="export all load cases from the same mesh, with undeformed coordinates",
        )
    return rows


def common_nodes(path: Path, nodes: Mapping[str, Integers]) -> Integers:
    """Return the node numbers (n,) that all load cases of a file share, in the same order.

    Raises ``FileError`` where a node has displacements in one load case and not in another.
    """
    first, ids = next(iter(nodes.items()))
    for name, others in nodes.items():
        if np.array_equal(ids, others):
            continue
        for has, lacks, some, more in ((first, name, ids, others), (name, first, others, ids)):
            missing = np.setdiff1d(some, more)
            if missing.size:
                raise FileError(
                    f"case '{lacks}' has no displacement of {named_nodes(missing)}, "
                    f"case '{has}' has",
                    path=path,
                    mend="export the displacements of the same nodes in all load cases",
                )
        raise FileError(
            f"cases '{first}' and '{name}' hold their nodes in different order, "
            "or one of them holds a node twice",
            path=path,
            mend="export the load cases alike",
        )
    return ids.astype(np.int64)


def named_nodes(ids: Iterable[Any]) -> str:
    """Return nodes in words: ``node 7``, or their number and the first few."""
    numbers = [int(node) for node in ids]
    if len(numbers) == 1:
        return f"node {numbers[0]}"
    listed = ", ".join(map(str, numbers[:NAMED]))
    more = ", ..." if len(numbers) > NAMED else ""
    return f"{len(numbers)} nodes ({listed}{more})"


def _locked(values: ArrayLike, dtype: type) -> NDArray[Any]:
    """Return a read-only view, of the array itself where its type fits."""
    array: NDArray[Any] = np.asarray(values, dtype=dtype).view()
    array.flags.writeable = False
    return array


def _locked_all(arrays: Mapping[str, ArrayLike], dtype: type) -> Mapping[str, NDArray[Any]]:
    return MappingProxyType({name: _locked(values, dtype) for name, values in arrays.items()})
