"""What a study of uncertainty comes to, read off its dataset."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.study.quantities import QUANTITIES, Quantity

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

_TIE = 9
"""Decimals of shares by which they are ordered: equal parts keep the order of the file."""


@dataclass(frozen=True)
class Coverage:
    """Share of the samples within the bands, over the postures that were sampled."""

    mean: float
    lowest: float
    highest: float


@dataclass(frozen=True)
class Summary:
    """One quantity of one model over the workspace, SI."""

    name: str
    """In the dataset."""
    quantity: Quantity
    load: str | None
    model: str
    postures: int
    """That have an answer."""
    mean: float
    """Of the values."""
    mean_half: float
    """Mean of half the widths of the bands."""
    worst: float
    """The smallest stiffness or the largest deflection."""
    worst_half: float
    """Half the width of the band there."""
    worst_at: dict[str, float]
    """Tool coordinates, m and rad."""
    causes: dict[str, float]
    """Share of each source in the variance, mean over the workspace, the largest first."""
    coverage: Coverage | None
    """None where nothing was sampled, or nothing scatters."""

    @property
    def title(self) -> str:
        """Quantity and load in words."""
        return f"{self.quantity.label}, load {self.load}" if self.load else self.quantity.label


@dataclass(frozen=True)
class PartRow:
    """The share of a part in a quantity of the refined model."""

    name: str
    kind: str
    share: float
    """Mean over the workspace."""
    share_at_worst: float
    mass: float
    """kg; NaN where there is none."""
    gain_per_kg: float
    """1/kg; NaN where there is no mass."""


def asked_names(dataset: xr.Dataset) -> list[str]:
    """Return the names of the quantities that were asked for."""
    return [str(name) for name, v in dataset.data_vars.items() if "quantity" in v.attrs]


def summaries(dataset: xr.Dataset) -> list[Summary]:
    """Return a summary of each quantity by each model; none where no posture has an answer."""
    models = [str(model) for model in dataset["model"].values]
    found = (_summary(dataset, name, m) for m in models for name in asked_names(dataset))
    return [one for one in found if one is not None]


def _summary(dataset: xr.Dataset, name: str, model: str) -> Summary | None:
    own = dataset.sel(model=model)
    values, high = _flat(own[name]), _flat(own[f"{name}_high"])
    known = np.flatnonzero(np.isfinite(high))
    if not known.size:
        return None
    about = own[name].attrs
    quantity = QUANTITIES[about["quantity"]]
    half = high - values
    order = np.argmax if quantity.worst_is_largest else np.argmin
    worst = known[int(order(values[known]))]
    shares = np.asarray(own[f"{name}_cause"].values, dtype=float)
    means = np.nanmean(shares.reshape(len(shares), -1)[:, known], axis=1)
    causes = zip(map(str, dataset["source"].values), means.tolist(), strict=True)
    return Summary(
        name=name,
        quantity=quantity,
        load=about.get("load"),
        model=model,
        postures=known.size,
        mean=float(values[known].mean()),
        mean_half=float(half[known].mean()),
        worst=float(values[worst]),
        worst_half=float(half[worst]),
        worst_at=_place(own[name], int(worst)),
        causes=dict(sorted(causes, key=lambda item: -round(item[1], _TIE))),
        coverage=_coverage(own, name),
    )


def _flat(variable: xr.DataArray) -> Array:
    return np.asarray(variable.values, dtype=float).ravel()


def _place(variable: xr.DataArray, index: int) -> dict[str, float]:
    """Return the tool coordinates of a posture by its number."""
    where = dict(zip(variable.dims, np.unravel_index(index, variable.shape), strict=True))
    at = variable.isel({dim: int(i) for dim, i in where.items()})
    return {str(name): float(at[name]) for name in at.coords if name not in ("model", "point")}


def _coverage(own: xr.Dataset, name: str) -> Coverage | None:
    key = f"{name}_sampled_coverage"
    if key not in own:
        return None
    found = _flat(own[key])
    found = found[np.isfinite(found)]
    if not found.size:
        return None
    return Coverage(float(found.mean()), float(found.min()), float(found.max()))


def part_rows(dataset: xr.Dataset, name: str) -> list[PartRow]:
    """Return the parts by their share in a quantity of the refined model, the largest first.

    None where nothing of it was ranked: it is zero everywhere, or of another model.
    """
    if "part" not in dataset.coords or f"{name}_share" not in dataset:
        return []
    found = (row for row in _parts(dataset, name) if np.isfinite(row.share))
    return sorted(found, key=lambda row: -round(row.share, _TIE))


def _parts(dataset: xr.Dataset, name: str) -> Iterator[PartRow]:
    for i, part in enumerate(dataset["part"].values):
        own = dataset.isel(part=i)
        yield PartRow(
            str(part),
            str(own["part_kind"].values),
            float(own[f"{name}_share"]),
            float(own[f"{name}_share_at_worst"]),
            float(own["part_mass"]),
            float(own[f"{name}_gain_per_kg"]),
        )
