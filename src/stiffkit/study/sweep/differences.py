"""How the numbers of a geometry follow its parameters.

A robot file's formulas take a parameter to frames, compliances, masses, poses and loads. These are
smooth and computed to rounding, so differences of the sixth order give their derivatives to some
twelve digits; everything that follows from these numbers is differentiated exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = Mapping[str, Array]

_STEP = 1e-3
"""Over the parameter: errors of the differences are then about 1e-13 of what is differentiated."""

STENCIL = ((1, 3.0 / 4.0), (2, -3.0 / 20.0), (3, 1.0 / 60.0))
"""Central differences of sixth order: steps, and weights of the difference across each."""


def steps_of(values: Array, span: Array) -> Array:
    """Return the steps (k,) for parameters with values (k,) that range over ``span`` (k,)."""
    return np.asarray(_STEP * np.maximum(np.abs(values), 0.1 * span))


def derivatives(numbers: Callable[[Array], Numbers], values: Array, steps: Array) -> Numbers:
    """Return the derivatives (k, ...) of arrays (...) by each of the values (k,)."""
    here = numbers(values)
    columns: dict[str, list[Array]] = {name: [] for name in here}
    for i, step in enumerate(steps):
        total: dict[str, Array] = {}
        for count, weight in STENCIL:
            moved = np.zeros_like(values)
            moved[i] = count * step
            ahead, behind = numbers(values + moved), numbers(values - moved)
            for name in ahead:
                change = weight / step * (np.asarray(ahead[name]) - np.asarray(behind[name]))
                total[name] = total.get(name, 0.0) + change
        for name, column in total.items():
            columns[name].append(column)
    return {
        name: np.array(column).reshape(len(steps), *np.shape(here[name]))
        for name, column in columns.items()
    }
