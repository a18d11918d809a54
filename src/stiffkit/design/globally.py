"""Global search for the best design by the first objective: SciPy's differential evolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.judge import TOLERANCE, Judge
from stiffkit.design.record import Record
from stiffkit.design.spec import Global
from stiffkit.progress import Progress

Array = NDArray[np.float64]

_FEWEST = 5
"""Designs of a generation that the method needs."""


def run_global(
    method: Global, record: Record, judge: Judge, model: int, seed: int, progress: Progress
) -> None:
    """Search by one model; each generation is evaluated at once.

    The method is that of Storn and Price, with constraints as Lampinen puts them: see
    `scipy.optimize.differential_evolution`.
    """
    from scipy.optimize import NonlinearConstraint, differential_evolution  # slow to import

    name = judge.spec.models[model]
    generation = 0

    def losses(u: Array) -> Array:
        return np.asarray(judge.losses(record.at(u))[model, 0])

    def violations(u: Array) -> Array:
        points = u if u.ndim == 2 else u[:, None]
        found = judge.violations(record.at(points))[model]
        return np.asarray(found if u.ndim == 2 else found[:, 0])

    def told(*_: object, **__: object) -> None:
        nonlocal generation
        generation += 1
        progress(f"global search, {name}", generation / method.generations)

    first = record.space.sample(max(method.population, _FEWEST), seed)
    differential_evolution(
        losses,
        [(0.0, 1.0)] * record.space.size,
        init=first.T,
        maxiter=method.generations,
        rng=seed,
        polish=False,
        updating="deferred",
        vectorized=True,
        callback=told,
        constraints=NonlinearConstraint(violations, -np.inf, TOLERANCE),
    )
