"""Quantities with their error bars over the workspace: maps, and lines with their bands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.curves import LineThrough, draw_curves, lines_through, model_curves
from stiffkit.plots.draw import Panel, add_legend, aspect_of, draw_panel, height_of, position_text
from stiffkit.plots.quantities import kind_of
from stiffkit.plots.scale import Scale, add_colour_bar
from stiffkit.plots.sweep import middle_posture, models_of, status_of, sweep_of
from stiffkit.plots.units import DisplayUnit, display_unit
from stiffkit.study import QUANTITIES

Array = NDArray[np.float64]

_SHADE = 0.25
"""Opacity of bands."""


@dataclass(frozen=True, eq=False)
class Banded:
    """A quantity of a study of uncertainty by one model, in display units."""

    values: Array
    sigma: Array
    low: Array
    high: Array
    status: NDArray[np.int8]
    unit: DisplayUnit

    @property
    def relative(self) -> Array:
        """Standard deviation, per cent of the value."""
        return self._per_cent(self.sigma)

    @property
    def half_width(self) -> Array:
        """Half the width of the band, per cent of the value."""
        return self._per_cent(0.5 * (self.high - self.low))

    def _per_cent(self, part: Array) -> Array:
        shares = np.full(self.values.shape, np.nan)
        np.divide(part, self.values, out=shares, where=self.values != 0.0)
        return 100.0 * shares


def banded(dataset: xr.Dataset, name: str, model: str) -> Banded:
    """Return a quantity, by its name in the dataset, of one model."""
    unit = display_unit(kind_of(QUANTITIES[dataset[name].attrs["quantity"]]), dataset[name].values)

    def read(ending: str = "") -> Array:
        return unit.of(dataset[name + ending].sel(model=model).values)

    return Banded(
        read(), read("_sigma"), read("_low"), read("_high"), status_of(dataset, model), unit
    )


def title_of(dataset: xr.Dataset, name: str) -> str:
    """Return a quantity and its load in words."""
    about = dataset[name].attrs
    label = QUANTITIES[about["quantity"]].label
    return f"{label}, load {about['load']}" if "load" in about else label


@style.styled
def uncertainty_map_figure(dataset: xr.Dataset, name: str, model: str) -> Figure:
    """Draw a quantity over the workspace, and beside it its relative standard deviation.

    Of more than two swept coordinates the plane through the middle is shown.
    """
    own, sweep = banded(dataset, name, model), sweep_of(dataset)
    middle = middle_posture(own.status)[2:] if sweep.is_grid else ()
    cut = (slice(None),) * min(2, len(sweep.shape)) + middle
    height = height_of(sweep, style.PAGE * 0.36) + 0.95
    figure = style.new_figure(style.PAGE, height)
    in_space = not sweep.is_grid and len(sweep.axes) > 2
    titles = (f"value, {model} model", "standard deviation, % of the value")
    for number, (values, title) in enumerate(zip((own.values, own.relative), titles, strict=True)):
        colours = style.RATIO_COLOURS if number == 1 else style.MAP_COLOURS
        shown = values[cut]
        panel = Panel.of(sweep, shown, own.status[cut], Scale.of(shown), colours)
        axes = figure.add_subplot(1, 2, number + 1, projection="3d" if in_space else None)
        image = draw_panel(axes, panel, equal=aspect_of(sweep) is not None)
        style.set_title(axes, title)
        unit = "%" if number else own.unit.symbol
        add_colour_bar(figure, image, axes, panel.scale, unit)
    place = position_text(
        (axis, float(sweep.coordinates[axis][i]))
        for axis, i in zip(sweep.axes[2:], middle, strict=False)
    )
    title = title_of(dataset, name)
    style.set_heading(figure, f"{title}, at {place}" if place else title)
    add_legend(figure, [own.status[cut]], is_grid=sweep.is_grid)
    return figure


@style.styled
def band_figure(dataset: xr.Dataset, name: str) -> Figure:
    """Draw a quantity with its band along a line for every swept coordinate, all models.

    Below stands half the width of the band over the value, for bands too narrow to be seen. The
    lines cross in the computed posture nearest to the middle of the workspace. A list of points is
    drawn over the number of the point.
    """
    models, sweep = models_of(dataset), sweep_of(dataset)
    own = {model: banded(dataset, name, model) for model in models}
    lines = lines_through(sweep, middle_posture(own[models[0]].status))
    figure = style.new_figure(style.COLUMN if len(lines) == 1 else style.PAGE, 3.3)
    upper, lower = figure.subplots(
        2, len(lines), sharex="col", sharey="row", squeeze=False, height_ratios=(3, 2)
    )
    cuts = [line.cut for line in lines]
    scale = Scale.of(*(ends[cut] for b in own.values() for ends in (b.low, b.high) for cut in cuts))
    of_half = Scale.of(*(b.half_width[cut] for b in own.values() for cut in cuts))
    handles: list[Artist] = []
    for above, below, line in zip(upper, lower, lines, strict=True):
        gaps = {model: b.status[line.cut] for model, b in own.items()}
        values = model_curves({model: b.values[line.cut] for model, b in own.items()})
        entries = draw_curves(above, line.axis, line.x, values, gaps, scale, from_zero=False)
        halves = model_curves({model: b.half_width[line.cut] for model, b in own.items()})
        draw_curves(below, line.axis, line.x, halves, gaps, of_half)
        for curve, b in zip(values, own.values(), strict=True):
            _shade(above, line, b, str(curve.look["color"]))
        handles = max(handles, entries, key=len)
        above.set_xlabel("")
        if not line.axis:
            below.xaxis.set_major_locator(MaxNLocator(integer=True))
        style.set_title(above, line.fixed)
    unit = own[models[0]].unit
    upper[0].set_ylabel(unit.symbol)
    lower[0].set_ylabel("half the band (%)")
    style.set_heading(figure, title_of(dataset, name))
    share = f"{100.0 * float(dataset.attrs['confidence']):g} % band"
    colour = str(style.LINES[models[0]]["color"]) if len(models) == 1 else style.INK
    add_legend(figure, [], more=[*handles, Patch(color=colour, alpha=_SHADE, lw=0.0, label=share)])
    return figure


def _shade(axes: Axes, line: LineThrough, own: Banded, colour: str) -> None:
    order = np.argsort(line.x, kind="stable")
    low, high = own.low[line.cut][order], own.high[line.cut][order]
    axes.fill_between(line.x[order], low, high, color=colour, alpha=_SHADE, lw=0.0)
