"""Curves: quantities along straight lines through the workspace."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.draw import add_legend, axis_label, gap_names, position_text, unreachable_patch
from stiffkit.plots.quantities import quantity_named
from stiffkit.plots.scale import Scale, set_log_ticks
from stiffkit.plots.sweep import (
    OK,
    OUTSIDE,
    Sweep,
    axis_unit,
    middle_posture,
    models_of,
    status_of,
    sweep_of,
    unit_of,
    values_of,
)

Array = NDArray[np.float64]

MARKED_UP_TO = 25
"""Lines of at most this many postures show each posture with a marker."""


@style.styled
def curve_figure(
    dataset: xr.Dataset,
    quantity: str,
    load: str | None = None,
    *,
    models: tuple[str, ...] | None = None,
) -> Figure:
    """Draw a quantity along one line for every swept coordinate.

    The lines cross in the computed posture nearest to the middle of the workspace; all other
    coordinates keep their values there. A list of points with more than one varying coordinate is
    drawn over the number of the point.

    Args:
        dataset: a stiffness map.
        quantity: name of one of `QUANTITIES`.
        load: name of the load case, for a deflection.
        models: which models to draw; all that the map holds by default.

    Raises:
        OutputError: if the map does not hold what is asked for.
    """
    what = quantity_named(dataset, quantity)
    sweep = sweep_of(dataset)
    unit = unit_of(dataset, what, load)
    models = models or models_of(dataset)
    values = {model: unit.of(values_of(dataset, what, model, load)) for model in models}
    statuses = {model: status_of(dataset, model) for model in models}
    title = f"{what.label}, load {load}" if what.per_load else what.label
    lines = lines_through(sweep, middle_posture(statuses[models[0]]))
    figure = style.new_figure(style.COLUMN if len(lines) == 1 else style.PAGE, 2.3)
    panels = figure.subplots(1, len(lines), sharey=True, squeeze=False)[0]
    scale = Scale.of(*(values[model][line.cut] for model in models for line in lines))
    handles: list[Artist] = []
    for axes, line in zip(panels, lines, strict=True):
        along = {model: values[model][line.cut] for model in models}
        gaps = {model: statuses[model][line.cut] for model in models}
        entries = draw_curves(axes, line.axis, line.x, model_curves(along), gaps, scale)
        # A line with gaps explains one thing more.
        handles = max(handles, entries, key=len)
        style.set_title(axes, line.fixed)
    label = unit.label(title if len(models) > 1 else f"{title}, {models[0]} model")
    style.set_heading(figure, label)
    add_legend(figure, [], more=handles)
    return figure


@dataclass(frozen=True, eq=False)
class Curve:
    """One line in a plot."""

    label: str
    values: Array
    """(n,), in display units."""
    look: Mapping[str, Any]
    """Colour, line style and marker."""


def model_curves(values: Mapping[str, Array]) -> list[Curve]:
    """Return a curve for the values (n,), in display units, of each model."""
    curves = []
    for model, line in values.items():
        rigid = not np.isfinite(line).any() and not np.isnan(line).all()
        label = f"{model}: rigid" if rigid else f"{model} model"
        curves.append(Curve(label, line, style.LINES.get(model, style.LINES["refined"])))
    return curves


def draw_curves(
    axes: Axes,
    axis: str,
    x: Array,
    curves: Sequence[Curve],
    statuses: Mapping[str, NDArray[np.int8]],
    scale: Scale,
    *,
    from_zero: bool = True,
) -> list[Artist]:
    """Draw curves over ``x`` and return the legend entries.

    Args:
        axes: where to draw.
        axis: tool coordinate along x; "" for the number of the point.
        x: (n,), in display units.
        curves: with values (n,).
        statuses: (n,) for each model.
        scale: limits of y in this figure.
        from_zero: whether a linear scale begins at zero.
    """
    order = np.argsort(x, kind="stable")
    handles: list[Artist] = []
    for curve in curves:
        look = dict(curve.look)
        marker = look.pop("marker")
        shown = np.where(np.isfinite(curve.values), curve.values, np.nan)[order]
        axes.plot(x[order], shown, marker=marker if x.size <= MARKED_UP_TO else "", **look)
        handles.append(Line2D([], [], label=curve.label, **look))
    missing = np.all([(s != OK) & (s != OUTSIDE) for s in statuses.values()], axis=0)[order]
    if missing.any():
        _hatch(axes, x[order], missing)
        patch = unreachable_patch()
        patch.set_label(" or ".join(gap_names(np.concatenate(list(statuses.values())))))
        handles.append(patch)
    if scale.is_log:
        axes.set_yscale("log")
        margin = (scale.high / scale.low) ** 0.06
        limits = scale.low / margin, scale.high * margin
        set_log_ticks(axes.yaxis, Scale(*limits, is_log=True))
        axes.set_ylim(limits)
    else:
        height = (scale.high or 1.0) if from_zero else scale.high - scale.low
        bottom = 0.0 if from_zero else max(0.0, scale.low - 0.08 * height)
        axes.set_ylim(bottom=bottom, top=(scale.high or 1.0) + 0.08 * height)
    axes.set_xlim(x.min(), x.max() if x.size > 1 else x.min() + 1.0)
    axes.grid(visible=True)
    axes.set_axisbelow(True)
    axes.set_xlabel(axis_label(axis) if axis else "number of the point")
    return handles


@dataclass(frozen=True, eq=False)
class LineThrough:
    """A straight line through the workspace, or a list of points."""

    axis: str
    """Tool coordinate along it; "" for the number of the point."""
    x: Array
    """Display units."""
    cut: tuple[int | slice, ...]
    """Index of its postures in the sweep."""
    fixed: str
    """Where it lies, in words."""


def lines_through(sweep: Sweep, middle: tuple[int, ...]) -> list[LineThrough]:
    """Return a line along each axis of a grid, all through the posture at index ``middle``."""
    if not sweep.is_grid:
        axis = sweep.axes[0] if len(sweep.axes) == 1 else ""
        values = axis_unit(axis).of(sweep.coordinates[axis]) if axis else np.arange(sweep.count) + 1
        return [LineThrough(axis, np.asarray(values, dtype=np.float64), (slice(None),), "")]
    lines = []
    for k, axis in enumerate(sweep.axes):
        others = [
            (other, float(sweep.coordinates[other][index]))
            for other, index in zip(sweep.axes, middle, strict=True)
            if other != axis
        ]
        cut: tuple[int | slice, ...] = (*middle[:k], slice(None), *middle[k + 1 :])
        fixed = f"at {position_text(others)}" if others else ""
        lines.append(LineThrough(axis, axis_unit(axis).of(sweep.coordinates[axis]), cut, fixed))
    return lines


def _hatch(axes: Axes, x: Array, missing: NDArray[np.bool_]) -> None:
    """Hatch each stretch of ``missing`` postures, out to half way to its neighbours."""
    edges = np.concatenate([[x[0]], (x[:-1] + x[1:]) / 2.0, [x[-1]]])
    changes = np.flatnonzero(np.diff(np.concatenate([[0], missing.astype(np.int8), [0]])))
    for start, stop in zip(changes[::2], changes[1::2], strict=True):
        patch = unreachable_patch()
        axes.axvspan(
            edges[start],
            edges[stop],
            facecolor=patch.get_facecolor(),
            edgecolor=patch.get_edgecolor(),
            hatch=patch.get_hatch(),
            linewidth=0.0,
            zorder=0,
        )
