"""Parallel coordinates: what the designs of a front have in common, and where they differ."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.design_marks import chosen_look, line_look, of_model, values_by
from stiffkit.plots.designs import START, Designs, Parameter, Result
from stiffkit.plots.draw import add_legend
from stiffkit.plots.units import format_value

Array = NDArray[np.float64]
Column = Parameter | Result

FEW = 5
"""A front of fewer designs says little: then feasible designs are drawn, the best ones first."""
MOST_LINES = 60

MARGIN = 0.05
"""How far the axis of a result goes beyond all that is drawn, over its span."""

_ROUNDING = 1e-6
"""Differences below this share of the values are rounding, or what optimisers leave."""

_BEYOND = "#c9c9c9"
_START: Mapping[str, Any] = {
    "color": style.INK,
    "linestyle": (0, (1.2, 1.0)),
    "linewidth": 1.6,
}
_BAR: Mapping[str, Any] = {"linewidth": 5.0, "solid_capstyle": "butt", "zorder": 1}
_LETTERS = 108
"""Letters that stand side by side over the width of a page."""


@style.styled
def parallel_figure(designs: Designs) -> Figure:
    """Draw parameters, objectives and constraints of each front, with start and chosen designs."""
    columns: tuple[Column, ...] = (*designs.parameters, *_telling(designs))
    rows = len(designs.models)
    figure = style.new_figure(style.PAGE, 2.25 * rows + 0.75)
    panels = figure.subplots(rows, 1, squeeze=False)[:, 0]
    for axes, model in zip(panels, designs.models, strict=True):
        lines = _shown(designs, model)
        image = _draw_row(axes, designs, model, columns, lines)
        what = "front" if designs.front[model].sum() >= FEW else "best designs"
        title = f"{what} of the {model} model ({len(lines)} designs)"
        axes.set_title(title, pad=15.0, parse_math=False)
        bar = figure.colorbar(image, ax=axes, fraction=0.03, pad=0.015, aspect=18)
        bar.outline.set_linewidth(0.4)
        bar.ax.tick_params(width=0.4, length=2.0)
        bar.set_label(designs.objectives[0].label)
    style.set_heading(figure, "Parameters and results")
    add_legend(figure, [], more=_handles(designs), columns=4)
    return figure


def _telling(designs: Designs) -> list[Result]:
    """Return the objectives, and the constraints in which designs that are drawn differ."""
    drawn = {model: [START, *designs.chosen.values()] for model in designs.models}
    for model in designs.models:
        drawn[model] += _shown(designs, model).tolist()
    return [result for result in designs.results if result.is_telling(drawn)]


def _shown(designs: Designs, model: str) -> NDArray[np.intp]:
    """Return the designs that are drawn, best in the first objective first."""
    members = designs.front_of(model)
    if len(members) < FEW:
        first = designs.objectives[0]
        members = np.flatnonzero(designs.feasible[model])
        order = np.argsort(first.sign * first.values[model][members], kind="stable")
        return members[order][:MOST_LINES]
    if len(members) > MOST_LINES:
        return members[np.linspace(0, len(members) - 1, MOST_LINES).round().astype(np.intp)]
    return members


def _draw_row(
    axes: Axes,
    designs: Designs,
    model: str,
    columns: tuple[Column, ...],
    lines: NDArray[np.intp],
) -> ScalarMappable:
    drawn = np.append(lines, [START, *designs.chosen.values()]).astype(np.intp)
    limits = [_limits(column, model, drawn) for column in columns]
    heights = np.array(
        [
            (column.unit.of(values_by(column, model)) - low) / (high - low)
            for column, (low, high) in zip(columns, limits, strict=True)
        ]
    )
    x = np.arange(len(columns))
    first = designs.objectives[0]
    shades = first.unit.of(first.values[model])
    known = shades[lines][np.isfinite(shades[lines])]
    low, high = (known.min(), known.max()) if known.size else (0.0, 1.0)
    image = ScalarMappable(Normalize(low, high if high > low else low + 1.0), style.MAP_COLOURS)
    # The best lines last, so that they lie above the others.
    for design in lines[::-1]:
        colour = image.to_rgba(np.array([shades[design]]))[0]
        axes.plot(x, heights[:, design], color=colour, linewidth=0.7, zorder=2)
    axes.plot(x, heights[:, START], zorder=4, **_START)
    for other, design in reversed(list(designs.chosen.items())):
        axes.plot(x, heights[:, design], zorder=5, **_chosen_line(other))
    for place, column, (bottom, top) in zip(x, columns, limits, strict=True):
        _draw_column(axes, int(place), float(bottom), float(top))
        if isinstance(column, Result):
            bound = float(column.unit.of(column.bounds[model]))
            _draw_bound(axes, int(place), column, (bound - bottom) / (top - bottom))
    _label_columns(axes, columns)
    return image


def _limits(column: Column, model: str, drawn: NDArray[np.intp]) -> Array:
    """Return the ends of an axis, in display units: of the range, or of all that is drawn."""
    if isinstance(column, Parameter):
        # The start may lie outside the range.
        low = min(column.low, column.values[drawn].min())
        high = max(column.high, column.values[drawn].max())
    else:
        values = column.values[model][drawn]
        known = values[np.isfinite(values)]
        low, high = (known.min(), known.max()) if known.size else (0.0, 1.0)
        size = max(abs(low), abs(high))
        # What differs by rounding only lies in the middle of its axis.
        margin = MARGIN * (high - low if high - low > _ROUNDING * size else size)
        low, high = low - margin, high + margin
    return column.unit.of([low, high if high > low else low + (abs(low) or 1.0)])


def _draw_column(axes: Axes, place: int, low: float, high: float) -> None:
    axes.plot([place, place], [0.0, 1.0], color=style.INK, linewidth=0.6, zorder=3)
    ends: dict[str, Any] = {
        "ha": "center",
        "fontsize": 6.0,
        "color": style.INK,
        "parse_math": False,
    }
    axes.text(place, -0.03, _short(low), va="top", **ends)
    axes.text(place, 1.03, _short(high), va="bottom", **ends)


def _draw_bound(axes: Axes, place: int, result: Result, height: float) -> None:
    """Mark what lies beyond the bound of a result, if any of it is shown."""
    if 0.0 < height < 1.0:
        end = 1.0 if result.sense == "below" else 0.0
        axes.plot([place, place], [height, end], color=_BEYOND, **_BAR)


def _label_columns(axes: Axes, columns: tuple[Column, ...]) -> None:
    width = max(8, _LETTERS // len(columns))
    labels = [_column_label(column, width) for column in columns]
    axes.set_xticks(range(len(columns)), labels, fontsize=6.5)
    axes.tick_params(axis="x", length=0.0, pad=9.0)
    axes.set_yticks([])
    axes.set_xlim(-0.35, len(columns) - 0.65)
    axes.set_ylim(0.0, 1.0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    for line in axes.lines:
        line.set_clip_on(False)


def _column_label(column: Column, width: int) -> str:
    name = column.title if isinstance(column, Result) else column.name
    lines = textwrap.wrap(name, width) or [name]
    if column.unit.symbol:
        lines.append(f"({column.unit.symbol})")
    if isinstance(column, Result):
        is_objective = column.role == "objective"
        lines.append(f"{column.sense}imise" if is_objective else column.goal)
    return "\n".join(lines)


def _short(value: float) -> str:
    return format_value(float(f"{value:.3g}"))


def _chosen_line(model: str) -> dict[str, Any]:
    look = chosen_look(model)
    size = 0.6 * look["markersize"]
    edge = withStroke(linewidth=3.2, foreground="white")
    return {
        **look,
        **line_look(model),
        "markersize": size,
        "linewidth": 1.9,
        "path_effects": [edge],
    }


def _handles(designs: Designs) -> list[Artist]:
    handles: list[Artist] = [Line2D([], [], label="start", **_START)]
    handles += [
        Line2D([], [], label=of_model(designs, "chosen by", model), **_chosen_line(model))
        for model in designs.chosen
    ]
    if designs.constraints:
        handles.append(Line2D([], [], color=_BEYOND, label="beyond the bound", **_BAR))
    return handles
