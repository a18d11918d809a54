"""Following an assembly mode: from a posture that is known to another tool pose.

The unknowns are continued along the straight line between two sets of tool coordinates. A piece of
the line is accepted only if Newton's method contracts on it from a small first correction, and is
halved otherwise; so a posture beyond the reach of the assembly mode ends as not found rather than
on another branch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import BatchFunction

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

CLOSED = 1e-10
"""Largest residual of a closed posture: gaps over the robot's size, and radians."""

_FIRST_CORRECTION = 0.35
"""Largest first correction, rad or robot sizes (root of the sum of squares)."""
_LARGEST_TURN = 1.0
"""Largest rotation of the tool in one piece, rad: half a turn would look like none."""
_CONTRACTION = 0.7
"""Each correction is at most this share of the one before; at a reach limit it tends to 1/2."""
_SETTLED = 1e-9
"""Corrections below this need not contract any more: rounding is near."""
_ITERATIONS = 8
_POLISH = 40
_SMALLEST_PIECE = 1.0 / 256.0
_ANCHORS = 512
_NEIGHBOURS = 6
_LAYER = 3.0
"""Distance at which a pose has neighbours, over the typical distance between poses."""


@dataclass
class Tracker:
    """Newton steps of one mechanism, batched."""

    step: BatchFunction
    n: int
    """Number of unknowns."""
    turns: Mask
    """(m,), which of the tool coordinates asked for are rotations."""

    def _newton(self, q: Array, asked: Array) -> tuple[Array, Array, Array]:
        out = self.step(np.concatenate([q, asked]))
        return out[: self.n], np.sqrt(out[self.n]), np.sqrt(out[self.n + 1])

    def follow(self, q: Array, start: Array, end: Array) -> tuple[Array, Mask]:
        """Continue postures ``q`` (n, N) at tool coordinates ``start`` (m, N) to ``end`` (m, N).

        Return the unknowns at the end, NaN where it was not reached, and where it was.
        """
        q = q.copy()
        n_postures = q.shape[1]
        done, piece = np.zeros(n_postures), np.ones(n_postures)
        turn = np.sqrt(np.sum((end - start)[self.turns] ** 2, axis=0))
        largest = _LARGEST_TURN / np.maximum(turn, _LARGEST_TURN)
        active = np.arange(n_postures)
        while active.size:
            s = np.minimum(done[active] + np.minimum(piece, largest)[active], 1.0)
            target = start[:, active] + s * (end[:, active] - start[:, active])
            found, accepted = self._correct(q[:, active], target)
            moved = active[accepted]
            q[:, moved] = found[:, accepted]
            done[moved] = s[accepted]
            piece[moved] *= 2.0
            piece[active[~accepted]] *= 0.5
            active = active[(done[active] < 1.0) & (piece[active] >= _SMALLEST_PIECE)]
        return self._polish(q, end, done >= 1.0)

    def _correct(self, q: Array, target: Array) -> tuple[Array, Mask]:
        """Run Newton's method and tell where it contracted to a closed posture."""
        result = q.copy()
        accepted = np.zeros(q.shape[1], dtype=bool)
        active = np.arange(q.shape[1])
        limit = np.full(q.shape[1], _FIRST_CORRECTION)
        for _ in range(_ITERATIONS):
            improved, residual, size = self._newton(result[:, active], target[:, active])
            good = (size <= np.maximum(limit[active], _SETTLED)) & np.isfinite(residual)
            settled = good & (size <= _SETTLED)
            keep = active[good]
            result[:, keep] = improved[:, good]
            limit[keep] = _CONTRACTION * size[good]
            accepted[active[settled]] = True
            active = active[good & ~settled]
            if active.size == 0:
                break
        else:
            # Slow but steady: towards a limit of reach Newton's method gains a bit per step.
            accepted[active] = True
        return result, accepted

    def _polish(self, q: Array, asked: Array, reached: Mask) -> tuple[Array, Mask]:
        closed = np.zeros(q.shape[1], dtype=bool)
        active = np.flatnonzero(reached)
        for _ in range(_POLISH):
            if active.size == 0:
                break
            improved, residual, size = self._newton(q[:, active], asked[:, active])
            closed[active] = residual <= CLOSED
            q[:, active] = improved
            active = active[(size > 1e-14) & ((residual > 1e-15) | (size > _SETTLED))]
        q[:, ~closed] = np.nan
        return q, closed

    def spread(self, q_home: Array, home: Array, asked: Array, span: Array) -> tuple[Array, Mask]:
        """Reach many tool poses ``asked`` (m, N) from one known posture.

        A few of them are reached from home and the rest from the nearest one reached; poses at the
        edge of what was reached are then tried from their neighbours until nothing is gained.
        ``span`` (m,) makes distances comparable.
        """
        from scipy.spatial import cKDTree

        n_postures = asked.shape[1]
        spread = _Spread(self, asked, np.full((self.n, n_postures), np.nan))
        first = np.sort(np.random.default_rng(0).permutation(n_postures)[:_ANCHORS])
        spread.extend_from(first, np.repeat(q_home, first.size, axis=1), home[:, None])
        missing = spread.missing
        if missing.size == 0:
            return spread.q, spread.reached
        scaled = (asked / span[:, None]).T
        if not spread.reached.any():
            spread.extend_from(missing, np.repeat(q_home, missing.size, axis=1), home[:, None])
        else:
            known = np.flatnonzero(spread.reached)
            _, nearest = cKDTree(scaled[known]).query(scaled[missing])
            spread.extend(missing, known[nearest])
        spread.grow(scaled)
        return spread.q, spread.reached


@dataclass
class _Spread:
    """Postures that are being reached from each other."""

    tracker: Tracker
    asked: Array
    q: Array

    def __post_init__(self) -> None:
        self.reached = np.zeros(self.asked.shape[1], dtype=bool)

    @property
    def missing(self) -> Indices:
        return np.flatnonzero(~self.reached)

    def extend(self, targets: Indices, sources: Indices) -> None:
        """Try to reach some poses, each from one that was reached."""
        self.extend_from(targets, self.q[:, sources], self.asked[:, sources])

    def extend_from(self, targets: Indices, q: Array, start: Array) -> None:
        end = self.asked[:, targets]
        found, ok = self.tracker.follow(q, np.broadcast_to(start, end.shape), end)
        self.q[:, targets] = found
        self.reached[targets] = ok

    def grow(self, scaled: Array) -> None:
        """Reach poses from their neighbours, layer by layer."""
        if self.reached.all() or not self.reached.any():
            return
        from scipy.spatial import cKDTree

        layer = _LAYER * _typical_spacing(scaled)
        sources = np.flatnonzero(self.reached)
        while sources.size and self.missing.size:
            missing = self.missing
            tree = cKDTree(scaled[sources], balanced_tree=False, compact_nodes=False)
            distance, nearest = tree.query(
                scaled[missing], k=list(range(1, 1 + _NEIGHBOURS)), distance_upper_bound=layer
            )
            for j in range(_NEIGHBOURS):
                near = np.isfinite(distance[:, j]) & ~self.reached[missing]
                self.extend(missing[near], sources[nearest[near, j]])
            # What was reached already has been tried; only the new layer can lead further.
            sources = missing[self.reached[missing]]


def _typical_spacing(points: Array) -> float:
    """Return the median distance to the nearest other point, of a few of the points (N, m)."""
    nearest = []
    for sample in points[:: 1 + len(points) // 8]:
        squared = np.sum((points - sample) ** 2, axis=1)
        apart = squared[squared > 0.0]
        nearest.append(np.sqrt(apart.min()) if apart.size else 0.0)
    return float(np.median(nearest))
