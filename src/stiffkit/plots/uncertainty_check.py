"""The first order beside samples: standard deviations, and what the bands hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.draw import add_legend

Array = NDArray[np.float64]

_LOOKS = (
    ("#0072b2", "o"),
    ("#d55e00", "s"),
    ("#009e73", "^"),
    ("#cc79a7", "D"),
    ("#222222", "v"),
    ("#56b4e9", "P"),
)
"""Colours of Okabe and Ito, one marker each."""

MOST = len(_LOOKS)
"""Quantities in one figure."""

_GUIDE: dict[str, Any] = {"color": "#5a5a5a", "linewidth": 0.9, "zorder": 1}
_CHANCE: dict[str, Any] = {"color": "#dddddd", "linewidth": 0.0, "zorder": 0}


@style.styled
def check_figure(dataset: xr.Dataset, names: Sequence[str], model: str) -> Figure:
    """Draw standard deviations of samples over those of the first order, and the coverage.

    Each dot is a posture that was sampled; standard deviations are in per cent of the value.
    """
    own = dataset.sel(model=model)
    figure = style.new_figure(style.PAGE, 2.7)
    left, right = figure.subplots(1, 2)
    largest = 0.0
    for place, (name, (colour, marker)) in enumerate(zip(names, _LOOKS, strict=False)):
        value = np.abs(_of(own, name, "first_order"))
        first, sampled = (100.0 * _of(own, name, k) / value for k in ("first_order_sigma", "sigma"))
        dots: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": "", "alpha": 0.8}
        left.plot(first, sampled, **dots)
        coverage = 100.0 * _of(own, name, "coverage")
        coverage = coverage[np.isfinite(coverage)]
        spread = np.linspace(-0.25, 0.25, coverage.size) if coverage.size > 1 else np.zeros(1)
        right.plot(coverage, place + spread[: coverage.size], **dots)
        largest = float(np.nanmax([largest, *first, *sampled]))
    left.plot([0.0, 2.0 * largest], [0.0, 2.0 * largest], **_GUIDE)
    left.set_xlim(0.0, 1.1 * (largest or 1.0))
    left.set_ylim(0.0, 1.1 * (largest or 1.0))
    left.set_xlabel("by the first order (% of the value)")
    left.set_ylabel("by samples (% of the value)")
    style.set_title(left, "standard deviation")
    _draw_asked(right, float(dataset.attrs["confidence"]), int(dataset.attrs["samples"]))
    right.set_yticks(range(len(names)), names, parse_math=False)
    right.set_ylim(len(names) - 0.4, -0.6)
    right.tick_params(axis="y", length=0.0)
    for axes in (left, right):
        axes.grid(visible=True)
        axes.set_axisbelow(True)
    style.set_heading(figure, f"First order and {dataset.attrs['samples']} samples, {model} model")
    handles = [
        Line2D([], [], color=c, marker=m, linestyle="", label=name)
        for name, (c, m) in zip(names, _LOOKS, strict=False)
    ]
    asked = f"{100.0 * float(dataset.attrs['confidence']):g} % asked"
    chance = Patch(label="by chance, two standard deviations", **_CHANCE)
    guide = Line2D([], [], label=f"equal; {asked}", **_GUIDE)
    add_legend(figure, [], more=[*handles, guide, chance], columns=5)
    return figure


def _of(own: xr.Dataset, name: str, key: str) -> Array:
    return np.asarray(own[f"{name}_sampled_{key}"].values, dtype=np.float64)


def _draw_asked(axes: Axes, confidence: float, samples: int) -> None:
    """Draw the confidence that was asked for, and how far samples leave it by chance."""
    by_chance = 2.0 * np.sqrt(confidence * (1.0 - confidence) / samples)
    low, high = (100.0 * (confidence + sign * by_chance) for sign in (-1.0, 1.0))
    axes.axvspan(low, min(high, 100.0), **_CHANCE)
    axes.axvline(100.0 * confidence, **_GUIDE)
    left, right = axes.get_xlim()
    axes.set_xlim(min(left, low - 1.0), min(max(right, high + 1.0), 100.5))
    axes.set_xlabel("samples within the band (%)")
    style.set_title(axes, "coverage")
