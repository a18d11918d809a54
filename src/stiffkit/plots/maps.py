"""Maps: a quantity over the workspace in colour, and the two models side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiffkit.errors import OutputError
from stiffkit.plots import style
from stiffkit.plots.curves import curve_figure, draw_curves, model_curves
from stiffkit.plots.draw import (
    Panel,
    add_legend,
    aspect_of,
    draw_panel,
    height_of,
    position_text,
)
from stiffkit.plots.quantities import quantity_named
from stiffkit.plots.scale import Scale, add_colour_bar
from stiffkit.plots.sweep import (
    Sweep,
    axis_unit,
    middle_posture,
    models_of,
    ratio_of,
    status_of,
    sweep_of,
    unit_of,
    values_of,
)
from stiffkit.plots.units import DisplayUnit
from stiffkit.study import Quantity

Array = NDArray[np.float64]

SLICES = 6
"""A map over three coordinates is shown as at most this many slices."""


@style.styled
def map_figure(dataset: xr.Dataset, quantity: str, model: str, load: str | None = None) -> Figure:
    """Draw one quantity of one model over the workspace.

    Two swept coordinates give a coloured map with contour lines, three give slices at several
    values of the last one (any further coordinate stays in the middle), one gives a curve, and a
    list of points gives coloured points.

    Args:
        dataset: a stiffness map.
        quantity: name of one of `QUANTITIES`, such as "deflection_xy".
        model: "refined" or "simplified".
        load: name of the load case, for a deflection.

    Raises:
        OutputError: if the map does not hold what is asked for.
    """
    what = quantity_named(dataset, quantity)
    sweep = sweep_of(dataset)
    if len(sweep.axes) == 1:
        return curve_figure(dataset, quantity, load, models=(model,))
    unit = unit_of(dataset, what, load)
    values = unit.of(values_of(dataset, what, model, load))
    status = status_of(dataset, model)
    title = _what_of(what, load)
    if sweep.is_grid and len(sweep.axes) > 2:
        return _slices(sweep, values, status, unit, f"{title}, {model} model")
    return _single(Panel.of(sweep, values, status, Scale.of(values)), sweep, unit, title, model)


@style.styled
def model_comparison_figure(dataset: xr.Dataset, quantity: str, load: str | None = None) -> Figure:
    """Draw the refined and the simplified model side by side, and their ratio.

    Both models share one colour scale, for only then equal colours mean equal stiffness; it is
    logarithmic where they lie far apart, and the contour lines, each model's own, show the
    pattern that the shared colours may hide. Of three swept coordinates the middle slice is shown.

    Args:
        dataset: a stiffness map with both models.
        quantity: name of one of `QUANTITIES`.
        load: name of the load case, for a deflection.

    Raises:
        OutputError: if the map does not hold what is asked for.
    """
    what = quantity_named(dataset, quantity)
    models = models_of(dataset)
    if set(models) != {"refined", "simplified"}:
        raise OutputError(
            f"only the {' and '.join(models)} model is in the map, so there is nothing to compare",
            mend="compute the map with both models, refined and simplified",
        )
    sweep = sweep_of(dataset)
    unit = unit_of(dataset, what, load)
    both = {model: unit.of(values_of(dataset, what, model, load)) for model in models}
    statuses = {model: status_of(dataset, model) for model in models}
    ratio = ratio_of(dataset, what, load)
    title = _what_of(what, load)
    if len(sweep.axes) == 1:
        return _compare_curves(sweep, both, statuses, ratio, unit.label(title))
    middle = middle_posture(statuses["refined"])[2:] if sweep.is_grid else ()
    cut = _plane(sweep, middle)
    scale = Scale.of(*(values[cut] for values in both.values()))
    panels = [
        (f"{model} model", Panel.of(sweep, both[model][cut], statuses[model][cut], scale))
        for model in ("refined", "simplified")
    ]
    if np.isfinite(ratio[cut]).any():
        of_ratio = Scale.of(ratio[cut])
        status = statuses["refined"][cut]
        panels.append(
            (
                "refined / simplified",
                Panel.of(sweep, ratio[cut], status, of_ratio, style.RATIO_COLOURS),
            )
        )
    if middle:
        title += f", at {_fixed(sweep, middle)}"
    return _side_by_side(panels, sweep, unit, title)


def _single(panel: Panel, sweep: Sweep, unit: DisplayUnit, title: str, model: str) -> Figure:
    height = height_of(sweep, style.COLUMN * 0.68) + 0.95
    figure = style.new_figure(style.COLUMN, height)
    axes = _axes_for(panel, figure)
    image = draw_panel(axes, panel, equal=aspect_of(sweep) is not None)
    style.set_title(axes, f"{model} model")
    style.set_heading(figure, title)
    add_colour_bar(figure, image, axes, panel.scale, unit.symbol)
    add_legend(figure, [panel.status], is_grid=panel.is_grid)
    return figure


def _slices(
    sweep: Sweep, values: Array, status: NDArray[np.int8], unit: DisplayUnit, title: str
) -> Figure:
    count = sweep.shape[2]
    chosen = np.unique(np.linspace(0, count - 1, min(count, SLICES)).round().astype(int))
    rest = middle_posture(status)[3:]
    columns = min(3, len(chosen))
    rows = -(-len(chosen) // columns)
    height = rows * (height_of(sweep, style.PAGE * 0.82 / columns) + 0.25) + 0.75
    figure = style.new_figure(style.PAGE, height)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    volume = values[(slice(None),) * 3 + rest]
    scale = Scale.of(volume)
    levels = scale.levels(volume, count=5)
    for axes, index in zip(grid.flat, chosen, strict=False):
        cut = _plane(sweep, (int(index), *rest))
        panel = replace(Panel.of(sweep, values[cut], status[cut], scale), levels=levels)
        image = draw_panel(axes, panel, equal=aspect_of(sweep) is not None)
        style.set_title(axes, _fixed(sweep, (int(index), *rest)))
        axes.label_outer()
    for axes in grid.flat[len(chosen) :]:
        axes.set_visible(False)
    add_colour_bar(figure, image, list(grid.flat), scale, unit.symbol)
    style.set_heading(figure, title)
    add_legend(figure, [status])
    return figure


def _side_by_side(
    panels: Sequence[tuple[str, Panel]], sweep: Sweep, unit: DisplayUnit, title: str
) -> Figure:
    height = height_of(sweep, style.PAGE * (0.24 if len(panels) == 3 else 0.36)) + 0.95
    figure = style.new_figure(style.PAGE, height)
    all_axes = []
    for column, (name, panel) in enumerate(panels):
        axes = _axes_for(panel, figure, position=(1, len(panels), column + 1))
        image = draw_panel(axes, panel, equal=aspect_of(sweep) is not None)
        style.set_title(axes, name)
        all_axes.append(axes)
        if column and panel.is_grid:
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
        if column == 1:
            add_colour_bar(figure, image, all_axes, panel.scale, unit.symbol)
        if column == 2:
            add_colour_bar(figure, image, axes, panel.scale, "ratio")
    style.set_heading(figure, title)
    add_legend(figure, [panel.status for _, panel in panels], is_grid=sweep.is_grid)
    return figure


def _compare_curves(
    sweep: Sweep,
    both: dict[str, Array],
    statuses: dict[str, NDArray[np.int8]],
    ratio: Array,
    label: str,
) -> Figure:
    figure = style.new_figure(style.PAGE, 2.4)
    left, right = figure.subplots(1, 2)
    axis = sweep.axes[0]
    x = axis_unit(axis).of(sweep.coordinates[axis])
    handles = draw_curves(left, axis, x, model_curves(both), statuses, Scale.of(*both.values()))
    style.set_title(left, label)
    refined = model_curves({"refined": ratio}), {"refined": statuses["refined"]}
    draw_curves(right, axis, x, *refined, Scale.of(ratio))
    style.set_title(right, "refined / simplified")
    add_legend(figure, [], more=handles)
    return figure


def _axes_for(panel: Panel, figure: Figure, position: tuple[int, int, int] = (1, 1, 1)) -> Axes:
    in_space = not panel.is_grid and len(panel.axes) == 3
    return figure.add_subplot(*position, projection="3d" if in_space else None)


def _plane(sweep: Sweep, rest: tuple[int, ...]) -> tuple[slice | int, ...]:
    """Return the index of the plane of the first two axes, or of all points."""
    return (slice(None),) * min(2, len(sweep.shape)) + rest


def _fixed(sweep: Sweep, index: tuple[int, ...]) -> str:
    axes = sweep.axes[2:]
    return position_text(
        (axis, float(sweep.coordinates[axis][i])) for axis, i in zip(axes, index, strict=True)
    )


def _what_of(quantity: Quantity, load: str | None) -> str:
    return f"{quantity.label}, load {load}" if quantity.per_load else quantity.label
