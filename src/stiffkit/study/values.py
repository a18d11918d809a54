"""The arrays of a map, filled block by block and by several threads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction, limited_threads, over_blocks
from stiffkit.kinematics import Postures
from stiffkit.stiffness import DEFLECTIONS, STIFFNESSES, Stiffness, entry, readings

Array = NDArray[np.float64]

_BLOCK = 1 << 12
"""Postures at a time: what is computed of them then stays in the cache."""
_SLOW_BLOCK = 1 << 8
"""Postures at a time where each takes a millisecond, so that progress shows."""


@dataclass(frozen=True, eq=False)
class MapValues:
    """What a map holds of N postures; NaN where the status is not OK."""

    status: NDArray[np.int8]
    """(n_models, N)."""
    compliance: Array
    """(n_models, 6, 6, N)."""
    deflection: Array
    """(n_models, n_loads, 6, N)."""
    stiffnesses: dict[str, Array]
    """(n_models, N) for each of `stiffkit.stiffness.STIFFNESSES`."""
    deflections: dict[str, Array]
    """(n_models, n_loads, N) for each of `stiffkit.stiffness.DEFLECTIONS`."""

    @staticmethod
    def empty(n_models: int, n_loads: int, n: int) -> MapValues:
        """Return arrays without values."""
        return MapValues(
            np.zeros((n_models, n), dtype=np.int8),
            np.empty((n_models, 6, 6, n)),
            np.empty((n_models, n_loads, 6, n)),
            {name: np.empty((n_models, n)) for name in STIFFNESSES},
            {name: np.empty((n_models, n_loads, n)) for name in DEFLECTIONS},
        )

    def fill(
        self,
        m: int,
        stiffness: Stiffness,
        postures: Postures,
        read: Reader,
        done: Callable[[int], object],
    ) -> None:
        """Compute everything of the model ``m``; ``done`` is told how many postures are."""
        n = len(postures)
        compliances = stiffness.ready_for(n)

        def work(block: slice) -> None:
            found = compliances(postures.part(block))
            self.status[m, block] = found.status
            for i in range(6):
                for j in range(6):
                    self.compliance[m, i, j, block] = entry(found.lower, i, j)
            self._put_readings(m, block, read(found.lower))

        slow = stiffness.method == "assembly"
        with limited_threads(1 if slow else None):
            over_blocks(n, _SLOW_BLOCK if slow else _BLOCK, work, done)

    def _put_readings(self, m: int, block: slice, values: Array) -> None:
        rows = iter(values)
        for name in STIFFNESSES:
            self.stiffnesses[name][m, block] = next(rows)
        for load in range(self.deflection.shape[1]):
            for i in range(6):
                self.deflection[m, load, i, block] = next(rows)
            for name in DEFLECTIONS:
                self.deflections[name][m, load, block] = next(rows)


Reader = Callable[[Array], Array]
"""The kernel `stiffkit.stiffness.readings` of the load cases of a map."""


def reader(wrenches: Array, n: int, backend: Backend | None) -> Reader:
    """Return what reads ``n`` compliances (21, n) under load cases (n_loads, 6)."""
    return BatchFunction(readings(wrenches), backend).ready_for(n)
