"""What a map found, in words and in a table of key figures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stiffkit.plots import (
    Quantity,
    axis_unit,
    cases_of,
    columns_of,
    format_value,
    is_planar,
    models_of,
    quantities_of,
    status_of,
    sweep_of,
)

Array = NDArray[np.float64]

_REASONS = (
    (1, "out of reach: the legs cannot be assembled with the tool there"),
    (2, "singular: the drives cannot hold the tool, or the legs lock, so no stiffness exists"),
    (3, "uncontrolled: the platform is free to move although every drive holds"),
    (4, "outside the workspace that the robot file outlines"),
)


@dataclass(frozen=True)
class Spread:
    """Best, median and worst value of a quantity over the workspace, in display units."""

    best: float
    median: float
    worst: float

    @property
    def is_trivial(self) -> bool:
        """Whether there is nothing but zeros, infinities or no value at all."""
        return not np.isfinite(self.worst) or self.worst == self.best == 0.0


@dataclass(frozen=True)
class KeyFigure:
    """One row of the table of key figures."""

    quantity: Quantity
    load: str | None
    unit: str
    spreads: dict[str, Spread]
    """By model."""
    ratio: float
    """Median of refined over simplified; NaN if that means nothing."""


def key_figures(dataset: xr.Dataset) -> list[KeyFigure]:
    """Return best, median and worst of each quantity and load, without the empty rows."""
    left_out = {"deflection_translation"} if is_planar(dataset) else {"deflection_xy"}
    rows = []
    for quantity in quantities_of(dataset):
        if quantity.name in left_out or quantity.name.endswith("_max"):
            continue
        for load in cases_of(dataset, quantity):
            columns = columns_of(dataset, quantity, load)
            spreads = {
                model: spread_of(columns.unit.of(values), quantity)
                for model, values in columns.values.items()
            }
            if all(spread.is_trivial for spread in spreads.values()):
                continue
            ratio = _median(columns.ratio)
            rows.append(KeyFigure(quantity, load, columns.unit.symbol, spreads, ratio))
    return rows


def spread_of(values: Array, quantity: Quantity) -> Spread:
    """Return the spread of ``values``; NaN throughout if none of them is a number."""
    known = values[~np.isnan(values)]
    if known.size == 0:
        return Spread(np.nan, np.nan, np.nan)
    low, high = float(known.min()), float(known.max())
    best, worst = (low, high) if quantity.worst_is_largest else (high, low)
    # The middle value itself: averaging the two middle ones fails where they are infinite.
    middle = (known.size - 1) // 2
    median = float(np.partition(known, middle)[middle])
    return Spread(best, median, worst)


def scope_in_words(dataset: xr.Dataset) -> str:
    """Return over what, and how finely, the map was computed."""
    sweep = sweep_of(dataset)
    if not sweep.is_grid:
        return f"{grouped(sweep.count)} given postures"
    ranges = []
    for axis in sweep.axes:
        values = sweep.coordinates[axis]
        unit = axis_unit(axis)
        low, high = unit.text(values.min()), unit.text(values.max())
        ranges.append(f"{axis} from {low} to {high} ({values.size} values)")
    return f"{grouped(sweep.count)} postures: " + ", ".join(ranges)


def status_in_words(dataset: xr.Dataset) -> list[str]:
    """Return one sentence on the postures with an answer and one for each reason against one."""
    models = models_of(dataset)
    statuses = {model: status_of(dataset, model) for model in models}
    first = statuses[models[0]]
    if all(np.array_equal(first, other) for other in statuses.values()):
        return _status_sentences(first)
    return [
        f"{model.capitalize()} model: {sentence[0].lower()}{sentence[1:]}"
        for model, status in statuses.items()
        for sentence in _status_sentences(status)
    ]


def load_in_words(wrench: Sequence[float]) -> str:
    """Return a wrench on the tool (N, N m) without its zero parts."""
    parts = []
    for name, unit, part in (("force", "N", wrench[:3]), ("moment", "N m", wrench[3:])):
        if any(value != 0.0 for value in part):
            numbers = ", ".join(format_value(float(value)) for value in part)
            parts.append(f"{name} ({numbers}) {unit}")
    return " and ".join(parts) or "no load"


def loads_in_words(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """Return name and wrench of each load case, as far as the map tells them."""
    wrenches = json.loads(dataset.attrs.get("loads", "{}"))
    return [(str(name), load_in_words(wrench)) for name, wrench in wrenches.items()]


def texts_of(dataset: xr.Dataset, attribute: str) -> list[str]:
    """Return an attribute that holds texts; stores give a list of one back as a bare text."""
    texts = dataset.attrs.get(attribute, [])
    if isinstance(texts, str):
        return [texts] if texts else []
    return [str(text) for text in np.atleast_1d(texts)]


def grouped(number: int) -> str:
    """Return a count with thin spaces between thousands."""
    return f"{number:,}".replace(",", "\u202f")


def _status_sentences(status: NDArray[np.int8]) -> list[str]:
    total = status.size
    computed = int((status == 0).sum())
    sentences = [f"{grouped(computed)} of {grouped(total)} postures have an answer."]
    if computed == total:
        sentences = [f"All {grouped(total)} postures have an answer."]
    for value, reason in _REASONS:
        count = int((status == value).sum())
        if count:
            verb = "is" if count == 1 else "are"
            share = format_value(float(f"{100.0 * count / total:.2g}"))
            sentences.append(f"{grouped(count)} ({share} %) {verb} {reason}.")
    if (status == 1).any() and not computed:
        sentences.append(
            "Choose a workspace around the home posture; numbers without a unit are metres."
        )
    return sentences


def _median(values: Array | None) -> float:
    finite = values[np.isfinite(values)] if values is not None else np.empty(0)
    return float(np.median(finite)) if finite.size else float("nan")
