"""Derivatives of measures at single postures, exact where they are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.evaluation import Evaluation, alone, reduced
from stiffkit.design.solved import mass_of
from stiffkit.design.space import Space
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep import Column
from stiffkit.study.sweep.differences import derivatives, steps_of
from stiffkit.study.sweep.gradients import Gradients, PosturesOf

Array = NDArray[np.float64]

STEP = 1e-3
"""Of differences, over the range of a variable."""


@dataclass(frozen=True)
class Row:
    """A measure, or what it is at one posture."""

    measure: int
    place: int = -1
    """Number of the posture among those of the measure's field; -1 for the measure itself."""


class Slopes:
    """Derivatives by the continuous variables, as coordinates of the unit cube.

    Statistics of stiffnesses, deflections and the refined model's frequencies are differentiated
    exactly, and masses as exactly as the robot file's formulas; sizes, joint coordinates and the
    simplified model's frequencies by central differences.
    """

    def __init__(self, evaluation: Evaluation, space: Space) -> None:
        """Take what evaluates designs, and their space."""
        self.evaluation = evaluation
        self.space = space
        self._exact = Gradients(evaluation.engine)

    def values(self, u: Array, rows: Sequence[Row], model: int) -> Array:
        """Return the values (n_rows,), SI, at a point (k,); NaN where there is no answer."""
        return self._values(u[:, None], rows, model)[:, 0]

    def at(self, u: Array, rows: Sequence[Row], model: int) -> Array:
        """Return the derivatives (n_rows, c), SI, at a point (k,); 0 where there is none."""
        found = np.zeros((len(rows), self.space.continuous.size))
        exact = [i for i, row in enumerate(rows) if self._is_exact(row, model)]
        if exact:
            found[exact] = self._by_theory(u, [rows[i] for i in exact], model)
        others = [i for i in range(len(rows)) if i not in exact]
        if others:
            found[others] = self.differences(u, [rows[i] for i in others], model)
        return np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)

    def differences(self, u: Array, rows: Sequence[Row], model: int) -> Array:
        """Return derivatives (n_rows, c) by differences, within the range of each variable."""
        ahead, behind = (np.repeat(u[:, None], self.space.continuous.size, axis=1) for _ in "+-")
        for column, i in enumerate(self.space.continuous):
            ahead[i, column] = min(u[i] + STEP, 1.0)
            behind[i, column] = max(u[i] - STEP, 0.0)
        found = self._values(np.concatenate([ahead, behind], axis=1), rows, model)
        change = found[:, : ahead.shape[1]] - found[:, ahead.shape[1] :]
        return np.asarray(change / np.diagonal((ahead - behind)[self.space.continuous]))

    def _values(self, u: Array, rows: Sequence[Row], model: int) -> Array:
        asked = sorted({row.measure for row in rows})
        fields = self.evaluation.fields(self.space.parameters(u), model, asked)
        measures = self.evaluation.measures
        found = np.empty((len(rows), u.shape[1]))
        for i, row in enumerate(rows):
            field = fields[row.measure]
            whole = row.place < 0
            found[i] = reduced(measures[row.measure], field) if whole else field[:, row.place]
        return found

    def _is_exact(self, row: Row, model: int) -> bool:
        measure = self.evaluation.measures[row.measure]
        column = measure.column
        if column is None:
            return measure.kind == "mass"
        name = self.evaluation.spec.models[model]
        if QUANTITIES[column.quantity].source == "frequencies":
            return name == "refined"
        return self._exact.knows(name)

    def _by_theory(self, u: Array, rows: Sequence[Row], model: int) -> Array:
        own = self.space.parameters(u[:, None])[:, 0]
        by_parameters = np.full((len(rows), own.size), np.nan)
        self.evaluation.count += 1
        name = self.evaluation.spec.models[model]
        whole: dict[int, Column] = {}
        alike: dict[tuple[str, str | None], list[int]] = {}
        with alone():
            for i, row in enumerate(rows):
                column = self.evaluation.measures[row.measure].column
                if column is None:
                    by_parameters[i] = self._mass(own)
                elif row.place < 0:
                    whole[i] = column
                else:
                    alike.setdefault((column.quantity, column.load), []).append(i)
            postures = self._exact.postures(own) if whole or alike else None
            if postures is not None:
                if whole:
                    found = self._exact.of(postures, list(whole.values()), name)
                    by_parameters[list(whole)] = found.slopes
                for (quantity, load), which in alike.items():
                    at = np.array([rows[i].place for i in which], dtype=np.intp)
                    by_parameters[which] = self._at_postures(postures, quantity, load, model, at).T
        return by_parameters[:, self.space.rows[self.space.continuous]] * self.space.span

    def _mass(self, own: Array) -> Array:
        """Return the derivatives (p,) of the mass by parameters (p,)."""
        family = self.evaluation.family

        def mass(values: Array) -> dict[str, Array]:
            return {"mass": np.array(mass_of(family.geometry(values).robot))}

        return derivatives(mass, own, steps_of(own, family.span))["mass"]

    def _at_postures(
        self,
        postures: PosturesOf,
        quantity: str,
        load: str | None,
        model: int,
        at: NDArray[np.intp],
    ) -> Array:
        """Return the derivatives (p, n) of a quantity at postures (n,); NaN where it has none."""
        name = self.evaluation.spec.models[model]
        is_frequency = QUANTITIES[quantity].source == "frequencies"
        at = self.evaluation.family.frequency_postures[at] if is_frequency else at
        lower, known = postures.compliances(name)
        found = np.full((postures.values.size, at.size), np.nan)
        which = np.flatnonzero(known[at])
        if not which.size:
            return found
        if is_frequency:
            found[:, which] = postures.frequency_slopes(at[which])[1]
        else:
            own = lower[:, at[which]]
            found[:, which] = postures.quantity_slopes(quantity, load, name, at[which], own)
        return found
