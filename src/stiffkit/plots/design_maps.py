"""The maps of two designs side by side, in the same colours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.curves import Curve, draw_curves
from stiffkit.plots.draw import Panel, add_legend, aspect_of, draw_panel, height_of, position_text
from stiffkit.plots.quantities import main_quantities, quantities_of
from stiffkit.plots.scale import Scale, add_colour_bar
from stiffkit.plots.sweep import (
    Sweep,
    axis_unit,
    cases_of,
    is_planar,
    middle_posture,
    models_of,
    status_of,
    sweep_of,
    unit_of,
    values_of,
)
from stiffkit.plots.thin import thinned
from stiffkit.plots.units import DisplayUnit
from stiffkit.study import Quantity

Array = NDArray[np.float64]


@style.styled
def design_maps_figure(
    maps: Mapping[str, xr.Dataset], quantity: Quantity, load: str | None, model: str
) -> Figure:
    """Draw one quantity of one model over the workspaces of several designs, by their names.

    Of three swept coordinates the middle slice is shown, of one a curve for each design.

    Raises:
        OutputError: if a map does not hold what is asked for.
    """
    drawn = {name: thinned(dataset) for name, dataset in maps.items()}
    sweeps = {name: sweep_of(dataset) for name, dataset in drawn.items()}
    values = {n: values_of(dataset, quantity, model, load) for n, dataset in drawn.items()}
    statuses = {name: status_of(dataset, model) for name, dataset in drawn.items()}
    unit = unit_of(next(iter(drawn.values())), quantity, load)
    title = f"{quantity.label}, load {load}" if quantity.per_load else quantity.label
    title += f", {model} model"
    if all(len(sweep.axes) == 1 for sweep in sweeps.values()):
        return _curves(sweeps, values, statuses, unit, title)
    panels, names = [], []
    for name, sweep in sweeps.items():
        middle = middle_posture(statuses[name])[2:] if sweep.is_grid else ()
        cut = (slice(None),) * min(2, len(sweep.shape)) + middle
        panels.append((sweep, unit.of(values[name][cut]), statuses[name][cut]))
        place = position_text(
            (axis, float(sweep.coordinates[axis][i]))
            for axis, i in zip(sweep.axes[2:], middle, strict=False)
        )
        names.append(f"{name}, at {place}" if place else name)
    return _side_by_side(panels, names, unit, title)


Choice = tuple[Quantity, str | None, str]
"""Quantity, load and model of a figure."""


def map_choices(
    maps: Mapping[str, xr.Dataset], asked: Sequence[tuple[str, str | None]]
) -> list[Choice]:
    """Return what to compare maps by, the most telling first, for the first model of the maps.

    That is what was ``asked``, by quantity and load; or if no map shows any of it, each main
    quantity under the load that makes most of it.
    """
    first = next(iter(maps.values()))
    model = models_of(first)[0]
    possible = [
        (quantity, load, model)
        for quantity in quantities_of(first)
        for load in cases_of(first, quantity)
        if all(_tells_something(one, quantity, load, model) for one in maps.values())
    ]
    wanted = [c for name, load in asked for c in possible if (c[0].name, c[1]) == (name, load)]
    if wanted:
        return list(dict.fromkeys(wanted))
    main = main_quantities(first, planar=is_planar(first))
    return [
        max(of_quantity, key=lambda choice: _largest(first, choice))
        for quantity in main
        if (of_quantity := [choice for choice in possible if choice[0] is quantity])
    ]


def _largest(dataset: xr.Dataset, choice: Choice) -> float:
    quantity, load, model = choice
    values = values_of(dataset, quantity, model, load)
    return float(np.max(values, initial=0.0, where=np.isfinite(values)))


def _tells_something(dataset: xr.Dataset, quantity: Quantity, load: str | None, model: str) -> bool:
    there = quantity.name in dataset and load in cases_of(dataset, quantity)
    if not there or model not in models_of(dataset):
        return False
    values = values_of(dataset, quantity, model, load)
    return bool((np.isfinite(values) & (values != 0.0)).any())


def _side_by_side(
    panels: list[tuple[Sweep, Array, NDArray[np.int8]]],
    names: list[str],
    unit: DisplayUnit,
    title: str,
) -> Figure:
    scale = Scale.of(*(values for _, values, _ in panels))
    height = max(height_of(sweep, style.PAGE * 0.72 / len(panels)) for sweep, _, _ in panels) + 0.95
    figure = style.new_figure(style.PAGE, height)
    all_axes = []
    for number, ((sweep, values, status), name) in enumerate(zip(panels, names, strict=True)):
        axes = figure.add_subplot(
            1,
            len(panels),
            number + 1,
            projection="3d" if not sweep.is_grid and len(sweep.axes) == 3 else None,
        )
        panel = Panel.of(sweep, values, status, scale)
        image = draw_panel(axes, panel, equal=aspect_of(sweep) is not None)
        style.set_title(axes, name)
        all_axes.append(axes)
    add_colour_bar(figure, image, all_axes, scale, unit.symbol)
    style.set_heading(figure, title)
    add_legend(figure, [status for _, _, status in panels], is_grid=panels[0][0].is_grid)
    return figure


def _curves(
    sweeps: Mapping[str, Sweep],
    values: Mapping[str, Array],
    statuses: Mapping[str, NDArray[np.int8]],
    unit: DisplayUnit,
    title: str,
) -> Figure:
    figure = style.new_figure(style.PAGE, 2.4)
    scale = Scale.of(*(unit.of(v) for v in values.values()))
    panels = figure.subplots(1, len(sweeps), sharey=True, squeeze=False)[0]
    handles = []
    for axes, (name, sweep) in zip(panels, sweeps.items(), strict=True):
        axis = sweep.axes[0]
        x = axis_unit(axis).of(sweep.coordinates[axis])
        curve = Curve(name, unit.of(values[name]), style.LINES["refined"])
        handles += draw_curves(axes, axis, x, [curve], {name: statuses[name]}, scale)[1:]
        style.set_title(axes, name)
    style.set_heading(figure, unit.label(title))
    add_legend(figure, [], more=handles[:1])
    return figure
