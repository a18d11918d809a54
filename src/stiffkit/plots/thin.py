"""Fewer postures of a map than it holds: figures show no more than paper can."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stiffkit.plots.sweep import POINT, sweep_of

DRAWN_POSTURES = 40_000
"""Postures of a map that a figure is drawn from: finer than print at the width of a page."""

_NOT_DRAWN = ("compliance", "deflection", "joint")


def thinned(dataset: xr.Dataset, limit: int = DRAWN_POSTURES) -> xr.Dataset:
    """Return a map with at most ``limit`` postures, evenly picked, and without what is not drawn.

    Along each axis the first and the last value are kept, and the middle one if there is one. The
    finest axes are thinned first; no axis is thinned below three values.
    """
    sweep = sweep_of(dataset)
    drawn = dataset.drop_vars(_NOT_DRAWN, errors="ignore")
    dims = sweep.axes if sweep.is_grid else (POINT,)
    counts = list(sweep.shape)
    while np.prod(counts) > limit and max(counts) > 3:
        finest = int(np.argmax(counts))
        counts[finest] = max(3, counts[finest] - 1 - counts[finest] // 50)
    picks = {
        dim: _evenly(n, count)
        for dim, n, count in zip(dims, sweep.shape, counts, strict=True)
        if count < n
    }
    return drawn.isel(picks)


def _evenly(n: int, count: int) -> NDArray[np.intp]:
    """Return ``count`` indices below n, or one less: with both ends, and the middle of an odd n."""
    if n % 2 == 1 and count % 2 == 0:
        count -= 1
    return np.round(np.linspace(0, n - 1, count)).astype(np.intp)
