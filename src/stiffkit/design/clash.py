"""Which constraints cannot be met together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.descent import Descent, least_violation
from stiffkit.design.judge import Judge
from stiffkit.design.measures import goal_in_words, units_of
from stiffkit.design.record import Record

Array = NDArray[np.float64]


def explain(record: Record, judge: Judge, descent: Descent, designs: tuple[Array, Array]) -> str:
    """Return in words which constraints clash by a model that has no feasible design.

    ``designs`` are points (k, n) looked at, with their measures. The sum of violations is
    minimised, and constraints are left out one after the other; what can be left out without the
    others being met is not needed for the clash (the deletion filter: Chinneck and Dravnieks, ORSA
    Journal on Computing 3, 1991). What is left cannot be met together, but without any one of them.
    """
    search = _LeastViolation(record, judge, descent, designs)
    name = judge.spec.models[descent.model]
    if not _reaches_anything(judge, designs[1][descent.model]):
        return (
            f"{name} model: none of the designs that were looked at can be put together and reach"
            " any of its workspace. Give the parameters under 'vary' ranges in which there is a"
            " robot"
        )
    kept = list(range(len(judge.spec.constraints)))
    point, violations = search.least(kept)
    if not violations.any():
        return f"{name} model: a design that fulfils all constraints is {_at(search, point)}"
    # Those that are met already are left out first.
    for i in np.argsort(violations > 0.0, kind="stable").tolist():
        fewer = [k for k in kept if k != i]
        if not fewer:
            break
        found, left = search.least(fewer)
        if left[fewer].any():
            kept, point = fewer, found
    words = [_words(judge, descent.model, i) for i in kept]
    together = f"{_listed(words)} cannot be met together"
    text = together if len(words) > 1 else f"no design meets {words[0]}"
    measures = search.measures(point)[descent.model, judge.n_objectives :, 0]
    least = [_reading(judge, i, measures[i]) for i in kept]
    where = _at(search, point)
    return f"{name} model: {text}. The least violation found has {_listed(least)}, {where}"


def _reaches_anything(judge: Judge, measures: Array) -> bool:
    """Tell whether any of the designs, with measures (measures, n), reaches any pose."""
    shares = [measures[r] for r, m in enumerate(judge.spec.measures) if m.kind == "reached"]
    return bool(np.nan_to_num(np.array(shares)).any())


class _LeastViolation:
    """The designs with the smallest sums of violations."""

    def __init__(
        self, record: Record, judge: Judge, descent: Descent, designs: tuple[Array, Array]
    ) -> None:
        self.record = record
        self.judge = judge
        self.descent = descent
        self.points, known = designs
        self.violations = judge.violations(known)[descent.model]

    def least(self, kept: Sequence[int]) -> tuple[Array, Array]:
        """Return a point (k,) with the smallest sum of some of its violations, and all of them."""
        own = self.violations[kept]
        start = self.points[:, int(np.argmin(own.sum(axis=0)))]
        if not own.sum(axis=0).min():
            return start, self.violations[:, int(np.argmin(own.sum(axis=0)))]
        model = self.judge.spec.models[self.descent.model]
        name = f"clash-{model}-{len(kept):03d}-{sum(1 << i for i in kept):x}"
        step = self.record.step(name, start, lambda: {"end": self._end(start, kept)})
        found = self.judge.violations(self.record.at(step["end"][:, None]))[self.descent.model]
        self.points = np.concatenate([self.points, step["end"][:, None]], axis=1)
        self.violations = np.concatenate([self.violations, found], axis=1)
        best = int(np.argmin(self.violations[kept].sum(axis=0)))
        return self.points[:, best], self.violations[:, best]

    def _end(self, start: Array, kept: Sequence[int]) -> Array:
        if not self.record.space.continuous.size:
            return start
        return self.descent.run(start, least_violation(self.judge, kept))

    def measures(self, point: Array) -> Array:
        """Return the measures (models, measures, 1) at a point (k,)."""
        return self.record.at(point[:, None])


def _words(judge: Judge, model: int, i: int) -> str:
    constraint = judge.spec.constraints[i]
    return f"'{constraint.measure.name}' ({goal_in_words(constraint, judge.bounds[model, i])})"


def _reading(judge: Judge, i: int, value: float) -> str:
    measure = judge.spec.constraints[i].measure
    units = units_of(measure)
    return f"{measure.name} {value:.5g}{'' if units == '1' else f' {units}'}"


def _at(search: _LeastViolation, point: Array) -> str:
    values = search.record.space.parameters(point[:, None])[:, 0]
    names = [p.name for p in search.judge.spec.parameters]
    return "at " + ", ".join(f"{n} = {v:.5g}" for n, v in zip(names, values, strict=True))


def _listed(words: Sequence[str]) -> str:
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last
