"""How a curve goes, in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from stiffkit.spatial.rotation import Array

Shape = Literal["constant", "falls", "rises", "falls, then rises", "rises, then falls", "varies"]

_CONSTANT = 1e-3
"""Change over the whole curve, relative to its size, that is none."""
_ROUNDING = 1e-9
"""Change from one point to the next, relative to the largest value, that is none."""


@dataclass(frozen=True, eq=False)
class Trend:
    """A curve over one quantity."""

    x: Array
    """(n,), ascending."""
    y: Array
    """(n,), not negative."""
    size: float
    """What is small beside this is nil: the size of the curves that this one is shown with."""

    @property
    def shape(self) -> Shape:
        """Whether it falls, rises, or turns once."""
        if np.ptp(self.y) <= _CONSTANT * max(float(self.y.max()), _CONSTANT * self.size):
            return "constant"
        steps = np.diff(self.y)
        signs = np.sign(steps[np.abs(steps) > _ROUNDING * self.y.max()])
        turns = int(np.count_nonzero(np.diff(signs)))
        if turns == 0:
            return "falls" if signs[0] < 0.0 else "rises"
        if turns == 1:
            return "falls, then rises" if signs[0] < 0.0 else "rises, then falls"
        return "varies"

    def words(self, factor: float) -> str:
        """Return the curve in words, its values multiplied by ``factor``."""
        first, last = (_number(factor * float(value)) for value in (self.y[0], self.y[-1]))
        match self.shape:
            case "constant":
                return "nil" if self.y.max() <= _CONSTANT**2 * self.size else f"constant, {first}"
            case "falls" | "rises":
                return f"{self.shape} from {first} to {last}"
            case "varies":
                low, high = (
                    _number(factor * float(value)) for value in (self.y.min(), self.y.max())
                )
                return f"varies between {low} and {high}"
            case _:
                one, other = self.shape.split(", then ")
                turn = int(np.argmin(self.y) if one == "falls" else np.argmax(self.y))
                return (
                    f"{one} from {first} to {_number(factor * float(self.y[turn]))} at"
                    f" {self.x[turn]:.3g}, then {other} to {last}"
                )


def _number(value: float) -> str:
    return f"{value:.0f}" if value >= 1000.0 else f"{value:.3g}"
