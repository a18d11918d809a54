"""Colour scales: linear or logarithmic, with ticks at round numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator
from numpy.typing import NDArray

from stiffkit.plots.units import format_value

Array = NDArray[np.float64]

LOGARITHMIC_FROM = 6.0
"""Largest over smallest value from which a linear scale would hide the small ones."""

OUTLIERS = 5.0
"""Percent of the values at each end that may lie beyond the scale, ..."""
FAR = 3.0
"""... where they lie further out than this factor."""


@dataclass(frozen=True, eq=False)
class Scale:
    """Limits of the values in a figure, in display units."""

    low: float
    high: float
    is_log: bool

    beyond: Literal["neither", "min", "max", "both"] = "neither"
    """At which ends values lie beyond the limits."""

    @property
    def norm(self) -> Normalize:
        """The same as a Matplotlib norm; what is constant gets a range around it."""
        if self.is_constant and self.high > 0.0:
            return Normalize(0.9 * self.low, 1.1 * self.high)
        return (LogNorm if self.is_log else Normalize)(self.low, self.high)

    @property
    def is_constant(self) -> bool:
        """Whether all values are alike to rounding, so that contour lines would show noise."""
        return self.high - self.low <= 1e-6 * abs(self.high)

    def levels(self, values: Array, count: int = 6) -> Array:
        """Return about ``count`` round levels inside the range of ``values``."""
        inside = Scale.of(values, is_log=self.is_log)
        if inside.is_constant:
            return np.empty(0)
        if inside.is_log and inside.high / inside.low > LOGARITHMIC_FROM:
            ticks = _one_two_five(inside.low, inside.high)
            ticks = ticks[:: max(1, int(np.ceil(len(ticks) / (count + 2))))]
        else:
            ticks = np.asarray(MaxNLocator(count).tick_values(inside.low, inside.high))
        return ticks[(ticks > inside.low) & (ticks < inside.high)]

    @classmethod
    def of(cls, *values: Array, is_log: bool | None = None) -> Scale:
        """Return the scale of all ``values``, logarithmic where their spread asks for it."""
        joined = np.concatenate([np.ravel(v) for v in values]) if values else np.empty(0)
        finite = joined[np.isfinite(joined)]
        positive = finite[finite > 0.0]
        if finite.size == 0:
            return cls(0.0, 1.0, is_log=False)
        low, high = _without_outliers(positive) if positive.size else (0.0, 0.0)
        if is_log is None:
            is_log = positive.size > 0 and high > LOGARITHMIC_FROM * low
        if is_log and positive.size > 0:
            return cls(low, high, True, _beyond(positive, low, high))
        low, high = float(finite.min()), float(min(finite.max(), high or np.inf))
        return cls(low, high, False, _beyond(finite, low, high))


def _without_outliers(positive: Array) -> tuple[float, float]:
    """Return limits that a few postures next to a singularity do not stretch over decades."""
    low = float(np.percentile(positive, OUTLIERS, method="lower"))
    high = float(np.percentile(positive, 100.0 - OUTLIERS, method="higher"))
    return max(float(positive.min()), low / FAR), min(float(positive.max()), high * FAR)


def _beyond(values: Array, low: float, high: float) -> Literal["neither", "min", "max", "both"]:
    under, over = bool(values.min() < low), bool(values.max() > high)
    if under and over:
        return "both"
    return "min" if under else "max" if over else "neither"


def add_colour_bar(
    figure: Figure, image: ScalarMappable, axes: Axes | list[Axes], scale: Scale, unit: str
) -> None:
    """Draw a colour bar beside ``axes`` with its unit beside it."""
    in_space = any(getattr(a, "name", "") == "3d" for a in np.atleast_1d(np.asarray(axes)))
    bar = figure.colorbar(
        image,
        ax=axes,
        fraction=0.06,
        pad=0.14 if in_space else 0.02,
        aspect=22,
        extend=scale.beyond,
        extendfrac=0.03,
    )
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(width=0.4, length=2.0)
    bar.ax.yaxis.set_minor_locator(NullLocator())
    if scale.is_log:
        set_log_ticks(bar.ax.yaxis, scale)
    bar.set_label(unit)


def set_log_ticks(axis: Axis, scale: Scale) -> None:
    """Put round ticks, written out plainly, on a logarithmic axis."""
    axis.set_major_locator(FixedLocator(list(_one_two_five(scale.low, scale.high))))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: format_value(value)))


def _one_two_five(low: float, high: float) -> Array:
    """Return 1, 2, 5, 10, ... from ``low`` to ``high``, thinned to powers of ten if many."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    steps = (1.0, 2.0, 5.0) if len(decades) <= 5 else (1.0,)
    ticks = np.array([step * 10.0**decade for decade in decades for step in steps])
    slack = 1.0 + 1e-9
    return ticks[(ticks >= low / slack) & (ticks <= high * slack)]
