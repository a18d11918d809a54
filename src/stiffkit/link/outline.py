"""What cross-sections look like: for drawing, not for computing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROUND = 1e-3
"""Second moments that differ by less than this share are those of a round section."""


@dataclass(frozen=True)
class Outline:
    """An ellipse or a rectangle around the centroid, perhaps with a hole of the same kind."""

    shape: Literal["ellipse", "rectangle"]
    width: float
    """m, along y."""
    height: float
    """m, along z."""
    inner_width: float = 0.0
    """m, of the hole; 0 for a solid section."""
    inner_height: float = 0.0
    """m, of the hole; 0 for a solid section."""
    is_equivalent: bool = False
    """Whether it only stands for a section whose properties are known and whose shape is not."""

    @property
    def is_hollow(self) -> bool:
        """Whether there is a hole."""
        return self.inner_width > 0.0 and self.inner_height > 0.0

    def edge(self, n: int = 24) -> Array:
        """Return the corners (m, 2) of the outer edge, y and z, anticlockwise seen from +x.

        An ellipse has ``n`` of them, a rectangle its four.
        """
        return _corners(self.shape, self.width, self.height, n)

    def hole(self, n: int = 24) -> Array:
        """Return the corners (m, 2) of the hole, each beside one of the outer edge; none if solid.

        They too run anticlockwise.
        """
        if not self.is_hollow:
            return np.zeros((0, 2))
        return _corners(self.shape, self.inner_width, self.inner_height, n)


def _corners(shape: str, width: float, height: float, n: int) -> Array:
    if shape == "rectangle":
        return np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [width / 2.0, height / 2.0]
    angles = 2.0 * np.pi * np.arange(n) / n
    return np.stack([width / 2.0 * np.cos(angles), height / 2.0 * np.sin(angles)], axis=1)


def equivalent_outline(area: float, Iy: float, Iz: float, torsion: float) -> Outline:
    """Return an outline that has an area (m^2) and second moments (m^4), those about y and z.

    Sections as stiff in torsion as round ones are, and those too compact for a rectangle, become
    ellipses. The hole is the outer edge made smaller: with k the ratio of sizes, the radii of
    gyration and the area determine the outer sizes and k. The most compact section that there can
    be is the solid ellipse; of numbers that no section has, the area is not met.
    """
    is_round = abs(Iy - Iz) < _ROUND * Iy and abs(torsion - Iy - Iz) < _ROUND * torsion
    mean = math.sqrt(Iy * Iz)
    # A = fill b h (1 - k^2), Iy/A = h^2 (1 + k^2)/spread, Iz/A = b^2 (1 + k^2)/spread.
    shape: Literal["ellipse", "rectangle"] = "rectangle"
    fill, spread = 1.0, 12.0
    if is_round or area**2 > (1.0 + _ROUND) * fill * spread * mean:
        shape, fill, spread = "ellipse", math.pi / 4.0, 16.0
    compactness = min(area**2 / (fill * spread * mean), 1.0)
    k2 = (1.0 - compactness) / (1.0 + compactness)
    height, width = (math.sqrt(spread * second / (area * (1.0 + k2))) for second in (Iy, Iz))
    # A hole of a thousandth of the area is rounding in the numbers given.
    k = math.sqrt(k2) if k2 > _ROUND else 0.0
    return Outline(shape, width, height, k * width, k * height, is_equivalent=True)
