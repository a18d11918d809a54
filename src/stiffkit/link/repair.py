"""Repairs of published matrices: asked for by the file, and told."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stiffkit.files.entry import Entry
from stiffkit.link.checks import symmetrize
from stiffkit.spatial.rotation import Array


def repaired(
    matrix: Array,
    repair: Entry,
    what: str,
    read: Callable[[Entry, int, int], float],
    scale: Array,
) -> tuple[Array, list[str]]:
    """Return a matrix (n x n, SI) with the repairs made, and what was done in words.

    ``read`` reads the new value of element (i, j) in SI; words show values divided by ``scale``, as
    the file writes them. Raises FileError for a place outside the matrix.
    """
    matrix = matrix.copy()
    notes = []
    n = matrix.shape[0]
    entries = repair.get("entries")
    for place, given in [] if entries is None else entries.items():
        i, j = (int(number) - 1 for number in place.split(","))
        if max(i, j) >= n:
            raise given.error(f"the matrix has {n} rows and columns", f"count from 1 to {n}")
        new = read(given, i, j)
        notes.append(
            f"{what} entry ({i + 1},{j + 1}) replaced: "
            f"{matrix[i, j] / scale[i, j]:.6g} -> {new / scale[i, j]:.6g}"
        )
        matrix[i, j] = matrix[j, i] = new
    is_asked = "symmetrize" in repair and repair["symmetrize"].node.value is True
    if is_asked and not np.array_equal(matrix, matrix.T):
        notes.append(f"{what} made symmetric: {_largest_difference(matrix, scale)}")
        matrix = symmetrize(matrix)
    return matrix, notes


def _largest_difference(matrix: Array, scale: Array) -> str:
    diagonal = np.sqrt(np.abs(np.diag(matrix)))
    weight = np.outer(diagonal, diagonal)
    difference = np.abs(matrix - matrix.T) / np.where(weight > 0.0, weight, 1.0)
    i, j = np.unravel_index(int(np.argmax(difference)), matrix.shape)
    upper, lower = matrix[i, j] / scale[i, j], matrix[j, i] / scale[j, i]
    return (
        f"entries ({i + 1},{j + 1}) = {upper:.6g} and ({j + 1},{i + 1}) = {lower:.6g} "
        f"differed most, their mean is {(upper + lower) / 2.0:.6g}"
    )
