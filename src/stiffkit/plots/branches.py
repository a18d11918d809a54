"""Curves of the natural frequencies, each mode followed by its shape."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiffkit.errors import OutputError
from stiffkit.plots import style
from stiffkit.plots.curves import Curve, draw_curves
from stiffkit.plots.draw import add_legend, position_text
from stiffkit.plots.scale import Scale
from stiffkit.plots.sweep import axis_unit, models_of, status_of, sweep_of
from stiffkit.plots.units import Kind, display_unit

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BranchLine:
    """The frequencies of followed modes along a line through the workspace, or over a list."""

    axis: str
    """Tool coordinate along it; "" for the number of the point."""
    x: Array
    """(n,), in display units."""
    values: Array
    """(n_branches, n), Hz; NaN where there is no answer."""
    status: NDArray[np.int8]
    """(n,)."""
    fixed: dict[str, float]
    """The other swept coordinates, SI."""


def has_branches(dataset: xr.Dataset) -> bool:
    """Whether the dataset holds frequencies of followed modes, and not NaN only."""
    if "frequency_of_branch" not in dataset:
        return False
    return bool(np.isfinite(dataset["frequency_of_branch"].values).any())


def branch_model(dataset: xr.Dataset) -> str:
    """Return the model whose branches are shown: the first that has any."""
    for model in models_of(dataset):
        if np.isfinite(dataset["frequency_of_branch"].sel(model=model).values).any():
            return model
    raise OutputError(
        "the map has no natural frequencies to draw",
        mend="give the robot mass, and compute the map with frequencies",
    )


def branch_lines(dataset: xr.Dataset, model: str) -> list[BranchLine]:
    """Return a line along each axis of a grid, or the list of points."""
    sweep = sweep_of(dataset)
    status = status_of(dataset, model)
    if not sweep.is_grid:
        axis = sweep.axes[0] if len(sweep.axes) == 1 else ""
        places = axis_unit(axis).of(sweep.coordinates[axis]) if axis else np.arange(sweep.count) + 1
        x = np.asarray(places, dtype=np.float64)
        values = _values(dataset["frequency_of_branch"], model)
        return [BranchLine(axis, x, values, status, {})]
    lines = []
    for axis in sweep.axes:
        variable = dataset[f"frequency_along_{axis}"]
        through: dict[str, float] = json.loads(variable.attrs["tracking"])[model]["through"]
        cut: tuple[Any, ...] = tuple(
            slice(None)
            if other == axis
            else int(np.argmin(np.abs(sweep.coordinates[other] - through[other])))
            for other in sweep.axes
        )
        fixed = {other: through[other] for other in sweep.axes if other != axis}
        x = axis_unit(axis).of(sweep.coordinates[axis])
        lines.append(BranchLine(axis, x, _values(variable, model), status[cut], fixed))
    return lines


@style.styled
def branch_figure(dataset: xr.Dataset) -> Figure:
    """Draw the natural frequencies along one line for every swept coordinate, mode by mode.

    A mode keeps its colour through crossings. Modes are numbered by frequency near the middle of
    the workspace, where the lines meet. The refined model is drawn if the map has it.

    Raises:
        OutputError: if the map holds no frequencies.
    """
    model = branch_model(dataset)
    lines = branch_lines(dataset, model)
    unit = display_unit(Kind.FREQUENCY, np.concatenate([line.values.ravel() for line in lines]))
    scale = Scale.of(*(unit.of(line.values) for line in lines))
    figure = style.new_figure(style.COLUMN if len(lines) == 1 else style.PAGE, 2.6)
    panels = figure.subplots(1, len(lines), sharey=True, squeeze=False)[0]
    handles: list[Any] = []
    for axes, line in zip(panels, lines, strict=True):
        curves = [
            Curve(f"mode {k + 1}", unit.of(values), style.BRANCHES[k % len(style.BRANCHES)])
            for k, values in enumerate(line.values)
        ]
        entries = draw_curves(
            axes, line.axis, line.x, curves, {model: line.status}, scale, from_zero=False
        )
        handles = max(handles, entries, key=len)
        if line.fixed:
            style.set_title(axes, f"at {position_text(line.fixed.items())}")
    style.set_heading(figure, unit.label(f"Natural frequencies, {model} model"))
    add_legend(figure, [], more=handles, columns=5 if len(lines) > 1 else 4)
    return figure


def _values(variable: xr.DataArray, model: str) -> Array:
    return np.asarray(variable.sel(model=model).values, dtype=np.float64)
