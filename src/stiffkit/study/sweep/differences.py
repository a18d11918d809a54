"""How the numbers of a geometry follow its parameters.

A robot file's formulas take a parameter to frames, compliances, masses, poses and loads. These are
smooth and computed to rounding, so central differences across a hundred-thousandth of a parameter
give their derivatives to some nine digits; all that follows from these numbers is differentiated
exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = Mapping[str, Array]

_STEP = 1e-5
"""Over the parameter: what differences leave out is then about as small as their rounding."""

STENCIL = ((1, 0.5),)
"""Central differences: steps, and weights of the difference across each."""


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
