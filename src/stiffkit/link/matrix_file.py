"""Square matrices as files give them: in place, or as a text file beside."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stiffkit.errors import FileError
from stiffkit.files import Entry
from stiffkit.spatial.rotation import Array

LARGEST_MATRIX_FILE = 64 * 1024 * 1024
"""Bytes."""


def read_matrix(entry: Entry) -> Array:
    """Return a square matrix: rows of numbers, or the name of a text file beside this one.

    A file that ends in .mtx is read as Matrix Market, any other as rows of numbers. Raises
    FileError where it cannot be read or is not square.
    """
    if isinstance(entry.node.value, list):
        rows = [[element.node.value for element in row.elements()] for row in entry.elements()]
        widths = {len(row) for row in rows}
        if widths != {len(rows)}:
            raise entry.error(f"the matrix has {len(rows)} rows of {sorted(widths)} numbers")
        return np.array(rows, dtype=float)
    path = entry.path.parent / entry.text()
    matrix = _read_text(path, entry)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        shape = "x".join(map(str, matrix.shape))
        raise FileError(f"the matrix must be square and is {shape}", path=path)
    return matrix


def _read_text(path: Path, entry: Entry) -> Array:
    try:
        size = path.stat().st_size
    except OSError as error:
        raise entry.error(f"'{path}' cannot be read: {error.strerror}", "check the name") from None
    if size > LARGEST_MATRIX_FILE:
        raise FileError(f"is larger than {LARGEST_MATRIX_FILE // 2**20} MiB", path=path)
    try:
        if path.suffix == ".mtx":
            return _read_matrix_market(path)
        # Commas, semicolons and blanks all separate numbers.
        text = path.read_text(encoding="utf-8").replace(",", " ").replace(";", " ")
        return np.loadtxt(text.splitlines(), ndmin=2)
    except (OSError, ValueError, UnicodeDecodeError, OverflowError) as error:
        raise FileError(
            f"cannot be read as a matrix: {error}",
            path=path,
            mend="write it as Matrix Market (.mtx), or as rows of numbers",
        ) from None


def _read_matrix_market(path: Path) -> Array:
    from scipy.io import mminfo, mmread

    rows, columns, *_ = mminfo(path)
    if rows != columns or rows > 4000:
        raise ValueError(f"{rows} rows and {columns} columns")
    found = mmread(path)
    dense = found if isinstance(found, np.ndarray) else found.toarray()
    return np.asarray(dense, dtype=float)
