"""Rigid frames."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame B placed in a frame A: ``T_A_B``, so that ``p_A = rotation @ p_B + position``.

    ``T_A_B @ T_B_C`` is ``T_A_C``.
    """

    rotation: Array = field(default_factory=lambda: np.eye(3))
    """3x3, columns are the axes of B in A."""
    position: Array = field(default_factory=lambda: np.zeros(3))
    """(3,), origin of B in A, metres."""

    @staticmethod
    def at(x: float, y: float = 0.0, z: float = 0.0) -> Frame:
        """Return a frame shifted by (x, y, z) metres and not turned."""
        return Frame(position=np.array([x, y, z], dtype=float))

    def __matmul__(self, other: Frame) -> Frame:
        """Return ``T_A_C`` of ``T_A_B @ T_B_C``."""
        return Frame(self.rotation @ other.rotation, self.rotation @ other.position + self.position)

    @property
    def inverse(self) -> Frame:
        """``T_B_A``."""
        return Frame(self.rotation.T, -self.rotation.T @ self.position)

    def point(self, p_B: ArrayLike) -> Array:
        """Return a point (3,) of frame B in frame A."""
        return np.asarray(self.rotation @ np.asarray(p_B, dtype=float) + self.position)
