"""Constrained optimisation by gradients, from one start.

The worst value over a workspace is not smooth: which posture is the worst changes with the design.
So a bound is put on the value at each of the few postures that are nearly the worst, and the bound
is what is optimised or constrained (the bound formulation of minimax problems). Postures that turn
out to be worse are added, until there are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.judge import TOLERANCE, Judge, is_worst_case
from stiffkit.design.slopes import Row, Slopes
from stiffkit.errors import StiffkitError

Array = NDArray[np.float64]

_NEARLY_WORST = 4
"""Postures of a measure that are added at a time."""
_ROUNDS = 6
_ITERATIONS = 40
_ACCURACY = 1e-9
_OUT_OF_REACH = 100.0
"""Of the objective, over the share of what is not reached but must be: no step ends there."""


@dataclass(frozen=True)
class Aim:
    """What a descent is after: to minimise the sum of slacks s >= ``lowest`` with rows <= D s.

    A row is a measure as `Judge.scaled` has it, less an ideal.
    """

    measures: tuple[int, ...]
    slack: tuple[int, ...]
    """Which slack eases each of the measures; -1 for none."""
    weight: tuple[float, ...]
    """D: how much one unit of its slack eases a measure."""
    ideal: tuple[float, ...]
    lowest: float
    """Of all slacks."""
    reached: tuple[int, ...]
    """Measures that no step may break: they change by whole postures, and have no derivative."""

    @property
    def n_slacks(self) -> int:
        """Number of slacks."""
        return max(self.slack) + 1


def towards(judge: Judge, direction: Sequence[float], ideal: Sequence[float]) -> Aim:
    """Return the aim to get all objectives as far beyond an ideal as can be, in a direction.

    What is minimised is the largest of (loss - ideal) / direction; objectives whose direction is 0
    are left alone. All constraints hold.
    """
    n = judge.n_objectives
    counted = [i for i in range(n) if direction[i] > 0.0]
    bound = _bound(judge)
    return Aim(
        (*counted, *bound),
        (*[0] * len(counted), *[-1] * len(bound)),
        (*[direction[i] for i in counted], *[0.0] * len(bound)),
        (*[ideal[i] for i in counted], *[0.0] * len(bound)),
        -np.inf,
        _reached(judge),
    )


def least_violation(judge: Judge, kept: Sequence[int] | None = None) -> Aim:
    """Return the aim of the smallest sum of violations of some of the constraints, or of all."""
    counted = range(len(judge.spec.constraints)) if kept is None else kept
    bound = [r for r in _bound(judge) if r - judge.n_objectives in counted]
    n = len(bound)
    reached = [r for r in _reached(judge) if r - judge.n_objectives in counted]
    return Aim(tuple(bound), tuple(range(n)), (1.0,) * n, (0.0,) * n, 0.0, tuple(reached))


def _reached(judge: Judge) -> tuple[int, ...]:
    measures = judge.spec.measures
    return tuple(r for r, measure in enumerate(measures) if measure.kind == "reached")


def _bound(judge: Judge) -> list[int]:
    """Return the measures of the constraints whose violation changes little by little."""
    measures = judge.spec.measures
    return [r for r in range(judge.n_objectives, len(measures)) if measures[r].kind != "reached"]


class Descent:
    """Descends from designs, by one model."""

    def __init__(self, slopes: Slopes, judge: Judge, model: int) -> None:
        """Take the number of the model."""
        self.slopes = slopes
        self.judge = judge
        self.model = model
        measures = judge.spec.measures
        self._worst_case = [is_worst_case(m, s) for m, s in zip(measures, judge.signs, strict=True)]

    def run(self, start: Array, aim: Aim) -> Array:
        """Return the point (k,) that is reached from a start (k,); whole numbers stay.

        A start that cannot be put together stays as it is: without values nothing tells a way.
        """
        if not aim.measures:
            return start
        u, rows = start, list[Row]()
        for _ in range(_ROUNDS):
            new = self._worst_rows(u, aim, rows)
            if not new:
                break
            rows += new
            u = _Rounds(self, aim, rows).minimised(u)
        return u

    def _worst_rows(self, u: Array, aim: Aim, rows: list[Row]) -> list[Row]:
        """Return rows that are missing at a point: all that are worse than those that are there.

        There are none where the aim's measures have no values at all.
        """
        fields = self.slopes.evaluation.fields(
            self.slopes.space.parameters(u[:, None]), self.model, aim.measures
        )
        found: list[Row] = []
        if all(np.isnan(field).all() for field in fields.values()):
            return found
        for measure in aim.measures:
            known = {row.place for row in rows if row.measure == measure}
            if not self._worst_case[measure]:
                found += [] if known else [Row(measure)]
                continue
            scaled = self.judge.scaled(self.model, measure, fields[measure][0])
            ranked = np.argsort(-np.nan_to_num(scaled, nan=-np.inf, posinf=1e30), kind="stable")
            worst = [int(i) for i in ranked[:_NEARLY_WORST] if not np.isnan(scaled[i])]
            if not known:
                found += [Row(measure, i) for i in worst]
                continue
            limit = max((scaled[i] for i in known if not np.isnan(scaled[i])), default=-np.inf)
            beyond = limit + TOLERANCE * max(abs(limit), 1.0)
            found += [Row(measure, i) for i in worst if scaled[i] > beyond and i not in known]
        return found


class _Rounds:
    """One problem with fixed rows, as SciPy's SLSQP takes it."""

    def __init__(self, descent: Descent, aim: Aim, rows: list[Row]) -> None:
        self.descent = descent
        self.rows = rows
        place = {measure: i for i, measure in enumerate(aim.measures)}
        own = [place[row.measure] for row in rows]
        self.D = np.zeros((len(rows), aim.n_slacks))
        for i, one in enumerate(own):
            if aim.slack[one] >= 0:
                self.D[i, aim.slack[one]] = aim.weight[one]
        self.ideal = np.array([aim.ideal[one] for one in own])
        self.lowest = aim.lowest
        self.reached = [Row(r) for r in aim.reached]
        self._last_key = b""
        self._last = np.empty(0), 0.0

    def minimised(self, start: Array) -> Array:
        """Return the point (k,) that SLSQP ends at."""
        from scipy.optimize import minimize  # slow to import

        free = self.descent.slopes.space.continuous
        h, _ = self.at(start)
        c, s = free.size, self.D.shape[1]
        slack = np.zeros(s)
        for j in range(s):
            eased = self.D[:, j] > 0.0
            slack[j] = np.max(h[eased] / self.D[eased, j], initial=max(self.lowest, -1e6))

        def point(z: Array) -> Array:
            u = start.copy()
            u[free] = np.clip(z[:c], 0.0, 1.0)
            return u

        def objective(z: Array) -> float:
            return float(z[c:].sum()) + _OUT_OF_REACH * self.at(point(z))[1]

        def rows_slopes(z: Array) -> Array:
            return np.concatenate([-self.slopes(point(z)), self.D], axis=1)

        found = minimize(
            objective,
            np.concatenate([start[free], slack]),
            jac=lambda z: np.concatenate([np.zeros(c), np.ones(z.size - c)]),
            method="SLSQP",
            bounds=[(0.0, 1.0)] * c
            + [(self.lowest if np.isfinite(self.lowest) else None, None)] * s,
            constraints={
                "type": "ineq",
                "fun": lambda z: self.D @ z[c:] - self.at(point(z))[0],
                "jac": rows_slopes,
            },
            options={"maxiter": _ITERATIONS, "ftol": _ACCURACY},
        )
        return point(found.x) if np.isfinite(found.x).all() else start

    def at(self, u: Array) -> tuple[Array, float]:
        """Return the rows (r,) at a point, and how much of what must be reached there is not."""
        key = u.tobytes()
        if key != self._last_key:
            descent = self.descent
            rows = [*self.rows, *self.reached]
            values = descent.slopes.values(u, rows, descent.model)
            judged = np.array(
                [
                    descent.judge.scaled(descent.model, row.measure, value)
                    for row, value in zip(rows, values, strict=True)
                ]
            )
            found, missing = judged[: len(self.rows)] - self.ideal, judged[len(self.rows) :]
            self._last = (
                np.where(np.isfinite(found), found, 1.0),
                float(np.nan_to_num(missing, nan=1.0).max(initial=0.0)),
            )
            self._last_key = key
        return self._last

    def slopes(self, u: Array) -> Array:
        """Return the derivatives (r, c) of the rows at a point."""
        descent = self.descent
        judge, measures = descent.judge, [row.measure for row in self.rows]
        factor = judge.signs[measures] / judge.scales[descent.model, measures]
        try:
            found = descent.slopes.at(u, self.rows, descent.model)
        except StiffkitError:
            # Beside this design there is no robot: no way leads on from here.
            return np.zeros((len(self.rows), descent.slopes.space.continuous.size))
        return np.asarray(factor[:, None] * found)
