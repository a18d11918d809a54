"""Bars: what causes the variance of a quantity, and which part to stiffen first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stiffkit.design.uncertainty.summary import PartRow, part_rows
from stiffkit.plots import style
from stiffkit.plots.draw import add_legend
from stiffkit.plots.uncertainty_maps import title_of

Array = NDArray[np.float64]

MOST_BARS = 12
"""More sources or parts than so many are drawn as one bar."""

_BAR: dict[str, Any] = {"height": 0.62, "color": style.LINES["refined"]["color"], "linewidth": 0.0}
_OTHERS = "#9a9a9a"
_RANGE: dict[str, Any] = {"color": style.INK, "linewidth": 0.9}
_WORST: dict[str, Any] = {
    "color": style.LINES["simplified"]["color"],
    "marker": "D",
    "linestyle": "",
}


@style.styled
def sources_figure(dataset: xr.Dataset, names: Sequence[str], model: str) -> Figure:
    """Draw the share of each source in the variance of some quantities, one panel for each.

    A bar is the mean over the workspace, a line across its end goes from the smallest share of a
    posture to the largest.
    """
    sources = [str(source) for source in dataset["source"].values]
    shares = {name: _shares(dataset, name, model) for name in names}
    mean_of_all = np.mean([np.nanmean(s, axis=1) for s in shares.values()], axis=0)
    order = np.argsort(-mean_of_all, kind="stable")
    if len(sources) <= MOST_BARS:
        shown, rest = order, order[:0]
    else:
        shown, rest = order[: MOST_BARS - 1], order[MOST_BARS - 1 :]
    labels = [sources[i] for i in shown] + ([f"{rest.size} others"] if rest.size else [])
    figure, panels = _stage(len(names), len(labels))
    for axes, (name, share) in zip(panels, shares.items(), strict=True):
        rows = [share[i] for i in shown] + ([share[rest].sum(axis=0)] if rest.size else [])
        for place, row in enumerate(rows):
            is_rest = place == shown.size
            look = _BAR | ({"color": _OTHERS} if is_rest else {})
            axes.barh(place, 100.0 * np.nanmean(row), **look)
            axes.plot(100.0 * np.array([np.nanmin(row), np.nanmax(row)]), [place] * 2, **_RANGE)
        style.set_title(axes, title_of(dataset, name))
        axes.set_xlim(0.0, 100.0)
        axes.set_xlabel("share of the variance (%)")
    _name_bars(panels, labels)
    style.set_heading(figure, f"Where the error comes from, {model} model")
    handle = Line2D([], [], label="smallest to largest over the workspace", **_RANGE)
    add_legend(figure, [], more=[handle])
    return figure


def _shares(dataset: xr.Dataset, name: str, model: str) -> Array:
    """Return the share (S, P) of each source at the postures with an answer."""
    shares = np.asarray(dataset[f"{name}_cause"].sel(model=model).values, dtype=float)
    shares = shares.reshape(len(shares), -1)
    return shares[:, np.isfinite(shares).all(axis=0)]


@style.styled
def ranking_figure(dataset: xr.Dataset, name: str) -> Figure:
    """Draw the share of each part in a quantity, and what stiffening it gains per kilogram."""
    rows = part_rows(dataset, name)
    shown, rest = rows[:MOST_BARS], rows[MOST_BARS:]
    labels = [row.name for row in shown] + ([f"{len(rest)} others"] if rest else [])
    weighed = any(np.isfinite(row.gain_per_kg) for row in shown)
    figure, panels = _stage(2 if weighed else 1, len(labels))
    _draw_shares(panels[0], shown, rest)
    if weighed:
        for place, row in enumerate(shown):
            if np.isfinite(row.gain_per_kg):
                panels[1].barh(place, 100.0 * row.gain_per_kg, **_BAR)
            else:
                panels[1].annotate(
                    f"a {row.kind}" if row.kind != "link" else "mass not known",
                    (0.0, place),
                    xytext=(3.0, 0.0),
                    textcoords="offset points",
                    va="center",
                    color=_OTHERS,
                )
        style.set_title(panels[1], "gain by stiffening")
        panels[1].set_xlabel("per kilogram added (%/kg)")
        panels[1].set_xlim(left=min(0.0, panels[1].get_xlim()[0]))
    _name_bars(panels, labels)
    style.set_heading(figure, f"Which part to stiffen first: {title_of(dataset, name)}")
    add_legend(figure, [], more=[Line2D([], [], label="where it is the worst", **_WORST)])
    return figure


def _draw_shares(axes: Axes, shown: Sequence[PartRow], rest: Sequence[PartRow]) -> None:
    for place, row in enumerate(shown):
        axes.barh(place, 100.0 * row.share, **_BAR)
        axes.plot(100.0 * row.share_at_worst, place, **_WORST)
    if rest:
        look = _BAR | {"color": _OTHERS}
        axes.barh(len(shown), 100.0 * sum(row.share for row in rest), **look)
        axes.plot(100.0 * sum(row.share_at_worst for row in rest), len(shown), **_WORST)
    axes.axvline(0.0, color=style.INK, linewidth=0.6)
    style.set_title(axes, "share of the part, mean over the workspace")
    axes.set_xlabel("share (%)")


def _stage(n_panels: int, n_bars: int) -> tuple[Figure, list[Axes]]:
    figure = style.new_figure(style.PAGE, 0.95 + 0.19 * max(n_bars, 3))
    return figure, list(figure.subplots(1, n_panels, sharey=True, squeeze=False)[0])


def _name_bars(panels: Sequence[Axes], labels: Sequence[str]) -> None:
    panels[0].set_yticks(range(len(labels)), labels, parse_math=False)
    panels[0].set_ylim(len(labels) - 0.4, -0.6)
    for axes in panels:
        axes.tick_params(axis="y", length=0.0)
        axes.grid(visible=True, axis="x")
        axes.set_axisbelow(True)
