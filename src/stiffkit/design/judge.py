"""How good designs are, and how far from what they must fulfil."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.spec import DesignSpec, Measure
from stiffkit.errors import StiffkitError

Array = NDArray[np.float64]

TOLERANCE = 1e-6
"""Violation, over the bound, that counts as none: what optimisers leave."""

WITHOUT_ANSWER = 10.0
"""Violation of a constraint whose measure has no answer."""

_WORST = 1e30


class Judge:
    """Losses and violations of designs: pure numbers, smaller is better."""

    def __init__(self, spec: DesignSpec, start: Array) -> None:
        """Take the measures (models, measures) of the start, SI.

        Raises StiffkitError where the start has no value that is to be a bound.
        """
        self.spec = spec
        self.n_objectives = len(spec.objectives)
        objectives, constraints = np.split(start, [self.n_objectives], axis=1)
        given = [np.nan if c.bound is None else c.bound for c in spec.constraints]
        self.bounds: Array = np.where(np.isnan(given), constraints, np.array(given))
        """(models, constraints), SI."""
        for model, constraint in np.argwhere(~np.isfinite(self.bounds)):
            name = spec.constraints[constraint].measure.name
            raise StiffkitError(
                f"the start has no '{name}' by the {spec.models[model]} model, which was to be its"
                " bound",
                mend="give the bound as a quantity",
            )
        signs = [-1.0 if o.maximise else 1.0 for o in spec.objectives]
        signs += [-1.0 if c.above else 1.0 for c in spec.constraints]
        self.signs = np.array(signs)
        """(measures,), 1 where less is better."""
        sizes = np.abs(np.concatenate([objectives, self.bounds], axis=1))
        self.scales: Array = np.where(np.isfinite(sizes) & (sizes > 0.0), sizes, 1.0)
        """(models, measures), SI: the start's objectives, and the bounds."""
        self.offsets: Array = np.concatenate([np.zeros_like(objectives), self.bounds], axis=1)
        """(models, measures), SI."""

    def scaled(self, model: int, measure: int, values: Array) -> Array:
        """Return values of a measure, SI, as a loss, or as what is above zero where violated."""
        moved = values - self.offsets[model, measure]
        return np.asarray(self.signs[measure] * moved / self.scales[model, measure])

    def losses(self, measures: Array) -> Array:
        """Return losses (models, objectives, G) of measures (models, measures, G), SI."""
        n = self.n_objectives
        scaled = self.signs[:n, None] * measures[:, :n] / self.scales[:, :n, None]
        return np.where(np.isnan(scaled), _WORST, np.clip(scaled, -_WORST, _WORST))

    def violations(self, measures: Array) -> Array:
        """Return violations (models, constraints, G), 0 where a constraint is fulfilled."""
        n = self.n_objectives
        moved = measures[:, n:] - self.offsets[:, n:, None]
        over = self.signs[n:, None] * moved / self.scales[:, n:, None]
        over = np.where(np.isnan(over), WITHOUT_ANSWER, np.maximum(over, 0.0))
        return np.where(over <= TOLERANCE, 0.0, np.minimum(over, _WORST))

    def feasible(self, measures: Array) -> NDArray[np.bool_]:
        """Return which designs (models, G) have all objectives and fulfil all constraints."""
        known = (self.losses(measures) < _WORST).all(axis=1)
        return np.asarray(known & (self.violations(measures) == 0.0).all(axis=1))


def is_worst_case(measure: Measure, sign: float) -> bool:
    """Tell whether a measure is the worst value among postures, ``sign`` 1 where less is better."""
    if measure.column is not None:
        return measure.column.statistic == ("max" if sign > 0.0 else "min")
    return measure.kind == ("highest" if sign > 0.0 else "lowest")


def front(losses: Array, feasible: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which designs (G,) are feasible, and no feasible one is better in all losses (J, G).

    Of designs with the same losses the first one counts.
    """
    found = np.zeros(feasible.size, dtype=bool)
    best: list[int] = []
    own = losses.T
    # Whatever is better in all losses comes first.
    order = np.lexsort(losses[::-1])
    for i in order[feasible[order]]:
        if not best or not (own[best] <= own[i]).all(axis=1).any():
            best.append(int(i))
    found[best] = True
    return found
