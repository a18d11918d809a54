"""What samples say beside the first order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.uncertainty.first_order import Bands, FirstOrder
from stiffkit.design.uncertainty.sampling import Sampled
from stiffkit.design.uncertainty.spec import UncertaintySpec
from stiffkit.study.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

_MEANINGS = {
    "first_order": "by the first order",
    "first_order_sigma": "standard deviation by the first order",
    "mean": "mean of the samples",
    "sigma": "standard deviation of the samples",
    "low": "lower end of the band of the samples",
    "high": "upper end of the band of the samples",
    "coverage": "share of the samples within the band of the first order",
}


def add_check(
    dataset: xr.Dataset, spec: UncertaintySpec, first_order: FirstOrder, sampled: Sampled
) -> None:
    """Add what samples say beside the first order, at the postures that were sampled."""
    for name, places in first_order.family.grid.values().items():
        unit = "rad" if name.startswith("r") else "m"
        about = {"units": unit, "long_name": f"tool coordinate {name} of a sampled posture"}
        dataset.coords[f"sampled_{name}"] = ("sampled_posture", places, about)
    dataset.attrs |= {"samples": sampled.values.shape[2], "samples_refused": sampled.refused}
    for i, asked in enumerate(spec.asked):
        found = [
            _compared(spec, first_order.bands(asked, model), sampled.values[m, i])
            for m, model in enumerate(spec.models)
        ]
        long_name = QUANTITIES[asked.quantity].long_name
        for key, meaning in _MEANINGS.items():
            about = {
                "units": "1" if key == "coverage" else asked.units,
                "long_name": f"{long_name}, {meaning}",
            }
            rows = np.stack([one[key] for one in found])
            dataset[f"{asked.name}_sampled_{key}"] = (("model", "sampled_posture"), rows, about)


def _compared(spec: UncertaintySpec, bands: Bands, values: Array) -> dict[str, Array]:
    """Return statistics (P,) of samples (n, P) beside the bands; NaN where there is no answer."""
    half = spec.standard_deviations * bands.sigma
    tail = 50.0 * (1.0 - spec.confidence)
    kept = np.flatnonzero((bands.sigma > 0.0) & np.isfinite(values).any(axis=0))
    known = np.where(np.isfinite(values[:, kept]), values[:, kept], np.nan)
    inside = np.abs(known - bands.values[kept]) <= half[kept]
    low, high = (np.nanpercentile(known, share, axis=0) for share in (tail, 100.0 - tail))
    found = {
        "first_order": bands.values[kept],
        "first_order_sigma": bands.sigma[kept],
        "mean": np.nanmean(known, axis=0),
        "sigma": np.nanstd(known, axis=0),
        "low": low,
        "high": high,
        "coverage": inside.sum(axis=0) / np.isfinite(known).sum(axis=0),
    }
    spread = {key: np.full(bands.values.size, np.nan) for key in found}
    for key, row in found.items():
        spread[key][kept] = row
    return spread
