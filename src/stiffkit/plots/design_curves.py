"""Curves of designs: results over the one parameter that is varied, and how a search went."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.curves import MARKED_UP_TO
from stiffkit.plots.design_marks import (
    START_LOOK,
    chosen_look,
    line_look,
    look_of,
    mark_handles,
    other_look,
)
from stiffkit.plots.designs import START, Designs, Result
from stiffkit.plots.draw import add_legend

Array = NDArray[np.float64]

MOST_COLUMNS = 3

NEAR = 1.0
"""A bound farther away from all values than this, over their span, is not drawn."""

_START_LEVEL: Mapping[str, Any] = {
    "color": "#8c8c8c",
    "linewidth": 0.9,
    "linestyle": (0, (1.2, 1.0)),
    "zorder": 1,
}
_BEYOND: Mapping[str, Any] = {
    "facecolor": style.UNREACHABLE_FACE,
    "edgecolor": style.UNREACHABLE_HATCH,
    "hatch": "/////",
    "linewidth": 0.0,
}


@style.styled
def parameter_figure(designs: Designs) -> Figure:
    """Draw every result of both models over the first parameter, the only one that is varied."""
    results = [result for result in designs.results if result.is_telling()]
    columns = 2 if len(results) in (2, 4) else min(MOST_COLUMNS, len(results))
    rows = -(-len(results) // columns)
    width = style.PAGE if columns > 1 else style.COLUMN
    figure = style.new_figure(width, 2.05 * rows + 0.75)
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    has_bounds = False
    for axes, result in zip(grid.flat, results, strict=False):
        _draw_curves(axes, designs, result)
        has_bounds |= _set_limits(axes, result)
    for axes in grid.flat[len(results) :]:
        axes.set_visible(False)
    for number in range(len(results)):
        # Of each column, the lowest panel that is drawn.
        if number + columns >= len(results):
            axes = grid.flat[number]
            axes.tick_params(labelbottom=True)
            axes.set_xlabel(designs.parameters[0].label)
    style.set_heading(figure, f"Results over {designs.parameters[0].name}")
    add_legend(
        figure, [], more=_handles(designs, has_bounds=has_bounds), columns=4 if columns > 1 else 2
    )
    return figure


@style.styled
def progress_figure(designs: Designs) -> Figure:
    """Draw the best value of the only objective after each design that a method has tried."""
    objective = designs.objectives[0]
    several = len(designs.models) > 1
    figure = style.new_figure(style.PAGE if several else style.COLUMN, 2.6)
    panels = figure.subplots(1, len(designs.models), squeeze=False)[0]
    handles: list[Artist] = []
    for axes, model in zip(panels, designs.models, strict=True):
        handles = []
        for number, (method, best) in enumerate(_best_so_far(designs, model)):
            look = dict(style.BRANCHES[number % len(style.BRANCHES)])
            look.pop("marker")
            axes.step(np.arange(1, best.size + 1), objective.unit.of(best), where="post", **look)
            handles.append(Line2D([], [], label=method, **look))
        axes.axhline(objective.unit.of(objective.values[model][START]), **_START_LEVEL)
        style.set_title(axes, f"{model} model")
        axes.set_xlabel("designs tried by the method")
        axes.set_ylabel(objective.label)
        axes.grid(visible=True)
        axes.set_axisbelow(True)
    handles.append(Line2D([], [], label="start", **_START_LEVEL))
    style.set_heading(figure, f"Best feasible {objective.title} so far")
    add_legend(figure, [], more=handles, columns=5 if several else 3)
    return figure


def _draw_curves(axes: Axes, designs: Designs, result: Result) -> None:
    parameter = designs.parameters[0]
    x = parameter.unit.of(parameter.values)
    order = np.argsort(x, kind="stable")
    for model in designs.models:
        y = result.unit.of(result.values[model])
        look = look_of(model) if x.size <= MARKED_UP_TO else line_look(model)
        axes.plot(x[order], y[order], zorder=3, **look)
        axes.plot(x[START], y[START], linestyle="", zorder=4, **START_LOOK)
        for other, design in designs.chosen.items():
            is_own = other == model
            mark = chosen_look(other) if is_own else other_look(other)
            axes.plot(x[design], y[design], linestyle="", zorder=6 if is_own else 5, **mark)
    style.set_title(axes, f"{result.title}: {result.goal}")
    axes.set_ylabel(result.unit.symbol)
    room = 0.04 * float(np.ptp(x)) or 1.0
    axes.set_xlim(x.min() - room, x.max() + room)
    axes.grid(visible=True)
    axes.set_axisbelow(True)


def _set_limits(axes: Axes, result: Result) -> bool:
    """Set the limits of y, and draw the bounds that lie near the values; tell if there are any."""
    values = np.concatenate([result.unit.of(v) for v in result.values.values()])
    known = values[np.isfinite(values)]
    if not known.size:
        return False
    low, high = float(known.min()), float(known.max())
    span = high - low or abs(high) or 1.0
    bounds = result.unit.of([*result.bounds.values()])
    near = bounds[(bounds > low - NEAR * span) & (bounds < high + NEAR * span)]
    low, high = np.min(near, initial=low), np.max(near, initial=high)
    margin = 0.07 * span
    from_zero = not near.size and 0.0 < low < 0.35 * high
    axes.set_ylim(0.0 if from_zero else low - margin, high + margin)
    if near.size:
        last, end = (near.max(), high) if result.sense == "below" else (near.min(), low)
        axes.axhspan(last, end + result.sign * margin, zorder=0, **_BEYOND)
        for bound in near:
            axes.axhline(bound, color=style.INK, linewidth=0.8, zorder=2)
    return bool(near.size)


def _best_so_far(designs: Designs, model: str) -> Iterator[tuple[str, Array]]:
    """Yield each method with its best feasible value after each design (n,), SI."""
    objective = designs.objectives[0]
    worst = np.inf * objective.sign
    values = np.where(designs.feasible[model], objective.values[model], worst)
    values = np.where(np.isfinite(values), values, worst)
    better = np.minimum if objective.sign > 0 else np.maximum
    origin = np.array(designs.origin)
    for method in dict.fromkeys(designs.origin[START + 1 :]):
        best = better.accumulate(values[origin == method])
        yield method, np.where(np.isfinite(best), best, np.nan)


def _handles(designs: Designs, *, has_bounds: bool) -> list[Artist]:
    handles: list[Artist] = []
    for model in designs.models:
        handles.append(Line2D([], [], label=f"{model} model", **line_look(model)))
    handles += mark_handles(designs)
    if len(designs.models) > 1:
        handles += [
            Line2D([], [], linestyle="", label=f"{model}, by the other model", **other_look(model))
            for model in designs.chosen
        ]
    if has_bounds:
        handles.append(Patch(label="beyond the bound", **_BEYOND))
    return handles
