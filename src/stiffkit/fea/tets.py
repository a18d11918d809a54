"""Ten-node tetrahedra: Jacobians, volumes, and straightening those that bulge too much.

Nodes are numbered as Netgen does: four corners, then the middles of the edges in `TET_EDGES`.
"""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
from numpy.typing import NDArray

from stiffkit.spatial.rotation import Array

Indices = NDArray[np.int32]
"""Nodes of elements."""

TET_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
TRIANGLE_EDGES = ((1, 2), (0, 2), (0, 1))

FLATTEST = 0.05
"""The least ratio of smallest to mean Jacobian of an element that one may compute on."""


_STEPS = 10


def gradients(barycentric: Array) -> Array:
    """Return the derivatives (q, 10, 3) of the quadratic shape functions in the unit tetrahedron.

    ``barycentric`` (q, 4); the reference coordinates are the weights of the corners 0, 1 and 2.
    """
    weight = np.vstack([np.eye(3), -np.ones(3)])
    q = len(barycentric)
    out = np.empty((q, 10, 3))
    for i in range(4):
        out[:, i] = (4.0 * barycentric[:, i, None] - 1.0) * weight[i]
    for k, (i, j) in enumerate(TET_EDGES):
        out[:, 4 + k] = 4.0 * (
            barycentric[:, i, None] * weight[j] + barycentric[:, j, None] * weight[i]
        )
    return out


@cache
def _bernstein() -> tuple[Array, Array]:
    """Return points (20, 4) and the matrix (20, 20) from values there to Bernstein coefficients."""
    exponents = np.array([e for e in itertools.product(range(4), repeat=4) if sum(e) == 3])
    points = exponents / 3.0
    factorial = np.array([1, 1, 2, 6])
    multinomial = 6 / factorial[exponents].prod(axis=1)
    values = multinomial * np.prod(points[:, None, :] ** exponents[None], axis=2)
    return points, np.linalg.inv(values)


def jacobian_bounds(points: Array, tets: Indices) -> tuple[Array, Array]:
    """Return lower bounds (e,) of the elements' Jacobians and their means (e,).

    The Jacobian is cubic; its Bernstein coefficients bound it (A. Johnen, J.-F. Remacle, C.
    Geuzaine, "Geometrical validity of curvilinear finite elements", J. Comput. Phys. 233, 2013),
    and their mean is its mean, six times the volume.
    """
    at, to_bernstein = _bernstein()
    derivatives = gradients(at)
    values = np.empty((len(tets), len(at)))
    for chunk in np.array_split(np.arange(len(tets)), max(1, len(tets) // 20000)):
        jacobians = np.einsum("eni,qnj->eqij", points[tets[chunk]], derivatives)
        values[chunk] = np.linalg.det(jacobians)
    coefficients = values @ to_bernstein.T
    sign = np.sign(coefficients.mean())
    return sign * coefficients.min(axis=1) if sign > 0 else -coefficients.max(axis=1), np.asarray(
        sign * coefficients.mean(axis=1)
    )


def volumes(points: Array, tets: Indices) -> Array:
    """Return the volumes (e,) of ten-node tetrahedra."""
    return jacobian_bounds(points, tets)[1] / 6.0


def straighten(points: Array, tets: Indices, n_corners: int) -> int:
    """Move nodes towards the middles of their edges, in place, until no element is turned over.

    ``points`` (n, 3), of which the first ``n_corners`` are corners. Coarse elements at tightly
    curved faces would otherwise be turned over by their own curved sides. Half of the way is gone
    at a time, so that little of the shape is lost. Returns how many nodes were moved.
    """
    moved: set[int] = set()
    for step in range(_STEPS):
        lower, mean = jacobian_bounds(points, tets)
        bad = lower <= FLATTEST * mean
        if not bad.any():
            break
        keep = 0.5 if step < _STEPS // 2 else 0.0
        nodes = tets[bad, 4:].ravel()
        ends = np.array([(tets[bad, i], tets[bad, j]) for i, j in TET_EDGES]).transpose(2, 0, 1)
        nodes, first = np.unique(nodes, return_index=True)
        middles = points[ends.reshape(-1, 2)[first]].mean(axis=1)
        curved = np.any(points[nodes] != middles, axis=1)
        points[nodes] = middles + keep * (points[nodes] - middles)
        moved.update(nodes[curved & (nodes >= n_corners)].tolist())
    return len(moved)
