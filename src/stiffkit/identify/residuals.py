"""What a rigid motion leaves of a displacement field."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.identify.estimators import RigidFit
from stiffkit.identify.field import Field
from stiffkit.identify.moments import chunks, homogeneous
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class ResidualSums:
    """Summary of the residuals of m load cases."""

    squares: Array
    """(m,), m^2: sum of w |r|^2, weights of mean 1."""
    largest: Array
    """(m,), m: largest absolute component."""
    largest_node: tuple[int, ...]
    """m labels of the nodes where that is."""


def residual_pieces(field: Field, fitted: RigidFit) -> Iterator[tuple[slice, Array]]:
    """Yield slices of c nodes, and the residuals (m, c, 3) in m there."""
    for at in chunks(field.node_count):
        yield at, residuals_at(field, fitted, at)


def residuals_at(field: Field, fitted: RigidFit, at: slice | NDArray[np.int64]) -> Array:
    """Return the residuals (m, c, 3) in m of the c nodes at these places."""
    model = np.concatenate([fitted.mean[:, None, :], fitted.gradient.mT], axis=1)
    moved = homogeneous(field.points[at], fitted.centre) @ model
    return np.asarray(field.displacements[:, at] - moved)


def residuals(field: Field, fitted: RigidFit) -> Array:
    """Return all residuals (m, n, 3) in m: displacements less those of the rigid motion."""
    result = np.empty_like(field.displacements)
    for at, piece in residual_pieces(field, fitted):
        result[:, at] = piece
    return result


def residual_sums(field: Field, fitted: RigidFit) -> ResidualSums:
    """Return the summary of the residuals without holding them all."""
    cases = np.arange(field.case_count)
    squares, largest = np.zeros(field.case_count), np.full(field.case_count, -1.0)
    where = np.zeros(field.case_count, dtype=np.int64)
    for at, piece in residual_pieces(field, fitted):
        squares += (field.relative_weights[at] @ (piece * piece)).sum(axis=1)
        sizes = np.abs(piece).reshape(field.case_count, -1)
        places = sizes.argmax(axis=1)
        larger = sizes[cases, places] > largest
        largest = np.where(larger, sizes[cases, places], largest)
        where = np.where(larger, at.start + places // 3, where)
    return ResidualSums(squares, largest, tuple(int(i) for i in field.nodes[where]))
