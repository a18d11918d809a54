"""Trade-offs: what one objective costs in another."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.design_marks import (
    FEASIBLE,
    INFEASIBLE,
    better_label,
    dot_handle,
    dots_look,
    draw_marks,
    hollow_look,
    limits_of,
    look_of,
    mark_handles,
    of_model,
)
from stiffkit.plots.designs import Designs, Result
from stiffkit.plots.draw import add_legend

Array = NDArray[np.float64]

ALIKE = 1.8
"""Two panels share an axis where that makes neither of them smaller by more than this."""

MOST_MARKS = 100
"""Dots of more designs are stored as a picture inside the drawing."""

MOST_OBJECTIVES = 6
"""A matrix shows at most so many."""


@style.styled
def tradeoff_figure(designs: Designs) -> Figure:
    """Draw the first two objectives of all designs against each other, a panel for each model.

    In each panel the front of that model is a line; beside it stand the designs of the other
    model's front, as this one judges them.
    """
    first, second = designs.objectives[:2]
    several = len(designs.models) > 1
    figure = style.new_figure(style.PAGE if several else style.COLUMN, 3.3 if several else 3.5)
    panels = figure.subplots(1, len(designs.models), squeeze=False)[0]
    for axes, model in zip(panels, designs.models, strict=True):
        _draw_pair(axes, designs, model, first, second)
        _draw_fronts(axes, designs, model, first, second)
        axes.set_xlabel(better_label(first))
        axes.set_ylabel(better_label(second))
        style.set_title(axes, f"{'judged by the ' if several else ''}{model} model")
    for column, name in ((first, "x"), (second, "y")):
        _share(panels, designs, column, name)
    style.set_heading(figure, f"{first.title} and {second.title}")
    add_legend(figure, [], more=_handles(designs, as_line=True), columns=4 if several else 3)
    return figure


@style.styled
def matrix_figure(designs: Designs) -> Figure:
    """Draw all pairs of objectives: below the diagonal by one model, above it by the other."""
    shown = designs.objectives[:MOST_OBJECTIVES]
    count = len(shown)
    figure = style.new_figure(style.PAGE, 1.45 * count + 0.8)
    grid = figure.subplots(count, count, squeeze=False)
    for number, objective in enumerate(shown):
        _write_name(grid[number, number], objective)
    for row, column in combinations(range(count), 2):
        upper, lower = grid[row, column], grid[column, row]
        _draw_cell(lower, designs, designs.models[0], shown[row], shown[column])
        lower.label_outer()
        if len(designs.models) > 1:
            _draw_cell(upper, designs, designs.models[1], shown[column], shown[row])
            _label_far_side(upper, is_top=row == 0, is_right=column == count - 1)
        else:
            upper.set_visible(False)
    judged = [f"below the diagonal by the {designs.models[0]} model"]
    judged += [f"above it by the {model} model" for model in designs.models[1:2]]
    style.set_heading(figure, f"Objectives, {', '.join(judged)}")
    add_legend(figure, [], more=_handles(designs, as_line=False), columns=4)
    return figure


def _draw_pair(axes: Axes, designs: Designs, model: str, first: Result, second: Result) -> None:
    x, y = first.unit.of(first.values[model]), second.unit.of(second.values[model])
    feasible = designs.feasible[model]
    for group, colour in ((~feasible, INFEASIBLE), (feasible, FEASIBLE)):
        dots = axes.scatter(x[group], y[group], s=4.0, color=colour, linewidths=0.0, zorder=1)
        # Thousands of marks would make a drawing that browsers are slow with.
        dots.set_rasterized(designs.count > MOST_MARKS)
    draw_marks(axes, designs, x, y)
    axes.set_xlim(*limits_of(designs, first, [model]))
    axes.set_ylim(*limits_of(designs, second, [model]))
    axes.grid(visible=True)
    axes.set_axisbelow(True)


def _draw_fronts(axes: Axes, designs: Designs, model: str, first: Result, second: Result) -> None:
    """Draw the front of a model as a line, and the designs of the others' fronts as it has them."""
    x, y = first.unit.of(first.values[model]), second.unit.of(second.values[model])
    for other in designs.models:
        members = designs.front_of(other)
        if other == model:
            axes.plot(x[members], y[members], zorder=4, **{**look_of(other), "linewidth": 1.0})
        else:
            axes.plot(x[members], y[members], zorder=3, **hollow_look(other))


def _share(panels: NDArray[np.object_], designs: Designs, column: Result, name: str) -> None:
    """Give all panels the same limits along one axis, where none of them suffers from it."""
    each = [limits_of(designs, column, [model]) for model in designs.models]
    low, high = min(limits[0] for limits in each), max(limits[1] for limits in each)
    if all(high - low <= ALIKE * np.ptp(limits) for limits in each):
        for axes in panels:
            axes.set(**{f"{name}lim": (low, high)})


def _draw_cell(axes: Axes, designs: Designs, model: str, first: Result, second: Result) -> None:
    _draw_pair(axes, designs, model, first, second)
    members = designs.front_of(model)
    x, y = first.unit.of(first.values[model]), second.unit.of(second.values[model])
    axes.plot(x[members], y[members], zorder=4, **dots_look(model))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(4))
    axes.set_xlabel(first.unit.symbol)
    axes.set_ylabel(second.unit.symbol)


def _label_far_side(axes: Axes, *, is_top: bool, is_right: bool) -> None:
    """Label a panel above the diagonal at the top and at the right end of the matrix."""
    axes.xaxis.set_label_position("top")
    axes.yaxis.set_label_position("right")
    axes.tick_params(
        bottom=False,
        left=False,
        top=True,
        right=True,
        labelbottom=False,
        labelleft=False,
        labeltop=is_top,
        labelright=is_right,
    )
    if not is_top:
        axes.set_xlabel("")
    if not is_right:
        axes.set_ylabel("")


def _write_name(axes: Axes, objective: Result) -> None:
    axes.set_axis_off()
    better = "small" if objective.sign > 0 else "large"
    text = f"{objective.label.replace(' ', chr(10), 1)}\n({better} is good)"
    axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes, parse_math=False)


def _handles(designs: Designs, *, as_line: bool) -> list[Artist]:
    handles = mark_handles(designs)
    for model in designs.models:
        if not designs.front[model].any():
            continue
        look = look_of(model) if as_line else dots_look(model)
        handles.append(Line2D([], [], label=of_model(designs, "front of", model), **look))
        if as_line and len(designs.models) > 1:
            label = "the same, judged by the other model"
            handles.append(Line2D([], [], label=label, **hollow_look(model)))
    handles.append(dot_handle(FEASIBLE, "feasible"))
    if not all(feasible.all() for feasible in designs.feasible.values()):
        handles.append(dot_handle(INFEASIBLE, "not feasible"))
    return handles
