"""Optimisation by gradients from several starts, for the best of each objective and the front."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.descent import Aim, Descent, least_violation, towards
from stiffkit.design.judge import Judge
from stiffkit.design.record import Record
from stiffkit.design.slopes import Slopes
from stiffkit.design.spec import Gradient
from stiffkit.progress import Progress

Array = NDArray[np.float64]

_CANDIDATES = 16
"""Designs of a latin hypercube, the best of which is a start."""


def run_gradient(
    method: Gradient, record: Record, judge: Judge, start: Array, seed: int, progress: Progress
) -> None:
    """Descend by each model from a start (k,) and from the best of random designs.

    From each start the first objective is aimed at; then, from the best design so far, the others,
    and points of the front between the best of each.
    """
    slopes = Slopes(record.evaluation, record.space)
    sample = record.space.sample(_CANDIDATES * max(method.starts - 1, 1), seed)
    step = record.step("sample", sample, lambda: {"measures": _measures(record, sample)})
    n = judge.n_objectives
    n_aims = method.starts + (n - 1 + method.points if n > 1 else 0)
    for model, name in enumerate(judge.spec.models):
        starts = [start, *_chosen(judge, model, sample, step["measures"], method.starts - 1)]
        search = _Search(record, judge, Descent(slopes, judge, model), name)
        for done, (begin, aim) in enumerate(_aims(search, judge, starts, method.points, seed)):
            progress(f"gradient, {name}", done / n_aims)
            search.descend(begin, aim)


def _aims(
    search: _Search, judge: Judge, starts: list[Array], points: int, seed: int
) -> Iterator[tuple[Array, Aim]]:
    """Yield where to begin and what to aim at; each depends on what was found before."""
    n = judge.n_objectives
    one_each = np.eye(n).tolist()
    for start in starts:
        yield start, towards(judge, one_each[0], [0.0] * n)
    for objective in range(1, n):
        yield search.best(0), towards(judge, one_each[objective], [0.0] * n)
    if n > 1 and points:
        ideal, span = search.corners()
        for weights in _between(n, points, seed):
            # From the plane through the corners, along the same way for all.
            begin = ideal + weights * span
            yield search.nearest(begin, span), towards(judge, span.tolist(), begin.tolist())


def _measures(record: Record, points: Array) -> Array:
    return record.evaluation.at(record.space.parameters(points))


def _chosen(judge: Judge, model: int, sample: Array, measures: Array, count: int) -> list[Array]:
    """Return the best design of each of so many groups of a sample."""
    violation = judge.violations(measures)[model].sum(axis=0)
    loss = judge.losses(measures)[model, 0]
    order = np.lexsort([loss, violation])
    rank = np.argsort(order)
    groups = np.array_split(np.arange(sample.shape[1]), count) if count else []
    return [sample[:, group[np.argmin(rank[group])]] for group in groups]


def _between(n: int, count: int, seed: int) -> Array:
    """Return shares (count, n) whose sum is 1, spread evenly between the corners."""
    if n == 2:
        share = np.linspace(0.0, 1.0, count + 2)[1:-1]
        return np.stack([share, 1.0 - share], axis=1)
    random = np.random.default_rng(seed).dirichlet(np.ones(n), count)
    return np.asarray(random)


class _Search:
    """The designs that descents by one model have ended at."""

    def __init__(self, record: Record, judge: Judge, descent: Descent, name: str) -> None:
        self.record = record
        self.judge = judge
        self.descent = descent
        self.name = name
        self.ends: list[Array] = []
        self.losses: list[Array] = []
        self.violations: list[float] = []

    def descend(self, start: Array, aim: Aim) -> None:
        """Descend from a start, by way of the least violation if that is not 0 there."""
        number = len(self.ends)
        given = np.concatenate([start, aim.weight, aim.ideal])
        step = self.record.step(
            f"{self.name}-{number:04d}", given, lambda: {"end": self._end(start, aim)}
        )
        measures = self.record.at(step["end"][:, None])
        model = self.descent.model
        self.ends.append(step["end"])
        self.losses.append(self.judge.losses(measures)[model, :, 0])
        self.violations.append(float(self.judge.violations(measures)[model].sum()))

    def _end(self, start: Array, aim: Aim) -> Array:
        if self._violation(start) > 0.0:
            start = self.descent.run(start, least_violation(self.judge))
            if self._violation(start) > 0.0:
                return start
        found = self.descent.run(start, aim)
        if self._violation(found) > 0.0:
            # Often by little: a frequency is known to 1e-4 only, and slopes are not quite its own.
            found = self.descent.run(found, least_violation(self.judge))
        return found if self._violation(found) == 0.0 else start

    def _violation(self, u: Array) -> float:
        measures = _measures(self.record, u[:, None])
        return float(self.judge.violations(measures)[self.descent.model].sum())

    def best(self, objective: int) -> Array:
        """Return the feasible end with the smallest loss, or that with the least violation."""
        ranked = [
            (violation, loss[objective])
            for violation, loss in zip(self.violations, self.losses, strict=True)
        ]
        return self.ends[min(range(len(ranked)), key=ranked.__getitem__)]

    def _known(self) -> NDArray[np.intp]:
        feasible: NDArray[np.intp] = np.flatnonzero(np.array(self.violations) == 0.0)
        return feasible if feasible.size else np.arange(len(self.ends))

    def corners(self) -> tuple[Array, Array]:
        """Return the smallest loss (J,) of each objective, and how far losses range (J,)."""
        losses = np.array(self.losses)[self._known()]
        best = losses[np.argmin(losses, axis=0)]
        ideal = best.min(axis=0)
        return ideal, np.maximum(best.max(axis=0) - ideal, 1e-6)

    def nearest(self, begin: Array, span: Array) -> Array:
        """Return the end that is the farthest from a point (J,) on the way to smaller losses."""
        known = self._known()
        reach = np.max((np.array(self.losses)[known] - begin) / span, axis=1)
        return self.ends[int(known[int(np.argmin(reach))])]
