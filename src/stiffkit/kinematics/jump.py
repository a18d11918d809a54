"""From postures of one geometry straight to those of another one, in a single piece each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics.tracking import (
    CLOSED,
    CONTRACTION,
    FIRST_CORRECTION,
    SETTLED,
    same_branch,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_ITERATIONS = 8
_SUPERLINEAR = 1e-3
"""The last correction over the one before: what converges like this is exact to rounding."""


def jump(
    step: Callable[[Array], Array], start: Array, asked: Array, response: Array
) -> tuple[Array, Mask]:
    """Return postures (n, N) at tool coordinates ``asked`` (m, N), and which of them are reached.

    Newton's method runs from ``start`` (n, N), postures of another geometry near by or NaN, with
    what `stiffkit.kinematics.tracking.Tracker` asks of a piece: a small first correction, steady
    contraction and the same branch at both ends. ``response`` (n, N) is that of the posture that
    the start was taken from, in its own geometry. What converges slowly counts as not reached.
    ``step`` is the kernel of `ClosureEquations.newton_step`.
    """
    n = start.shape[0]
    x = np.concatenate([start, asked])
    active = np.isfinite(x).all(axis=0)
    reached = np.zeros(x.shape[1], dtype=bool)
    limit = np.full(x.shape[1], FIRST_CORRECTION)
    first = last = response
    with np.errstate(invalid="ignore"):
        for iteration in range(_ITERATIONS):
            out = step(x)
            residual, size = np.sqrt(out[n]), np.sqrt(out[n + 1])
            good = active & (size <= np.maximum(limit, SETTLED)) & np.isfinite(residual)
            exact = (residual <= CLOSED) & (size <= np.minimum(SETTLED, _SUPERLINEAR * limit))
            if iteration == 0:
                first, last = out[n + 2 :], out[n + 2 :].copy()
            np.copyto(x[:n], out[:n], where=good)
            np.copyto(last, out[n + 2 :], where=good)
            reached |= good & exact
            active = good & ~exact
            limit = np.where(good, CONTRACTION * size, limit)
            if not active.any():
                break
        reached &= same_branch(first, last) & same_branch(response, last)
    return x[:n], reached


def responses(step: Callable[[Array], Array], q: Array, asked: Array) -> Array:
    """Return the responses (n, N) to a disturbance at postures (n, N), for `jump`."""
    n = q.shape[0]
    return step(np.concatenate([q, asked]))[n + 2 :]
