"""The rows of a study's table: geometry by geometry, reduced while sweeping.

A row depends on the study and on its own geometry, and on nothing else: not on which other
geometries are computed with it, nor on which were computed before.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import StiffkitError
from stiffkit.kinematics import SpanningTree
from stiffkit.smallmat import ZERO_SHARE
from stiffkit.stiffness import Assembly, deflection, lower_triangles
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.anchors import Anchors
from stiffkit.study.sweep.closing import Closing, Homes
from stiffkit.study.sweep.family import Geometry
from stiffkit.study.sweep.frequencies import LowestFrequencies
from stiffkit.study.sweep.group import CompliancesOfModel, Group, Groups
from stiffkit.study.sweep.spec import Column
from stiffkit.study.sweep.statistics import reduce

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = dict[str, NDArray[np.generic]]
"""Arrays of a table by name; the geometry is the last dimension, the model, if any, the first."""

NEAREST = 8
"""Anchors that a geometry looks at: all but the first only where home postures are in doubt."""
_LONGEST_REASON = 200
_TOGETHER = 1 << 16
"""Postures at a time, of whole geometries: memory does not grow with the study."""
_REDUCED = 2048
"""Postures whose compliances are computed and reduced at a time: they stay in the cache."""


class GeometryStatus(IntEnum):
    """What is known of a geometry."""

    OK = 0
    INVALID = 1
    NOT_ASSEMBLED = 2

    @property
    def word(self) -> str:
        """The name as tables show it."""
        return self.name.lower()


@dataclass(frozen=True, eq=False)
class _Block:
    """Some geometries of one group with their postures."""

    which: NDArray[np.intp]
    """(B,), numbers among the geometries of the group."""
    q: Array
    """(n, B, P), NaN where not reached."""
    reached: Mask
    inside: Mask


@dataclass(frozen=True, eq=False)
class _Few:
    """The few postures of geometries at which frequencies are asked for."""

    which: NDArray[np.intp]
    """(G,), numbers among the geometries of the group."""
    q: Array
    """(n, G, F)."""
    ok: Mask
    """(G, F), where the refined model has an answer."""


class Engine:
    """Computes rows of the table of one study."""

    def __init__(
        self, groups: Groups, anchors: Anchors, frequencies: LowestFrequencies | None = None
    ) -> None:
        """Take the geometries' machine code, the anchors to begin at, and what vibrates."""
        self.groups = groups
        self.family = groups.family
        self.spec = self.family.spec
        self.anchors = anchors
        self.frequencies = frequencies

    def rows(self, values: Array) -> Rows:
        """Return the rows of geometries with these values (k, G) of the varied parameters."""
        rows = self._empty(values.shape[1])
        geometries: dict[int, Geometry] = {}
        for i, own in enumerate(values.T):
            try:
                geometries[i] = self.family.geometry(own)
            except StiffkitError as error:
                _refuse(rows, i, GeometryStatus.INVALID, error.what)
        grouped: dict[bytes, list[int]] = {}
        for i, geometry in geometries.items():
            grouped.setdefault(geometry.pattern, []).append(i)
        near = self.anchors.nearest(values, self.family.span, NEAREST)
        for numbers in grouped.values():
            own = [geometries[i] for i in numbers]
            closing = Closing(self.groups.of(own[0]), own, self.anchors, near[:, numbers])
            self._fill(rows, np.array(numbers), closing)
        # As wide as need be: most geometries have no reason to tell.
        rows["reason"] = np.array(rows["reason"].tolist(), dtype=str)
        return rows

    def _empty(self, n: int) -> Rows:
        models = len(self.spec.models)
        rows: Rows = {
            "geometry_status": np.zeros(n, dtype=np.int8),
            "reason": np.full(n, "", dtype=f"U{_LONGEST_REASON}"),
            "postures_ok": np.zeros((models, n), dtype=np.int32),
            "postures_unreachable": np.zeros((models, n), dtype=np.int32),
            "postures_singular": np.zeros((models, n), dtype=np.int32),
        }
        for column in self.spec.columns:
            rows[column.name] = np.full((models, n), np.nan)
            if column.has_place:
                rows[f"{column.name}_at"] = np.full((models, len(self.family.swept), n), np.nan)
        if self.frequencies is not None:
            rows["frequency_first"] = np.full((self.spec.frequency_postures, n), np.nan)
            rows["frequency_error"] = np.full(n, np.nan)
        return rows

    def _fill(self, rows: Rows, numbers: NDArray[np.intp], closing: Closing) -> None:
        homes = closing.homes()
        for i, reason in zip(numbers, homes.reasons, strict=True):
            if reason:
                _refuse(rows, i, GeometryStatus.NOT_ASSEMBLED, reason)
        assembled = np.array([not reason for reason in homes.reasons])
        postures = self.family.frequency_postures
        vibrating: list[_Few] = []
        for block in self._blocks(closing, homes, np.flatnonzero(assembled)):
            ok = self._reduce(rows, numbers, closing, block)
            vibrating.append(_Few(block.which, block.q[:, :, postures], ok[:, postures]))
        if self.frequencies is not None and vibrating:
            few = _Few(
                np.concatenate([f.which for f in vibrating]),
                np.concatenate([f.q for f in vibrating], axis=1),
                np.concatenate([f.ok for f in vibrating]),
            )
            self._vibrate(self.frequencies, rows, numbers, closing, few)

    def _blocks(
        self, closing: Closing, homes: Homes, assembled: NDArray[np.intp]
    ) -> Iterator[_Block]:
        size = max(1, _TOGETHER // self.family.n_postures)
        for start in range(0, assembled.size, size):
            which = assembled[start : start + size]
            q, reached = closing.postures(which, homes)
            inside = np.stack([closing.geometries[i].inside for i in which])
            few = max(1, _REDUCED // self.family.n_postures)
            for first in range(0, which.size, few):
                part = slice(first, first + few)
                yield _Block(which[part], q[:, part], reached[part], inside[part])

    def _reduce(
        self, rows: Rows, numbers: NDArray[np.intp], closing: Closing, block: _Block
    ) -> Mask:
        """Fill in the statistics, and return where the refined model has an answer (B, P)."""
        own = [closing.geometries[i] for i in block.which]
        at = numbers[block.which]
        refined_ok = block.reached
        for m, model in enumerate(closing.group.models):
            lower, ok = compliances(closing.group, model, own, block.q, block.reached)
            refined_ok = ok if model.model == "refined" else refined_ok
            rows["postures_ok"][m, at] = ok.sum(axis=1)
            rows["postures_unreachable"][m, at] = (block.inside & ~block.reached).sum(axis=1)
            rows["postures_singular"][m, at] = (block.reached & ~ok).sum(axis=1)
            quantities = _Quantities(lower, own)
            for column in self.spec.columns:
                if column.quantity == "frequency_first":
                    continue
                result, place = reduce(column, quantities.of(column))
                rows[column.name][m, at] = result
                if column.has_place:
                    rows[f"{column.name}_at"][m][:, at] = poses_at(own, place)
        return refined_ok

    def _vibrate(
        self,
        frequencies: LowestFrequencies,
        rows: Rows,
        numbers: NDArray[np.intp],
        closing: Closing,
        few: _Few,
    ) -> None:
        """Fill in the lowest frequencies and their statistics."""
        own = [closing.geometries[i] for i in few.which]
        postures, at = self.family.frequency_postures, numbers[few.which]
        found = frequencies.at(closing.group, own, few.q, few.ok)
        rows["frequency_first"][:, at] = found.lowest.T
        rows["frequency_error"][at] = np.fmax.reduce(found.error, axis=1)
        for i, reason in zip(at, found.reasons, strict=True):
            if reason:
                rows["reason"][i] = f"no frequencies: {reason}"[:_LONGEST_REASON]
        refined = self.spec.models.index("refined")
        for column in self.spec.columns:
            if column.quantity == "frequency_first":
                result, place = reduce(column, found.lowest)
                rows[column.name][refined, at] = result
                if column.has_place:
                    where = np.where(place >= 0, postures[place], -1)
                    rows[f"{column.name}_at"][refined][:, at] = poses_at(own, where)


class _Quantities:
    """The quantities of a block, each computed once."""

    def __init__(self, lower: Array, geometries: Sequence[Geometry]) -> None:
        self.lower = lower
        self.geometries = geometries
        self._known: dict[tuple[str, str | None], Array] = {}
        self._deflections: dict[str, Array] = {}

    def of(self, column: Column) -> Array:
        """Return the quantity of a column, (B, P)."""
        key = (column.quantity, column.load)
        if key not in self._known:
            quantity = QUANTITIES[column.quantity]
            source = self._deflection(str(column.load)) if quantity.per_load else self.lower
            self._known[key] = quantity.of(source)
        return self._known[key]

    def _deflection(self, load: str) -> Array:
        if load not in self._deflections:
            found = [
                deflection(self.lower[:, i], geometry.robot.loads[load].wrench)
                for i, geometry in enumerate(self.geometries)
            ]
            self._deflections[load] = np.stack(found, axis=1)
        return self._deflections[load]


def compliances(
    group: Group,
    model: CompliancesOfModel,
    geometries: Sequence[Geometry],
    q: Array,
    reached: Mask,
) -> tuple[Array, Mask]:
    """Return compliances (21, B, P), SI, and where there is an answer (B, P).

    ``q`` (n, B, P) are unknowns of the closure. What is singular, or not reached, is NaN.
    """
    q = q[: group.tree.n_coordinates]
    if model.function is None:
        return _assembled(group, model, geometries, q, reached)
    constants = np.stack([group.constants_of(model, g) for g in geometries], axis=1)
    number = np.repeat(np.arange(len(geometries)), q.shape[2])
    out = model.function.at(constants, number)(q.reshape(q.shape[0], -1)).reshape(
        -1, *reached.shape
    )
    lower, measure = out[:21], out[21]
    with np.errstate(invalid="ignore"):
        regular = (
            measure > ZERO_SHARE if model.method == "composition" else measure < 1 / ZERO_SHARE
        )
    ok = reached & regular & np.isfinite(lower).all(axis=0)
    lower[:, ~ok] = np.nan
    return lower, ok


def _assembled(
    group: Group,
    model: CompliancesOfModel,
    geometries: Sequence[Geometry],
    q: Array,
    reached: Mask,
) -> tuple[Array, Mask]:
    lower = np.full((21, *reached.shape), np.nan)
    for b, geometry in enumerate(geometries):
        tree = SpanningTree.of(geometry.robot)
        assembly = Assembly(tree, geometry.length, model.model, backend=group.backend)
        at = np.flatnonzero(reached[b])
        for i, found in zip(at, assembly.at_each(q[:, b, at]), strict=True):
            if found.compliance is not None:
                lower[:, b, i] = lower_triangles(found.compliance)
    return lower, np.isfinite(lower[0])


def poses_at(geometries: Sequence[Geometry], place: NDArray[np.intp]) -> Array:
    """Return the tool coordinates (s, B) that are swept at one posture of each; NaN at -1."""
    found = np.array([g.poses[:, i] for g, i in zip(geometries, place, strict=True)]).T
    return np.where(place >= 0, found, np.nan)


def _refuse(rows: Rows, i: int, status: GeometryStatus, reason: str) -> None:
    rows["geometry_status"][i] = status
    rows["reason"][i] = reason
