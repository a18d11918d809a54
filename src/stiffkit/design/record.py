"""The designs that a method has looked at."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.evaluation import Evaluation
from stiffkit.design.journal import Journal, Step
from stiffkit.design.space import Space

Array = NDArray[np.float64]


class Record:
    """Evaluates designs, each once, and keeps them."""

    def __init__(self, name: str, evaluation: Evaluation, space: Space, journal: Journal) -> None:
        """Take the name that its steps have in the journal."""
        self.name = name
        self.evaluation = evaluation
        self.space = space
        self.seconds = 0.0
        self.count = 0
        """Geometries that were evaluated for it, here or for gradients."""
        self._journal = journal
        self._batches = 0
        self._known: dict[bytes, Array] = {}
        self._points: list[Array] = []

    def at(self, u: Array) -> Array:
        """Return the measures (models, measures, n), SI, at points (k, n)."""
        u = self.space.snapped(u)
        new = {own.tobytes(): own for own in u.T if own.tobytes() not in self._known}
        if new:
            points = np.array(list(new.values())).T
            found = self.step(f"{self._batches:05d}", points, lambda: self._evaluated(points))
            for key, own, measures in zip(
                new, points.T, np.moveaxis(found["measures"], 2, 0), strict=True
            ):
                self._known[key] = measures
                self._points.append(own)
            self._batches += 1
        return self._measures_at(u.T)

    def _evaluated(self, points: Array) -> Step:
        return {"measures": self.evaluation.at(self.space.parameters(points))}

    def step(self, name: str, given: Array, compute: Callable[[], Step]) -> Step:
        """Return a step of the journal, and count what it takes."""

        def counted() -> Step:
            before = self.evaluation.count
            step = compute()
            step["count"] = np.array(self.evaluation.count - before)
            return step

        found = self._journal.step(f"{self.name}-{name}", given, counted)
        self.seconds += float(found["seconds"])
        self.count += int(found["count"])
        return found

    @property
    def points(self) -> Array:
        """The points (k, n) that were evaluated, in that order."""
        return np.array(self._points).reshape(-1, self.space.size).T

    @property
    def measures(self) -> Array:
        """Their measures (models, measures, n), SI."""
        return self._measures_at(self._points)

    def _measures_at(self, points: Iterable[Array]) -> Array:
        """Return the measures (models, measures, n), SI, at points (k,); n can be 0."""
        shape = len(self.evaluation.spec.models), len(self.evaluation.measures)
        found = [self._known[own.tobytes()] for own in points]
        return np.moveaxis(np.array(found).reshape(-1, *shape), 0, 2)
