"""Curves in panels side by side: several quantities over one, at a few places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.plots.draw import add_legend
from stiffkit.plots.scale import Scale, set_log_ticks

Array = NDArray[np.float64]

LOOKS: tuple[Mapping[str, Any], ...] = (
    {"color": "#222222", "linestyle": "-"},
    {"color": "#d55e00", "linestyle": (0, (1.2, 1.2))},
    {"color": "#0072b2", "linestyle": (0, (5, 2))},
)
"""Full, dotted and dashed, as papers in black and white tell curves apart."""

_MARK: Mapping[str, Any] = {"color": "#5a5a5a", "linewidth": 0.9, "zorder": 1}

_MARGIN = 1.15
"""Over and under the curves on a logarithmic axis."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Curves over one quantity, in display units."""

    x: Array
    """(n,)."""
    curves: Mapping[str, Array]
    """(n,) or (n, p) for p panels, by what the legend says; at most as many as `LOOKS`."""
    x_label: str
    y_label: str
    panels: Sequence[str] = ("",)
    """Titles."""
    mark: float | None = None
    """A value of x with a thin line through it."""
    mark_label: str = ""
    is_log: bool = False
    """Whether y is logarithmic; otherwise it begins at zero."""


@style.styled
def panel_figure(lines: Lines, heading: str) -> Figure:
    """Draw every curve in each panel, all panels with the same axes."""
    wide = len(lines.panels) > 1
    figure = style.new_figure(style.PAGE if wide else style.COLUMN, 2.4)
    panels = figure.subplots(1, len(lines.panels), sharey=True, squeeze=False)[0]
    shown = {name: values.reshape(lines.x.size, -1) for name, values in lines.curves.items()}
    for k, axes in enumerate(panels):
        for look, values in zip(LOOKS, shown.values(), strict=False):
            axes.plot(lines.x, values[:, k], **look)
        if lines.mark is not None:
            axes.axvline(lines.mark, **_MARK)
        style.set_title(axes, lines.panels[k])
        axes.set_xlim(lines.x[0], lines.x[-1])
        axes.set_xlabel(lines.x_label)
        axes.grid(visible=True)
        axes.set_axisbelow(True)
    panels[0].set_ylabel(lines.y_label)
    _set_limits(panels[0], np.concatenate([v.ravel() for v in shown.values()]), lines.is_log)
    handles = [Line2D([], [], label=name, **look) for look, name in zip(LOOKS, shown, strict=False)]
    if lines.mark is not None:
        handles.append(Line2D([], [], label=lines.mark_label, **_MARK))
    style.set_heading(figure, heading)
    if len(handles) > 1:
        add_legend(figure, [], more=handles, columns=4 if wide else 3)
    return figure


def _set_limits(axes: Axes, values: Array, is_log: bool) -> None:
    if not is_log:
        axes.set_ylim(0.0, 1.05 * float(values.max()))
        return
    axes.set_yscale("log")
    limits = float(values.min()) / _MARGIN, float(values.max()) * _MARGIN
    set_log_ticks(axes.yaxis, Scale(*limits, is_log=True))
    axes.set_ylim(*limits)
