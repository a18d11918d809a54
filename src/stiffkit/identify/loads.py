"""The loads of the load cases: whether they show all of a compliance, and their pseudo-inverse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import qr

from stiffkit.errors import FieldError
from stiffkit.link.checks import LOADS
from stiffkit.spatial.rotation import Array

DEPENDENT = 1e-6
"""Loads are dependent if their smallest singular value is this small, over the largest."""
POOR = 1e2
"""A condition number above this is worth a word."""
PURE = 1e-6
"""A component of a missing load that is this small, over the largest, is left out of its words."""


@dataclass(frozen=True, eq=False)
class Loads:
    """The wrenches of m >= 6 load cases that span all six directions."""

    wrenches: Array
    """(m, 6), N and N m, at the reference point."""
    inverse: Array
    """(m, 6), the pseudo-inverse of the 6 x m matrix of equation 2: k = D @ inverse."""
    length: float
    """m, by which moments were divided to be compared with forces: the ratio of typical sizes."""
    condition: float
    """Condition number of the directions of the loads: each case scaled to one, so that the
    amplitudes do not count."""


def check_loads(wrenches: ArrayLike, case_names: Sequence[str]) -> Loads:
    """Return the loads (m, 6) in N and N m of named cases, with their pseudo-inverse.

    Raises `FieldError` where a load is missing, zero or not finite, and where the loads leave a
    direction out, which it names.
    """
    W = np.asarray(wrenches, dtype=float)
    _check_numbers(W, case_names)
    length = _typical_size(W[:, 3:]) / _typical_size(W[:, :3])
    scale = np.repeat([1.0, 1.0 / length], 3)
    directions = W * scale / np.linalg.norm(W * scale, axis=1, keepdims=True)
    U, values, _ = np.linalg.svd(directions.T)
    rank = int((values > DEPENDENT * values[0]).sum())
    if rank < 6:
        _refuse(len(W), U[:, rank:], length)
    inverse = np.linalg.pinv((W * scale).T) * scale
    return Loads(W, inverse, length, float(values[0] / values[-1]))


def _typical_size(vectors: Array) -> float:
    """Return the geometric mean of the lengths of the rows that are not zero, 1 if all are."""
    sizes = np.linalg.norm(vectors, axis=1)
    return float(np.exp(np.mean(np.log(sizes[sizes > 0.0])))) if sizes.any() else 1.0


def _check_numbers(W: Array, case_names: Sequence[str]) -> None:
    if W.ndim != 2 or W.shape[1] != 6:
        raise FieldError(
            f"loads must have the shape (cases, 6) and have {W.shape}",
            mend="give three forces and three moments for each load case",
        )
    if len(W) == 0:
        raise FieldError("there is no load case", mend="give at least 6 load cases")
    if len(W) != len(case_names):
        raise FieldError(f"there are {len(case_names)} load cases and loads for {len(W)}")
    for name, wrench in zip(case_names, W, strict=True):
        if not np.isfinite(wrench).all():
            raise FieldError(f"load case {name}: its load {wrench} is not finite")
        if not wrench.any():
            raise FieldError(
                f"load case {name} has no load",
                mend="give its force and moment, or leave the case out",
            )


def _refuse(cases: int, missing: Array, length: float) -> None:
    """Raise `FieldError` for loads that leave out the directions in the columns (6, q)."""
    words = "; ".join(_load_words(column, length) for column in _readable_basis(missing).T)
    what = (
        f"there are only {cases} load cases, and a compliance needs at least 6"
        if cases < 6
        else f"the {cases} load cases are dependent: they span only {6 - missing.shape[1]} of 6 "
        "directions"
    )
    raise FieldError(
        f"{what}; nothing is known of what these do: {words}",
        mend="add load cases with these loads, at the reference point",
    )


def _readable_basis(columns: Array) -> Array:
    """Return the basis (6, q) of the same space in which q components are those of the identity."""
    order = qr(columns.T, pivoting=True, mode="r")[1]
    pivots = np.sort(order[: columns.shape[1]])
    return np.asarray(columns @ np.linalg.inv(columns[pivots]))


def _load_words(scaled: Array, length: float) -> str:
    """Return a load, its moments in units of force times ``length``, in words."""
    kept = np.abs(scaled) > PURE * np.abs(scaled).max()
    if kept.sum() == 1:
        return LOADS[int(np.argmax(kept))]
    load = scaled * np.repeat([1.0, length], 3)
    units = ["N"] * 3 + ["N m"] * 3
    parts = [f"{LOADS[i]} = {load[i]:.3g} {units[i]}" for i in np.flatnonzero(kept)]
    return " with ".join(parts)
