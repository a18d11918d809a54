"""Compliances and inertias that a file gives: units, explicit repairs, and checks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffkit.files.entry import Entry
from stiffkit.link.checks import check_compliance, check_inertia
from stiffkit.link.ports import in_words
from stiffkit.link.repair import repaired
from stiffkit.spatial.rotation import Array
from stiffkit.units import (
    COMPLIANCE_COUPLING,
    COMPLIANCE_ROTATION,
    COMPLIANCE_TRANSLATION,
    INERTIA,
    Dimension,
)

_METRES = {"m": 1.0, "mm": 1e-3}


def read_compliance(entry: Entry, ports: Sequence[str]) -> tuple[Array, list[str]]:
    """Return the compliance (6p, 6p), SI, of a ``compliance`` mapping, and the repairs asked for.

    ``ports`` are the p that are not held. Raises FileError where the matrix, repaired, is not that
    of an elastic body.
    """
    units = entry["units"].text() if "units" in entry else "m"
    rows = _square(entry["matrix"], ports)
    scale = _bare_scale(_METRES[units], len(rows))
    matrix = np.array(
        [
            [_read_element(element, i, j, scale) for j, element in enumerate(row)]
            for i, row in enumerate(rows)
        ]
    )
    notes: list[str] = []
    if (repair := entry.get("repair")) is not None:
        matrix, notes = repaired(
            matrix, repair, "compliance", lambda e, i, j: _read_element(e, i, j, scale), scale
        )
    faults = check_compliance(matrix, ports)
    if faults:
        raise entry["matrix"].error("; ".join(faults), _mend(faults))
    return matrix, notes


def read_inertia(entry: Entry, mass: float | None) -> tuple[Array, list[str]]:
    """Return the inertia (3x3, kg m^2) about the centre of mass, and the repairs it asked for.

    Raises FileError where no body of this mass (kg) has it.
    """
    printed = entry.get("matrix") or entry
    inertia = printed.matrix(INERTIA)
    notes: list[str] = []
    if printed is not entry and (repair := entry.get("repair")) is not None:
        inertia, notes = repaired(
            inertia, repair, "inertia", lambda e, _i, _j: e.quantity(INERTIA), np.ones((3, 3))
        )
    # An inertia may be known without its mass, which takes no part in the other checks.
    faults = check_inertia(1.0 if mass is None else mass, inertia)
    if faults:
        raise printed.error(
            "; ".join(faults),
            "correct it; or write 'inertia: {matrix: ..., repair: {entries: {...}}}'",
        )
    return inertia, notes


def _square(entry: Entry, ports: Sequence[str]) -> list[list[Entry]]:
    """Return the elements of a matrix. Raises FileError unless it has six rows for each port."""
    size = 6 * len(ports)
    for listed in (entry, *entry.elements()):
        if len(listed.elements()) != size:
            raise listed.error(
                f"the list has {len(listed.elements())} values, {size} are expected",
                f"there are six rows and columns for each port but the base: {in_words(ports)}",
            )
    return [row.elements() for row in entry.elements()]


def _bare_scale(metres: float, size: int) -> Array:
    """Return what bare numbers are multiplied by (size, size), given the unit of length, m."""
    translates = np.arange(size) % 6 < 3
    scale = np.ones((size, size))
    scale[np.ix_(translates, translates)] = metres
    scale[np.ix_(~translates, ~translates)] = 1.0 / metres
    return scale


def _read_element(entry: Entry, i: int, j: int, scale: Array) -> float:
    si = entry.quantity(_dimension(i, j))
    is_bare = entry.value().dims is None
    return si * float(scale[i, j]) if is_bare else si


def _dimension(i: int, j: int) -> Dimension:
    turns = (i % 6 >= 3, j % 6 >= 3)
    if not any(turns):
        return COMPLIANCE_TRANSLATION
    return COMPLIANCE_ROTATION if all(turns) else COMPLIANCE_COUPLING


def _mend(faults: list[str]) -> str:
    """Name the repair that may help."""
    if any("symmetric" in fault for fault in faults):
        return "correct it, or add 'repair: {symmetrize: true}' to take the mean"
    return "correct it, or add 'repair: {entries: {\"row,column\": value}}' with the right value"
