"""Drawing one coloured panel: a grid of postures or a list of points, gaps explained."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.scale import Scale
from stiffkit.plots.sweep import OUTSIDE, SINGULAR, UNCONTROLLED, UNREACHABLE, Sweep, axis_unit
from stiffkit.plots.units import format_value

Array = NDArray[np.float64]

CONTOUR_POINTS = 200
"""Contour lines are drawn through at most this many postures along an axis."""

_GAPS: dict[int, tuple[str, str]] = {
    UNREACHABLE: (style.UNREACHABLE_HATCH, "out of reach"),
    SINGULAR: (style.SINGULAR, "singular"),
    UNCONTROLLED: (style.UNCONTROLLED, "uncontrolled"),
}
"""Colour and name of postures without an answer; what is outside the workspace stays white."""

_HATCHED: dict[int, dict[str, Any]] = {
    SINGULAR: {"facecolor": style.SINGULAR, "edgecolor": "white", "hatch": "xxxx"},
    UNCONTROLLED: {"facecolor": style.UNCONTROLLED, "edgecolor": "white", "hatch": "...."},
}
"""Cells that could be taken for colours of the scale where all are grey."""

# Cells are drawn as an image, above the hatching and below the contour lines.
_CELLS_ZORDER = 0.5

AXIS_NAMES = {
    "x": "x",
    "y": "y",
    "z": "z",
    "rx": "rotation about x",
    "ry": "rotation about y",
    "rz": "rotation about z",
}


@dataclass(frozen=True, eq=False)
class Panel:
    """What one pair of axes shows of a map, in display units."""

    axes: tuple[str, ...]
    """One to three tool coordinates."""
    coordinates: tuple[Array, ...]
    """Their values; for a grid one array (n_axis,) each, for points (n,) each."""
    values: Array
    """(n_1, n_2) for a grid, (n,) for points; NaN where there is no answer."""
    status: NDArray[np.int8]
    is_grid: bool
    scale: Scale
    colours: str = style.MAP_COLOURS
    levels: Array | None = None
    """Contour lines; round values of this panel's own by default."""

    @staticmethod
    def of(
        sweep: Sweep,
        values: Array,
        status: NDArray[np.int8],
        scale: Scale,
        colours: str = style.MAP_COLOURS,
    ) -> Panel:
        """Return a panel over the first two swept coordinates of a grid, up to three of points.

        ``values`` and ``status`` are those of the cut that is shown, values in display units.
        """
        axes = sweep.axes[:2] if sweep.is_grid else sweep.axes[:3]
        coordinates = tuple(axis_unit(axis).of(sweep.coordinates[axis]) for axis in axes)
        return Panel(axes, coordinates, values, status, sweep.is_grid, scale, colours)


def axis_label(axis: str) -> str:
    """Return the label of a tool coordinate, such as "x (mm)"."""
    return axis_unit(axis).label(AXIS_NAMES[axis])


def position_text(positions: Iterable[tuple[str, float]]) -> str:
    """Return fixed tool coordinates (SI) in words, such as "y = 375 mm"."""
    return ", ".join(f"{axis} = {axis_unit(axis).text(value)}" for axis, value in positions)


def height_of(sweep: Sweep, width: float) -> float:
    """Return the height for axes up to ``width`` inches wide in which x and y have one scale."""
    return width * min(aspect_of(sweep) or 0.75, 1.2)


def aspect_of(sweep: Sweep) -> float | None:
    """Return height over width of the plane of the first two axes; None if they have no one scale.

    Lengths share a scale unless the plane is so slim that it could not be read.
    """
    if len(sweep.axes) < 2 or any(axis.startswith("r") for axis in sweep.axes[:2]):
        return None
    wide, high = (float(np.ptp(sweep.coordinates[axis])) for axis in sweep.axes[:2])
    if min(wide, high) <= 0.0 or not 0.25 <= high / wide <= 2.5:
        return None
    return high / wide


def draw_panel(axes: Axes, panel: Panel, *, equal: bool) -> ScalarMappable:
    """Draw ``panel`` on ``axes`` and return what a colour bar needs."""
    if panel.is_grid:
        image = _draw_grid(axes, panel)
    elif len(panel.axes) == 3:
        image = _draw_points_in_space(axes, panel)
    else:
        image = _draw_points(axes, panel)
    if equal and len(panel.axes) == 2:
        axes.set_aspect("equal")
    _say_if_there_is_nothing(axes, panel.values)
    return image


def add_legend(
    figure: Figure,
    statuses: Iterable[NDArray[np.int8]],
    *,
    is_grid: bool = True,
    more: Sequence[Artist] = (),
    columns: int = 3,
) -> None:
    """Explain below the figure what has no colour, with ``more`` handles before it."""
    seen = {int(value) for status in statuses for value in np.unique(status)}
    gaps = (_gap_handle(value, is_grid=is_grid) for value in _GAPS if value in seen)
    handles = [*more, *gaps]
    if handles:
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=min(len(handles), columns),
            handlelength=1.6,
            handletextpad=0.5,
            columnspacing=1.2,
            borderaxespad=0.2,
        )


def unreachable_patch() -> Patch:
    """Return the legend entry of what is out of reach."""
    return Patch(
        facecolor=style.UNREACHABLE_FACE,
        edgecolor=style.UNREACHABLE_HATCH,
        hatch="/////",
        linewidth=0.0,
        label="out of reach",
    )


def gap_names(status: NDArray[np.int8]) -> list[str]:
    """Return in words why postures of ``status`` have no answer."""
    return [name for value, (_, name) in _GAPS.items() if (status == value).any()]


def _gap_handle(value: int, *, is_grid: bool) -> Artist:
    colour, name = _GAPS[value]
    if not is_grid:
        return Line2D([], [], linestyle="", marker="x", color=colour, label=name)
    if value == UNREACHABLE:
        return unreachable_patch()
    return Patch(label=name, linewidth=0.0, **_HATCHED[value])


def _known(values: Array) -> Array:
    """Return values with what is infinite made NaN, which is not drawn."""
    return np.where(np.isfinite(values), values, np.nan)


def _draw_grid(axes: Axes, panel: Panel) -> ScalarMappable:
    x, y = panel.coordinates
    edges_x, edges_y = _cell_edges(x), _cell_edges(y)
    if (panel.status == UNREACHABLE).any():
        axes.axvspan(
            edges_x[0],
            edges_x[-1],
            facecolor=style.UNREACHABLE_FACE,
            edgecolor=style.UNREACHABLE_HATCH,
            hatch="/////",
            linewidth=0.0,
            zorder=0,
        )
    _draw_other_gaps(axes, panel, edges_x, edges_y)
    # Zero has no logarithm and a rigid model no number: both go to the end of the scale.
    values = _known(np.clip(panel.values, panel.scale.low, panel.scale.high))
    image = axes.pcolorfast(
        edges_x,
        edges_y,
        values.T,
        norm=panel.scale.norm,
        cmap=panel.colours,
        zorder=_CELLS_ZORDER,
    )
    axes.set_xlim(edges_x[0], edges_x[-1])
    axes.set_ylim(edges_y[0], edges_y[-1])
    axes.set_xlabel(axis_label(panel.axes[0]))
    axes.set_ylabel(axis_label(panel.axes[1]))
    _draw_contours(axes, panel)
    return image


def _draw_other_gaps(axes: Axes, panel: Panel, edges_x: Array, edges_y: Array) -> None:
    """Paint singular, uncontrolled and outside postures; what is out of reach stays hatched."""
    for value, look in {**_HATCHED, OUTSIDE: {"facecolor": "white"}}.items():
        i, j = np.nonzero(panel.status == value)
        if i.size:
            x, y = (edges_x[i], edges_x[i + 1]), (edges_y[j], edges_y[j + 1])
            corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
            cells = np.moveaxis(np.array(corners), (0, 1), (1, 2))
            path = Path.make_compound_path_from_polys(cells)
            axes.add_patch(PathPatch(path, linewidth=0.0, zorder=_CELLS_ZORDER, **look))


def _draw_contours(axes: Axes, panel: Panel) -> None:
    if min(panel.values.shape) < 3 or not np.isfinite(panel.values).any():
        return
    levels = panel.scale.levels(panel.values) if panel.levels is None else panel.levels
    low, high = np.nanmin(panel.values), np.nanmax(panel.values)
    levels = levels[(levels > low) & (levels < high)]
    if levels.size == 0:
        return
    steps = tuple(max(1, -(-n // CONTOUR_POINTS)) for n in panel.values.shape)
    x, y = (c[::step] for c, step in zip(panel.coordinates, steps, strict=True))
    values = _known(panel.values[:: steps[0], :: steps[1]])
    lines = axes.contour(x, y, values.T, levels=levels, colors=style.INK, linewidths=0.5)
    labels = axes.clabel(lines, fontsize=5.5, fmt=format_value, inline_spacing=2)
    for label in labels:
        label.set_path_effects([withStroke(linewidth=1.4, foreground="white")])


def _draw_points(axes: Axes, panel: Panel) -> ScalarMappable:
    x, y = panel.coordinates
    computed = np.isfinite(panel.values)
    for value, (colour, _) in _GAPS.items():
        here = panel.status == value
        axes.scatter(x[here], y[here], s=10, marker="x", color=colour, lw=0.8)
    image = axes.scatter(
        x[computed],
        y[computed],
        c=panel.values[computed],
        norm=panel.scale.norm,
        cmap=panel.colours,
        s=14,
        lw=0.3,
        edgecolors=style.INK,
    )
    axes.set_xlabel(axis_label(panel.axes[0]))
    axes.set_ylabel(axis_label(panel.axes[1]))
    axes.margins(0.06)
    return image


def _draw_points_in_space(axes: Axes, panel: Panel) -> ScalarMappable:
    computed = np.isfinite(panel.values)
    image = axes.scatter(
        *(c[computed] for c in panel.coordinates),  # type: ignore[misc]
        c=panel.values[computed],
        norm=panel.scale.norm,
        cmap=panel.colours,
        s=10,
        depthshade=False,
    )
    for name, axis in zip("xyz", panel.axes, strict=True):
        getattr(axes, f"set_{name}label")(axis_label(axis), labelpad=-4.0)
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(4))
    axes.tick_params(pad=-3.0)
    return image


def _say_if_there_is_nothing(axes: Axes, values: Array) -> None:
    known = values[~np.isnan(values)]
    if known.size == 0:
        text = "no posture has an answer"
    elif np.isinf(known).all():
        text = "rigid in this model"
    elif (known == 0.0).all():
        text = "zero in this model"
    else:
        return
    axes.annotate(
        text,
        (0.5, 0.5),
        xycoords="axes fraction",
        ha="center",
        va="center",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 3.0},
    )


def _cell_edges(centres: Array) -> Array:
    """Return the n + 1 edges of cells around n ``centres``."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    halves = np.diff(centres) / 2.0
    inner = centres[:-1] + halves
    return np.concatenate([[centres[0] - halves[0]], inner, [centres[-1] + halves[-1]]])
