"""Figure 3 of Pashkevich 2009: what a rigid motion leaves of the field of a loaded face."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiffkit.plots import style

Array = NDArray[np.float64]

KEPT, DROPPED = "#0072b2", "#d55e00"


@style.styled
def residual_histograms(
    residuals: Array, dropped: NDArray[np.bool_], names: Sequence[str], heading: str
) -> Figure:
    """Draw histograms of the residuals (m, n, 3), m, of m = 6 named load cases.

    All three components of the n nodes count; those of nodes that were ``dropped`` (m, n) as
    outliers are drawn in another colour.
    """
    figure = style.new_figure(style.PAGE, 3.6)
    panels = figure.subplots(2, 3)
    for name, axes, values, out in zip(names, panels.ravel(), residuals, dropped, strict=True):
        unit, factor = _unit(float(np.abs(values).max()))
        parts = [factor * values[~out].ravel(), factor * values[out].ravel()]
        axes.hist(
            parts,
            bins=31,
            stacked=True,
            color=[KEPT, DROPPED],
            label=["kept", "dropped as outliers"],
        )
        style.set_title(axes, name)
        axes.set_xlabel(f"residual ({unit})")
    for axes in panels[:, 0]:
        axes.set_ylabel("components of nodes")
    style.set_heading(figure, heading)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=2, borderaxespad=0.2)
    return figure


def _unit(largest: float) -> tuple[str, float]:
    """Return the unit of length that shows a value in m without zeros, and its factor."""
    for unit, factor in (("µm", 1e6), ("nm", 1e9)):
        if largest * factor >= 1.0:
            return unit, factor
    return "pm", 1e12
