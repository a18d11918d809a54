"""Figures 1 and 2 of Pashkevich 2009: errors of deflections read from noisy fields."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiffkit.plots import style
from stiffkit.robot import DIRECTIONS

Array = NDArray[np.float64]


@style.styled
def error_histograms(errors: Array, standard_deviations: Array) -> Figure:
    """Draw the errors (n, 6), mm and deg, beside normal distributions of the noise alone.

    ``standard_deviations`` (6,) are those of the noise, mm and deg.
    """
    figure = style.new_figure(style.PAGE, 3.4)
    panels = figure.subplots(2, 3)
    for k, axes in enumerate(panels.ravel()):
        unit, factor = ("nm", 1e6) if k < 3 else ("µdeg", 1e6)
        values, sigma = factor * errors[:, k], factor * standard_deviations[k]
        axes.hist(values, bins=50, density=True, color="#0072b2")
        x = np.linspace(values.min(), values.max(), 200)
        density = np.exp(-0.5 * ((x - values.mean()) / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
        axes.plot(x, density, color="#d55e00", linewidth=1.0)
        axes.set_xlabel(f"error of {DIRECTIONS[k]} ({unit})")
        axes.set_yticks([])
    heading = (
        "Errors of simulated deflections: how often (bars), and eq. 20 about their mean (line)"
    )
    style.set_heading(figure, heading)
    return figure


@style.styled
def error_by_amplitude(
    amplitudes: Array, total: Array, linearisation: Array, noise: float
) -> Figure:
    """Draw the error of a rotation over its amplitude, all in deg."""
    figure = style.new_figure(style.COLUMN, 2.6)
    axes = figure.subplots()
    axes.loglog(amplitudes, total, color="#222222", label="both")
    axes.loglog(amplitudes, linearisation, color="#d55e00", linestyle="--", label="linearisation")
    axes.axhline(noise, color="#0072b2", linestyle=":", label="noise")
    axes.set_xlabel("rotation (deg)")
    axes.set_ylabel("error of the rotation (deg)")
    axes.grid(visible=True)
    axes.legend()
    style.set_heading(figure, "Error of a rotation by LIN")
    return figure
