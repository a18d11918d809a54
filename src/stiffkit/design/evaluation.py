"""The measures of many designs at once, by all models."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, decided, default_backend
from stiffkit.compiled.threads import limited_threads
from stiffkit.design.solved import solve
from stiffkit.design.spec import DesignSpec, Measure
from stiffkit.kinematics.numeric import one_thread
from stiffkit.study.sweep.engine import Engine
from stiffkit.study.sweep.family import Family
from stiffkit.study.sweep.frequencies import LowestFrequencies
from stiffkit.study.sweep.group import Groups
from stiffkit.study.sweep.prepare import make_anchors
from stiffkit.study.sweep.statistics import reduce
from stiffkit.study.sweep.train import train_basis

Array = NDArray[np.float64]

_REMEMBERED = 128
"""Geometries: derivatives of several measures by all parameters come back to the same ones."""


class Evaluation:
    """Computes measures of designs; machine code is made once for all of them.

    The numbers of a design depend on nothing but the study and the design.
    """

    def __init__(self, spec: DesignSpec, backend: Backend | None = None) -> None:
        """Read the robot file, and solve the designs that all others begin from.

        Raises FileError, AssemblyError or PoseError where the robot file's own design is at fault.
        """
        self.spec = spec
        self.measures = spec.measures
        self.backend = decided(backend or default_backend())
        with alone():
            family = Family(spec.study, dict(spec.derived), remembered=_REMEMBERED)
            groups = Groups(family, self.backend)
            anchors = make_anchors(groups)
            frequencies = None
            if spec.frequency_postures and "refined" in spec.models:
                # Few frequencies are not worth compiling a large kernel.
                frequencies = LowestFrequencies(train_basis(groups, anchors), "numpy")
            self.engine = Engine(groups, anchors, frequencies)
        self.family = family
        self.count = 0
        """Geometries that have been evaluated."""

    def start(self) -> Array:
        """Return the robot file's own values (k,) of the varied parameters, SI."""
        return self.family.own_values()

    def at(self, values: Array) -> Array:
        """Return the measures (models, measures, G), SI, of designs with values (k, G).

        What has no answer is NaN; of the workspace, nothing is reached then.
        """
        self.count += values.shape[1]
        found = np.full((len(self.spec.models), len(self.measures), values.shape[1]), np.nan)
        found[:, [m.kind == "reached" for m in self.measures]] = 0.0
        with alone():
            for solved in solve(self.engine, values):
                for m in range(len(self.spec.models)):
                    for r, measure in enumerate(self.measures):
                        found[m, r, solved.numbers] = reduced(measure, solved.of(measure, m))
        return found

    def fields(self, values: Array, model: int, which: Sequence[int]) -> dict[int, Array]:
        """Return some measures at each posture, (G, n), of designs with values (k, G).

        ``which`` are numbers of measures. Where one is one number of the whole design, n = 1; n = F
        for frequencies, and P for all others. What has no answer is NaN.
        """
        self.count += values.shape[1]
        found = {
            r: np.full((values.shape[1], self._width(self.measures[r])), np.nan) for r in which
        }
        with alone():
            for solved in solve(self.engine, values):
                for r in which:
                    found[r][solved.numbers] = solved.of(self.measures[r], model)
        return found

    def _width(self, measure: Measure) -> int:
        if measure.kind in ("reached", "mass", "size"):
            return 1
        if measure.column is not None and measure.column.quantity == "frequency_first":
            return self.spec.frequency_postures
        return self.family.n_postures


def reduced(measure: Measure, field: Array) -> Array:
    """Return a measure (G,) of designs, given what it is at each posture (G, n)."""
    if measure.column is not None:
        return reduce(measure.column, field)[0]
    if field.shape[1] == 1:
        return np.asarray(field[:, 0])
    known = ~np.isnan(field)
    nothing = ~known.any(axis=1)
    lowest = np.min(np.where(known, field, np.inf), axis=1)
    highest = np.max(np.where(known, field, -np.inf), axis=1)
    found = {"lowest": lowest, "highest": highest}.get(measure.kind)
    if found is None:
        with np.errstate(invalid="ignore"):
            found = highest - lowest
    return np.where(nothing, np.nan, found)


@contextmanager
def alone() -> Iterator[None]:
    """Keep linear algebra on small matrices to one thread, which is many times faster."""
    with one_thread(), limited_threads(1):
        yield
