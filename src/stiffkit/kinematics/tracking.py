"""Following an assembly mode: from a posture that is known to another tool pose.

The unknowns are continued along the straight line between two sets of tool coordinates. A piece of
the line is accepted only if Newton's method contracts on it from a small first correction without
passing a posture where branches meet, and is halved otherwise; so a posture beyond the reach of the
assembly mode ends as not found rather than on another branch.
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
_SAME_BRANCH = 0.5
"""Smallest cosine between the responses to a disturbance at both ends of a piece. A sign that flips
in between is all that tells of a passage through a singular posture, where Newton's method steps
from one branch to the other as if nothing were there."""
_SETTLED = 1e-9
"""Corrections below this need not contract any more: rounding is near."""
_ITERATIONS = 8
_POLISH = 40
_SMALLEST_PIECE = 1.0 / 256.0
_ANCHORS = 512
"""Poses that are reached straight from home, before all others."""
_WAYPOINTS = 600
_MOST_DIMENSIONS = 3
"""Number of tool coordinates up to which waypoints lie close enough together to be of use."""
_NEIGHBOURS = 6
_LAYER = 3.0
"""Distance at which a pose has neighbours, over the typical distance between poses."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Where an assembly mode led."""

    q: Array
    """(n, N), unknowns, NaN where the end was not reached."""
    reached: Mask
    """(N,)."""
    at_limit: Mask
    """(N,), where the posture is so close to a limit of reach that branches meet, and none can be
    followed from there."""


@dataclass
class Tracker:
    """Newton steps of one mechanism, batched."""

    step: BatchFunction
    n: int
    """Number of unknowns."""
    turns: Mask
    """(m,), which of the tool coordinates asked for are rotations."""

    def _newton(self, q: Array, asked: Array) -> tuple[Array, Array, Array, Array]:
        out = self.step(np.concatenate([q, asked]))
        n = self.n
        return out[:n], np.sqrt(out[n]), np.sqrt(out[n + 1]), out[n + 2 :]

    def follow(self, q: Array, start: Array, end: Array) -> Followed:
        """Continue postures ``q`` (n, N) at tool coordinates ``start`` (m, N) to ``end`` (m, N)."""
        q = q.copy()
        n_postures = q.shape[1]
        done, piece = np.zeros(n_postures), np.ones(n_postures)
        turn = np.sqrt(np.sum((end - start)[self.turns] ** 2, axis=0))
        largest = _LARGEST_TURN / np.maximum(turn, _LARGEST_TURN)
        at_limit = np.zeros(n_postures, dtype=bool)
        active = np.arange(n_postures)
        while active.size:
            s = np.minimum(done[active] + np.minimum(piece, largest)[active], 1.0)
            target = start[:, active] + s * (end[:, active] - start[:, active])
            found, accepted, slow = self._correct(q[:, active], target)
            accepted &= ~slow | (s >= 1.0)
            at_limit[active] = slow
            moved = active[accepted]
            q[:, moved] = found[:, accepted]
            done[moved] = s[accepted]
            piece[moved] *= 2.0
            piece[active[~accepted]] *= 0.5
            active = active[(done[active] < 1.0) & (piece[active] >= _SMALLEST_PIECE)]
        q, closed = self._polish(q, end, done >= 1.0)
        return Followed(q, closed, at_limit)

    def _correct(self, q: Array, target: Array) -> tuple[Array, Mask, Mask]:
        """Run Newton's method, and tell where it contracted on one branch, and where slowly."""
        result = q.copy()
        accepted, slow = np.zeros((2, q.shape[1]), dtype=bool)
        active = np.arange(q.shape[1])
        limit = np.full(q.shape[1], _FIRST_CORRECTION)
        first = last = np.empty((self.n, 0))
        for iteration in range(_ITERATIONS):
            improved, residual, size, response = self._newton(result[:, active], target[:, active])
            if iteration == 0:
                first, last = response, response.copy()
            last[:, active] = response
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
            accepted[active] = slow[active] = True
        return result, accepted & _same_branch(first, last), slow

    def _polish(self, q: Array, asked: Array, reached: Mask) -> tuple[Array, Mask]:
        closed = np.zeros(q.shape[1], dtype=bool)
        active = np.flatnonzero(reached)
        for _ in range(_POLISH):
            if active.size == 0:
                break
            improved, residual, size, _ = self._newton(q[:, active], asked[:, active])
            closed[active] = residual <= CLOSED
            q[:, active] = improved
            active = active[(size > 1e-14) & ((residual > 1e-15) | (size > _SETTLED))]
        q[:, ~closed] = np.nan
        return q, closed

    def spread(self, q_home: Array, home: Array, asked: Array, span: Array) -> tuple[Array, Mask]:
        """Reach many tool poses ``asked`` (m, N) from one known posture.

        Return the unknowns, NaN where a pose was not reached, and where it was. ``span`` (m,) makes
        distances comparable.
        """
        spread = _Spread(self, asked, span)
        spread.explore(q_home, home)
        if spread.missing.size and 0 < home.size <= _MOST_DIMENSIONS:
            # Holes may bar all ways between the poses asked for, and leave others around them.
            around = _Spread(self, _waypoints(home, asked, span), span)
            around.explore(q_home, home)
            spread.enter_from(around)
        return spread.q, spread.reached


class _Spread:
    """Postures that are being reached from each other."""

    def __init__(self, tracker: Tracker, asked: Array, span: Array) -> None:
        """Take tool poses (m, N), and what makes distances between them comparable (m,)."""
        n_postures = asked.shape[1]
        self.tracker = tracker
        self.asked = asked
        self.scaled = (asked / span[:, None]).T
        self.q = np.full((tracker.n, n_postures), np.nan)
        self.reached = np.zeros(n_postures, dtype=bool)
        self.leads_on = np.zeros(n_postures, dtype=bool)
        """Where others can be reached from: not at a limit of reach."""

    @property
    def missing(self) -> Indices:
        return np.flatnonzero(~self.reached)

    def some_missing(self) -> Indices:
        """Return a few of the poses that are missing, evenly picked."""
        return np.sort(np.random.default_rng(0).permutation(self.missing)[:_ANCHORS])

    def explore(self, q_home: Array, home: Array) -> None:
        """Reach a few poses from home, the rest from the nearest one, and then from neighbours."""
        first = self.some_missing()
        self.extend_from(first, np.repeat(q_home, first.size, axis=1), home[:, None])
        if not self.leads_on.any():
            missing = self.missing
            self.extend_from(missing, np.repeat(q_home, missing.size, axis=1), home[:, None])
        if self.leads_on.any() and self.missing.size:
            (nearest,) = _nearest(self.scaled[self.leads_on], self.scaled[self.missing], 1).T
            self.extend(self.missing, np.flatnonzero(self.leads_on)[nearest])
            self.grow(np.flatnonzero(self.leads_on))

    def enter_from(self, other: _Spread) -> None:
        """Reach a few poses from the nearest ones of another set, and the rest from these."""
        targets, known = self.some_missing(), np.flatnonzero(other.leads_on)
        if known.size == 0:
            return
        nearest = _nearest(other.scaled[known], self.scaled[targets], _NEIGHBOURS)
        for column in nearest.T:
            still = ~self.reached[targets]
            sources = known[column[still]]
            self.extend_from(targets[still], other.q[:, sources], other.asked[:, sources])
        self.grow(targets[self.leads_on[targets]])

    def extend(self, targets: Indices, sources: Indices) -> None:
        """Try to reach some poses, each from one that was reached."""
        self.extend_from(targets, self.q[:, sources], self.asked[:, sources])

    def extend_from(self, targets: Indices, q: Array, start: Array) -> None:
        end = self.asked[:, targets]
        found = self.tracker.follow(q, np.broadcast_to(start, end.shape), end)
        self.q[:, targets] = found.q
        self.reached[targets] = found.reached
        self.leads_on[targets] = found.reached & ~found.at_limit

    def grow(self, sources: Indices) -> None:
        """Reach poses from neighbours among the sources, and then from those, layer by layer."""
        from scipy.spatial import cKDTree

        if not (sources.size and self.missing.size):
            return
        layer = _LAYER * _typical_spacing(self.scaled)
        while sources.size and self.missing.size:
            missing = self.missing
            tree = cKDTree(self.scaled[sources], balanced_tree=False, compact_nodes=False)
            distance, nearest = tree.query(
                self.scaled[missing], k=list(range(1, 1 + _NEIGHBOURS)), distance_upper_bound=layer
            )
            for j in range(_NEIGHBOURS):
                near = np.isfinite(distance[:, j]) & ~self.reached[missing]
                self.extend(missing[near], sources[nearest[near, j]])
            # What was reached already has been tried; only the new layer can lead further.
            sources = missing[self.leads_on[missing]]


def _waypoints(home: Array, asked: Array, span: Array) -> Array:
    """Return poses (m, n) all around home and the poses asked for."""
    ends = np.hstack([home[:, None], asked])
    low, high = ends.min(axis=1), ends.max(axis=1)
    margin = 0.5 * np.maximum(high - low, 0.2 * span)
    rng = np.random.default_rng(0)
    return np.asarray(rng.uniform(low - margin, high + margin, (_WAYPOINTS, home.size)).T)


def _nearest(points: Array, queries: Array, k: int) -> Indices:
    """Return for each query (M, m) which of the points (N, m) are the k nearest ones (M, k)."""
    from scipy.spatial import cKDTree

    k = min(k, len(points))
    _, nearest = cKDTree(points).query(queries, k=list(range(1, 1 + k)))
    return np.asarray(nearest).reshape(len(queries), k)


def _same_branch(first: Array, last: Array) -> Mask:
    """Tell whether responses (n, N) at both ends of a piece point the same way."""
    sizes = np.sqrt(np.sum(first**2, axis=0) * np.sum(last**2, axis=0))
    return np.asarray(np.sum(first * last, axis=0) > _SAME_BRANCH * sizes)


def _typical_spacing(points: Array) -> float:
    """Return the median distance to the nearest other point, of a few of the points (N, m)."""
    nearest = []
    for sample in points[:: 1 + len(points) // 8]:
        squared = np.sum((points - sample) ** 2, axis=1)
        apart = squared[squared > 0.0]
        nearest.append(np.sqrt(apart.min()) if apart.size else 0.0)
    return float(np.median(nearest))
