"""Sums over the nodes of a field, in pieces that fit the processor's cache.

All that a rigid fit needs of a field of any size is here: a few 3x3 matrices for each load case.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stiffkit.identify.field import Field
from stiffkit.spatial.rotation import Array

CHUNK = 8192
"""Nodes at a time."""


@dataclass(frozen=True, eq=False)
class Moments:
    """Weighted sums about the centre of a field; the weights w have the mean 1."""

    count: int
    """n, nodes; also the sum of the weights."""
    centre: Array
    """(3,), m, weighted mean of the points."""
    second: Array
    """(3, 3), m^2: sum of w p p^T, with p from the centre."""
    mean: Array
    """(m, 3), m, weighted mean of the displacements of each load case."""
    cross: Array
    """(m, 3, 3), m^2: sum of w p (u - mean)^T, with the displacement u."""


def chunks(count: int) -> Iterator[slice]:
    """Yield slices that cover ``count`` nodes."""
    for start in range(0, count, CHUNK):
        yield slice(start, min(start + CHUNK, count))


def homogeneous(points: Array, centre: Array) -> Array:
    """Return rows (1, p) for points (c, 3) taken from a centre: (c, 4)."""
    X = np.empty((len(points), 4))
    X[:, 0] = 1.0
    # Column by column: NumPy's loops over the last axis would be only three long.
    for axis in range(3):
        np.subtract(points[:, axis], centre[axis], out=X[:, axis + 1])
    return X


def moments(field: Field) -> Moments:
    """Return the moments of a field to the rounding of its data, not of the sums.

    The sums are taken twice, the second time over what a rigid fit to the first leaves, so that
    neither a large common translation nor a million terms cost digits of a small rotation.
    """
    count, centre = field.node_count, field.spread.centre
    gram = np.zeros((4, 4))
    for at in chunks(count):
        X = homogeneous(field.points[at], centre)
        gram += X.T @ (field.relative_weights[at, None] * X)
    second = gram[1:, 1:]
    model = _rigid_model(second, _sums(field, None) / count, count)
    left = _sums(field, model)
    mean = model[:, 0] + left[:, 0] / count
    # The points do not sum to exactly zero about a rounded centre.
    shift = gram[0, 1:, None] * left[:, None, 0] / count
    cross = second @ model[:, 1:] + left[:, 1:] - shift
    return Moments(count, centre, second, mean, cross)


def gyration(second: Array) -> Array:
    """Return the sum of w (|p|^2 I - p p^T), 3x3, the normal matrix of a rotation."""
    return np.asarray(np.trace(second) * np.eye(3) - second)


def small_rotations(second: Array, cross: Array) -> Array:
    """Return the rotations (m, 3) of equation 17 from moments (3, 3) and (m, 3, 3)."""
    return np.asarray(np.linalg.solve(gyration(second), axial(cross).T).T)


def axial(matrices: Array) -> Array:
    """Return the sums of a x b (..., 3) from sums of a b^T (..., 3, 3)."""
    A = matrices
    return np.stack(
        [A[..., 1, 2] - A[..., 2, 1], A[..., 2, 0] - A[..., 0, 2], A[..., 0, 1] - A[..., 1, 0]],
        axis=-1,
    )


def skew_matrices(vectors: Array) -> Array:
    """Return the matrices (m, 3, 3) of the cross product with each vector (m, 3)."""
    A = np.zeros((len(vectors), 3, 3))
    A[:, 2, 1], A[:, 0, 2], A[:, 1, 0] = vectors.T
    return A - A.mT


def _sums(field: Field, model: Array | None) -> Array:
    """Return the sums of w (1, p) (u - model)^T, (m, 4, 3); the model is (1, p) @ (m, 4, 3)."""
    total = np.zeros((field.case_count, 4, 3))
    centre = field.spread.centre
    for at in chunks(field.node_count):
        X = homogeneous(field.points[at], centre)
        weighted = (field.relative_weights[at, None] * X).T
        for j, displacement in enumerate(field.displacements):
            u = displacement[at] if model is None else displacement[at] - X @ model[j]
            total[j] += weighted @ u
    return total


def _rigid_model(second: Array, mean_sums: Array, count: int) -> Array:
    """Return the rigid motion (m, 4, 3) that fits first sums over n, as displacement rows."""
    rotation = small_rotations(second / count, mean_sums[:, 1:])
    model = np.empty_like(mean_sums)
    model[:, 0] = mean_sums[:, 0]
    model[:, 1:] = skew_matrices(rotation).mT
    return model
