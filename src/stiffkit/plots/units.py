"""Units for the reader's eye: mm, µm, N/µm and their kind, chosen by the size of the numbers.

Everything that is computed stays in SI; figures and reports divide by `DisplayUnit.size` last.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Kind(Enum):
    """What a number is; it decides which units a reader expects."""

    POSITION = "position"
    ANGLE = "angle"
    DEFLECTION = "deflection"
    ROTATION = "rotation"
    STIFFNESS = "stiffness"
    ROTATIONAL_STIFFNESS = "rotational stiffness"
    FREQUENCY = "frequency"
    RATIO = "ratio"


@dataclass(frozen=True)
class DisplayUnit:
    """A unit to print numbers in."""

    symbol: str
    size: float
    """SI value of one unit: 1e-6 for µm."""

    def of(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return SI ``values`` as multiples of this unit."""
        return np.asarray(values, dtype=np.float64) / self.size

    def text(self, value: float) -> str:
        """Return one SI ``value`` with its unit, such as "12.5 mm" or "30°"."""
        # A billionth of a unit is how a zero looks after a few additions.
        number = format_value(float(np.round(value / self.size, 9)))
        return number + ("" if self.symbol in ("", "°") else " ") + self.symbol

    def label(self, text: str) -> str:
        """Return ``text`` with the unit in brackets, or bare if the unit is 1."""
        return f"{text} ({self.symbol})" if self.symbol else text


_LADDERS: dict[Kind, tuple[DisplayUnit, ...]] = {
    Kind.POSITION: (DisplayUnit("mm", 1e-3),),
    Kind.ANGLE: (DisplayUnit("°", np.pi / 180.0),),
    Kind.DEFLECTION: (
        DisplayUnit("nm", 1e-9),
        DisplayUnit("µm", 1e-6),
        DisplayUnit("mm", 1e-3),
        DisplayUnit("m", 1.0),
    ),
    Kind.ROTATION: (
        DisplayUnit("nrad", 1e-9),
        DisplayUnit("µrad", 1e-6),
        DisplayUnit("mrad", 1e-3),
        DisplayUnit("rad", 1.0),
    ),
    Kind.STIFFNESS: (
        DisplayUnit("N/m", 1.0),
        DisplayUnit("N/mm", 1e3),
        DisplayUnit("N/µm", 1e6),
        DisplayUnit("kN/µm", 1e9),
    ),
    Kind.ROTATIONAL_STIFFNESS: (
        DisplayUnit("N m/rad", 1.0),
        DisplayUnit("kN m/rad", 1e3),
        DisplayUnit("MN m/rad", 1e6),
        DisplayUnit("GN m/rad", 1e9),
    ),
    Kind.FREQUENCY: (DisplayUnit("Hz", 1.0), DisplayUnit("kHz", 1e3)),
    Kind.RATIO: (DisplayUnit("", 1.0),),
}
"""For each kind its units, smallest first."""


def display_unit(kind: Kind, values: ArrayLike) -> DisplayUnit:
    """Return the unit in which the median of ``values`` reads best.

    Args:
        kind: what the numbers are.
        values: any shape, SI; zeros, NaN and infinities do not count.

    Returns:
        The largest unit that the median magnitude reaches, or the smallest there is.
    """
    ladder = _LADDERS[kind]
    sizes = np.abs(np.asarray(values, dtype=np.float64))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0.0)]
    if sizes.size == 0:
        return next((unit for unit in ladder if unit.symbol in ("µm", "µrad")), ladder[0])
    median = float(np.median(sizes))
    # A hair of tolerance keeps 1 mm, stored as 0.000999999..., from reading 1000 µm.
    fitting = [unit for unit in ladder if unit.size <= median * (1.0 + 1e-9)]
    return fitting[-1] if fitting else ladder[0]


def format_value(value: float) -> str:
    """Return ``value`` with four significant digits, plainly: "12.34", "∞", "–" for NaN."""
    if np.isnan(value):
        return "–"
    if np.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    if not 1e-3 <= abs(value) < 1e6:
        return f"{value:.3e}".replace("-", "−")
    digits = max(0, 3 - int(np.floor(np.log10(abs(value)))))
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", "−")
