"""The unit cube that designs are looked for in, and the parameters that its points stand for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.spec import Variable

Array = NDArray[np.float64]


class Space:
    """A coordinate between 0 and 1 for each variable.

    A continuous one goes from the lowest to the highest value; any other divides the way among its
    values in equal parts.
    """

    def __init__(self, variables: tuple[Variable, ...]) -> None:
        """Take what is free."""
        self.variables = variables
        self.counts = np.array([v.count for v in variables])
        """(k,), numbers of values; 0 where continuous."""
        self.continuous = np.flatnonzero(self.counts == 0)
        """Numbers of the continuous variables."""
        starts = np.cumsum([0, *(len(v.parameters) for v in variables)])
        self.rows = starts[:-1]
        """(k,), the first parameter of each variable."""
        self.n_parameters = int(starts[-1])

    @property
    def size(self) -> int:
        """k, number of variables."""
        return len(self.variables)

    @property
    def span(self) -> Array:
        """(c,), SI: how far the parameters of the continuous variables range."""
        ends = [self.variables[i].values[0] for i in self.continuous]
        return np.array([high - low for low, high in ends])

    def parameters(self, u: Array) -> Array:
        """Return the parameters (p, n), SI, of points (k, n)."""
        found = np.empty((self.n_parameters, u.shape[1]))
        for variable, row, own in zip(self.variables, self.rows, u, strict=True):
            if variable.kind == "continuous":
                low, high = variable.values[0]
                found[row] = low + own * (high - low)
                continue
            values = np.array(variable.values)
            found[row : row + len(values)] = values[:, self._number(variable, own)]
        return found

    def points(self, parameters: Array) -> Array:
        """Return the points (k, n) nearest to parameters (p, n)."""
        found = np.empty((self.size, parameters.shape[1]))
        for i, (variable, row) in enumerate(zip(self.variables, self.rows, strict=True)):
            if variable.kind == "continuous":
                low, high = variable.values[0]
                found[i] = np.clip((parameters[row] - low) / (high - low), 0.0, 1.0)
                continue
            values = np.array(variable.values)
            span = np.maximum(np.ptp(values, axis=1), 1e-300)[:, None, None]
            own = parameters[row : row + len(values), :, None]
            apart = np.sum(((values[:, None] - own) / span) ** 2, axis=0)
            found[i] = (np.argmin(apart, axis=1) + 0.5) / variable.count
        return found

    def snapped(self, u: Array) -> Array:
        """Return points (k, n) in the middle of the parts that stand for the same values."""
        found = u.copy()
        for i, variable in enumerate(self.variables):
            if variable.count:
                found[i] = (self._number(variable, u[i]) + 0.5) / variable.count
        return found

    @staticmethod
    def _number(variable: Variable, u: Array) -> NDArray[np.intp]:
        return np.clip((u * variable.count).astype(np.intp), 0, variable.count - 1)

    def grid(self, steps: int) -> Array:
        """Return every combination (k, n), the last variable fastest."""
        axes = [
            (np.arange(count) + 0.5) / count if count else np.linspace(0.0, 1.0, steps)
            for count in self.counts.tolist()
        ]
        return np.array([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")])

    def sample(self, count: int, seed: int) -> Array:
        """Return points (k, count) of a latin hypercube."""
        from scipy.stats.qmc import LatinHypercube  # slow to import

        return self.snapped(LatinHypercube(self.size, rng=seed).random(count).T)
