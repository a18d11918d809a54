"""Reductions over the postures of each geometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.study.sweep.spec import Column

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def reduce(column: Column, values: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return a statistic (G,) of values (G, P), and the posture (G,) where it stands.

    NaN are postures without an answer: they do not count. Where all are, so is the statistic, and
    the posture is -1; it is so too for statistics that stand at no posture.
    """
    known = ~np.isnan(values)
    count = known.sum(axis=1)
    nowhere = np.full(values.shape[0], -1, dtype=np.intp)
    if column.has_place:
        sign = 1.0 if column.statistic == "min" else -1.0
        # A direction that does not yield is infinitely stiff, and still an answer.
        ranked = np.minimum(sign * values, np.finfo(float).max)
        at = np.argmin(np.where(known, ranked, np.inf), axis=1)
        return values[np.arange(at.size), at], np.where(count > 0, at, nowhere)
    if column.statistic == "percentile":
        return _percentile(values, count, float(column.value or 0.0)), nowhere
    with np.errstate(invalid="ignore", divide="ignore"):
        if column.statistic == "mean":
            return np.sum(np.where(known, values, 0.0), axis=1) / count, nowhere
        threshold = float(column.value or 0.0)
        beyond = values > threshold if column.statistic == "share above" else values < threshold
        return np.sum(beyond, axis=1) / count, nowhere


def shares(column: Column, values: Array) -> Array:
    """Return how much each of the values (P,) counts in a statistic: its derivatives (P,).

    Where two postures are equally bad the first one counts. A share of postures changes in leaps
    and has no derivative: NaN, where a value is.
    """
    known = np.isfinite(values)
    weights = np.zeros(values.size)
    if not known.any():
        return weights
    if column.has_place:
        weights[reduce(column, values[None])[1]] = 1.0
    elif column.statistic == "mean":
        weights[known] = 1.0 / known.sum()
    elif column.statistic == "percentile":
        ranked = np.flatnonzero(known)[np.argsort(values[known], kind="stable")]
        place = (ranked.size - 1) * float(column.value or 0.0) / 100.0
        below = int(place)
        weights[ranked[below]] = 1.0 - (place - below)
        weights[ranked[min(below + 1, ranked.size - 1)]] += place - below
    else:
        weights[known] = np.nan
    return weights


def _percentile(values: Array, count: NDArray[np.intp], percent: float) -> Array:
    """Return the percentile of each row, between neighbouring values in proportion."""
    ranked = np.sort(values, axis=1)  # NaN come last
    last = np.maximum(count - 1, 0)
    place = last * (percent / 100.0)
    below = np.floor(place).astype(np.intp)
    rows = np.arange(values.shape[0])
    low, high = ranked[rows, below], ranked[rows, np.minimum(below + 1, last)]
    with np.errstate(invalid="ignore"):  # infinite values, which are equal
        between = low + (place - below) * (high - low)
    return np.asarray(np.where(low == high, low, between))
