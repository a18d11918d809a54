"""The basis of the fast model of all geometries, made at some anchors and proved at others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import StiffkitError
from stiffkit.kinematics import SpanningTree
from stiffkit.study.sweep.anchors import Anchors
from stiffkit.study.sweep.family import Geometry
from stiffkit.study.sweep.frequencies import Basis
from stiffkit.study.sweep.group import Groups
from stiffkit.vibration import FastGeometries, ModalModel, modes_in_own_axes

Array = NDArray[np.float64]

TOLERANCE = 1e-4
"""Relative error of a frequency, at postures that the basis is proved at, that is good enough."""

_MODES = 2
"""Modes of each posture that the basis is made from: only the lowest is asked for."""
_MADE_FROM = 4
"""Postures of an anchor that the basis is made from."""
_PROVED_AT = 3
_LARGEST = 36
_STEP = 4
_MARGIN = 2.0
"""How much more the last vectors may change a frequency than where the basis was proved."""

_NONE = Basis(np.zeros((0, 0)), 0.0, 0.0, 0)


@dataclass(frozen=True, eq=False)
class _Solved:
    """Postures of one anchor by the full model."""

    geometry: Geometry
    q: Array
    """(n_coordinates, F)."""
    snapshots: Array
    """(n_energy, F `_MODES`), of unit energy, in own axes."""
    frequencies: Array
    """(F,), Hz, the lowest."""


def train_basis(groups: Groups, anchors: Anchors) -> Basis:
    """Return the smallest basis whose frequencies are good enough; an empty one if none is.

    Every fourth anchor proves what the others make; of a single one, other postures do.
    """
    made: list[_Solved] = []
    proved: list[_Solved] = []
    for k in range(anchors.number):
        proves = k % 4 == 3
        solved = _solve(groups, anchors, k, _PROVED_AT if proves else _MADE_FROM)
        (proved if proves else made).extend(solved)
    # What has its masses in another way than the first has other coordinates, and no part in this.
    made, proved = (_alike(those, made[:1]) for those in (made, proved))
    if not proved and made:
        proved = _solve(groups, anchors, 0, _PROVED_AT, start=_MADE_FROM)
    if not made or not proved:
        return _NONE
    U, values, _ = np.linalg.svd(np.hstack([s.snapshots for s in made]), full_matrices=False)
    most = min(int(np.sum(values > 1e-9 * values[0])), _LARGEST)
    for size in [*range(2 * _STEP, most, _STEP), most]:
        basis = _proved(groups, U[:, :size], proved)
        if basis.error <= TOLERANCE:
            return basis
    return _NONE


def _alike(solved: list[_Solved], first: list[_Solved]) -> list[_Solved]:
    """Return those with as many elastic coordinates as the first."""
    sizes = {one.snapshots.shape[0] for one in first}
    return [one for one in solved if one.snapshots.shape[0] in sizes]


def _solve(groups: Groups, anchors: Anchors, k: int, count: int, start: int = 0) -> list[_Solved]:
    """Return some postures of an anchor by the full model; none where its masses are at fault."""
    family = groups.family
    at = np.roll(family.frequency_postures, -(k * count + start))
    at = at[np.isfinite(anchors.q[0, k, at])][:count]
    try:
        geometry = family.geometry(anchors.values[:, k])
        tree = SpanningTree.of(geometry.robot)
        q = anchors.q[: tree.n_coordinates, k, at]
        modes = modes_in_own_axes(ModalModel(tree, geometry.length), q, _MODES)
    except StiffkitError:
        return []
    if not at.size or not np.isfinite(modes.frequencies[0]).all():
        return []
    snapshots = modes.vectors.reshape(-1, modes.vectors.shape[2]).T
    return [_Solved(geometry, q, np.asarray(snapshots), modes.frequencies[0])]


def _proved(groups: Groups, U: Array, proved: list[_Solved]) -> Basis:
    """Return a basis with the largest error at postures that it was not made from."""
    grouped: dict[bytes, list[_Solved]] = {}
    for solved in proved:
        grouped.setdefault(solved.geometry.pattern, []).append(solved)
    error = change = 0.0
    for alike in grouped.values():
        own = [solved.geometry for solved in alike]
        # Interpreted: a handful of postures would not be worth compiling.
        model = FastGeometries(groups.of(own[0]).tree, own[0].length, U, "numpy")
        constants = [model.constants(g.robot, g.length, g.elasticity) for g in own]
        q = np.full((alike[0].q.shape[0], len(alike), _PROVED_AT), np.nan)
        exact = np.full((len(alike), _PROVED_AT), np.nan)
        for i, solved in enumerate(alike):
            q[:, i, : solved.frequencies.size] = solved.q
            exact[i, : solved.frequencies.size] = solved.frequencies
        found, changed = model.lowest(constants, q)
        known = np.isfinite(exact)
        errors = np.abs(found[known] / exact[known] - 1.0)
        error = max(error, float(np.nan_to_num(errors, nan=np.inf).max()))
        change = max(change, float(np.nan_to_num(changed[known], nan=np.inf).max()))
    checked = sum(solved.frequencies.size for solved in proved)
    return Basis(U, _MARGIN * change, error, checked)
