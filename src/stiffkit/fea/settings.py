"""How the displacement of a part is discretised, and how that is solved."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stiffkit.fea.memory import Fill
from stiffkit.fea.orders import Orders


@dataclass(frozen=True)
class SolveSettings:
    """How a discretisation is solved."""

    order: int = 3
    """Polynomial order of the displacement."""
    orders: Orders | None = field(default=None, compare=False, repr=False)
    """Orders (e,) of the elements, on curved ones, where they differ; ``order`` is the highest."""
    threads: int | None = None
    """As many as cores are idle if None: on busy cores more threads are slower than one."""
    solver: str = "auto"
    """direct, iterative, or auto: direct where it fits into memory."""
    memory: float | None = None
    """bytes that the solve may take; most of what is free if None."""
    known: Fill | None = field(default=None, compare=False, repr=False)
    """What a factor of such a mesh was seen to take, if one was."""

    def orders_of(self, n_elements: int) -> Orders:
        """Return the order of each of ``n_elements``."""
        return np.full(n_elements, self.order) if self.orders is None else self.orders
