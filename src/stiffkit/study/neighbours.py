"""Which postures of a study lie beside each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csgraph
from scipy.spatial import cKDTree

from stiffkit.study.grid import PoseGrid

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_NEAREST = 6
"""Neighbours of each posture in a list of points."""


@dataclass(frozen=True, eq=False)
class Neighbours:
    """The n postures of a study that have an answer, numbered from 0, and their neighbours."""

    pairs: Indices
    """(E, 2). They connect all postures: an island among holes has one pair to the posture that is
    nearest to it."""
    middle: int
    """The posture nearest to the middle of the study."""


def neighbours(grid: PoseGrid, known: NDArray[np.bool_]) -> Neighbours:
    """Return the neighbours among the poses of a grid that are ``known`` (N,), one at least.

    On a grid they are the next ones along each coordinate, in a list of points the nearest ones.
    Lengths and angles are compared by their share of the range.
    """
    places = np.stack(list(grid.values().values()))
    low, high = places.min(axis=1, keepdims=True), places.max(axis=1, keepdims=True)
    spread = np.where(high > low, high - low, 1.0)
    places = ((places - (low + high) / 2.0) / spread)[:, known].T
    pairs = _nearest(places) if grid.listed else _beside(grid.shape, known)
    # Where several are as near, rounding is not to choose among them.
    middle = int(np.argmin(np.round(np.sum(places**2, axis=1), 9)))
    return Neighbours(np.concatenate([pairs, _bridges(places, pairs, middle)]), middle)


def lines_through(grid: PoseGrid, pose: int) -> dict[str, Indices]:
    """Return the poses (n_axis,) on the line through a pose along each axis; none of a list."""
    if grid.listed:
        return {}
    lines = {}
    for axis, (name, values) in enumerate(grid.axes.items()):
        step = int(np.prod(grid.shape[axis + 1 :]))
        first = pose - (pose // step % values.size) * step
        lines[name] = first + step * np.arange(values.size)
    return lines


def _beside(shape: tuple[int, ...], known: NDArray[np.bool_]) -> Indices:
    numbers = np.where(known, np.cumsum(known) - 1, -1).reshape(shape)
    pairs = [np.zeros((0, 2), dtype=np.intp)]
    for axis in range(len(shape)):
        along = np.moveaxis(numbers, axis, 0)
        both = np.stack([along[:-1].ravel(), along[1:].ravel()], axis=1)
        pairs.append(both[(both >= 0).all(axis=1)])
    return np.concatenate(pairs)


def _nearest(places: Array) -> Indices:
    count = min(_NEAREST + 1, len(places))
    _, found = cKDTree(places).query(places, k=[*range(1, count + 1)])
    pairs = np.stack([np.repeat(np.arange(len(places)), count), found.ravel()], axis=1)
    return np.asarray(pairs[pairs[:, 0] != pairs[:, 1]], dtype=np.intp)


def _bridges(places: Array, pairs: Indices, middle: int) -> Indices:
    """Return one pair from each island to the posture nearest to it around the middle."""
    a, b = pairs.T
    linked = coo_array((np.ones(len(pairs)), (a, b)), shape=(len(places), len(places)))
    _, island = csgraph.connected_components(linked, directed=False)
    around = np.flatnonzero(island == island[middle])
    apart = np.flatnonzero(island != island[middle])
    if apart.size == 0:
        return np.zeros((0, 2), dtype=np.intp)
    distance, nearest = cKDTree(places[around]).query(places[apart])
    order = np.lexsort((distance, island[apart]))
    _, first = np.unique(island[apart][order], return_index=True)
    chosen = order[first]
    return np.stack([around[nearest[chosen]], apart[chosen]], axis=1)
