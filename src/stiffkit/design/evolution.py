"""Evolution of a population: pymoo's NSGA-II, or its genetic algorithm for one objective."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.judge import TOLERANCE, Judge, front
from stiffkit.design.record import Record
from stiffkit.design.spec import Evolution
from stiffkit.errors import optional
from stiffkit.progress import Progress

Array = NDArray[np.float64]


def check_installed() -> None:
    """Raise MissingExtraError if pymoo is not installed."""
    other = "or give another 'method'"
    with optional("pymoo", needed_for="evolution", extra="design", or_=other):
        import pymoo.core.problem  # noqa: F401  # all of it is slow to import


def run_evolution(
    method: Evolution,
    record: Record,
    judge: Judge,
    seeds: tuple[Array, Array],
    model: int,
    seed: int,
    progress: Progress,
) -> None:
    """Evolve a population by one model; each generation is evaluated at once.

    Args:
        method: size of the population, and how many generations.
        record: what evaluates designs.
        judge: tells losses and violations.
        seeds: points (k, n) found before, with their measures: the best of them begin.
        model: its number.
        seed: of the random numbers.
        progress: is told the share of the generations that are done.

    Raises:
        MissingExtraError: if pymoo is not installed.
    """
    check_installed()
    from pymoo.core.problem import Problem  # slow to import
    from pymoo.optimize import minimize

    name = judge.spec.models[model]
    n_constraints = len(judge.spec.constraints)

    class Designs(Problem):  # type: ignore[misc]  # pymoo has no types
        def __init__(self) -> None:
            super().__init__(
                n_var=record.space.size,
                n_obj=judge.n_objectives,
                n_ieq_constr=n_constraints,
                xl=0.0,
                xu=1.0,
            )
            self.generation = 0

        def _evaluate(self, x: Array, out: dict[str, Array], *_: Any, **__: Any) -> None:
            progress(f"evolution, {name}", self.generation / method.generations)
            self.generation += 1
            measures = record.at(np.asarray(x, dtype=float).T)
            out["F"] = judge.losses(measures)[model].T
            out["G"] = judge.violations(measures)[model].T - TOLERANCE

    first = _first(method.population, record, judge, seeds, model, seed)
    minimize(
        Designs(),
        _algorithm(method.population, first, judge.n_objectives),
        ("n_gen", method.generations),
        seed=seed,
        verbose=False,
    )


def _algorithm(population: int, first: Array, n_objectives: int) -> Any:
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.algorithms.soo.nonconvex.ga import GA

    kind = NSGA2 if n_objectives > 1 else GA
    return kind(pop_size=population, sampling=first.T, eliminate_duplicates=True)


def _first(
    population: int,
    record: Record,
    judge: Judge,
    seeds: tuple[Array, Array],
    model: int,
    seed: int,
) -> Array:
    """Return the first generation (k, n): the best half of what is known, and random designs."""
    points, measures = seeds
    violation = judge.violations(measures)[model].sum(axis=0)
    losses = judge.losses(measures)[model]
    on_front = front(losses, judge.feasible(measures)[model])
    order = np.lexsort([losses[0], violation, ~on_front])[: max(population // 2, 1)]
    others = record.space.sample(population - order.size, seed)
    return np.concatenate([points[:, order], others], axis=1)
