"""Following an assembly mode: from a posture that is known to another tool pose.

The unknowns are continued along the straight line between two sets of tool coordinates. A piece of
the line is accepted only if Newton's method contracts on it from a small first correction without
passing a posture where branches meet, and is halved otherwise; so a posture beyond the reach of the
assembly mode ends as not found rather than on another branch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import over_blocks
from stiffkit.kinematics.nearest import Nearest, nearest_few

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

CLOSED = 1e-10
"""Largest residual of a closed posture: gaps over the robot's size, and radians."""

FIRST_CORRECTION = 0.35
"""Largest first correction, rad or robot sizes (root of the sum of squares)."""
_LARGEST_TURN = 1.0
"""Largest rotation of the tool in one piece, rad: half a turn would look like none."""
CONTRACTION = 0.7
"""Each correction is at most this share of the one before; at a reach limit it tends to 1/2."""
_SAME_BRANCH = 0.5
"""Smallest cosine between the responses to a disturbance at both ends of a piece. A sign that flips
in between is all that tells of a passage through a singular posture, where Newton's method steps
from one branch to the other as if nothing were there."""
SETTLED = 1e-9
"""Corrections below this need not contract any more: rounding is near."""
STEPS = 5
"""Newton steps that a posture usually takes."""
BLOCK = 1 << 13
"""Postures that are followed together: what they need then stays in the cache."""
_FULL = 0.5
"""Share of the postures in work that must still be on their way; below it the others are left."""
_ITERATIONS = 8
_POLISH = 40
SMALLEST_PIECE = 1.0 / 256.0
_ANCHORS = 512
"""Poses that are reached straight from home, before all others."""
_WAYPOINTS = 600
_MOST_DIMENSIONS = 3
"""Number of tool coordinates up to which waypoints lie close enough together to be of use."""
_PIECES = 4
"""Pieces that the ways to them are cut into, roughly: many end at limits of reach."""
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

    step: Callable[[Array], Array]
    """The kernel of `ClosureEquations.newton_step`."""
    n: int
    """Number of unknowns."""
    turns: Mask
    """(m,), which of the tool coordinates asked for are rotations."""
    smallest_piece: float = SMALLEST_PIECE
    """Share of the way to an end below which a piece is not halved any more."""

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
            begin, towards = _columns(start, active), _columns(end, active)
            found, accepted, slow = self._correct(
                _columns(q, active), begin + s * (towards - begin)
            )
            accepted &= ~slow | (s >= 1.0)
            at_limit[active] = slow
            moved = active[accepted]
            _put(q, moved, _columns(found, np.flatnonzero(accepted)))
            done[moved] = s[accepted]
            piece[moved] *= 2.0
            piece[active[~accepted]] *= 0.5
            active = active[(done[active] < 1.0) & (piece[active] >= self.smallest_piece)]
        q, closed = self._polish(q, end, done >= 1.0)
        return Followed(q, closed, at_limit)

    def _correct(self, q: Array, target: Array) -> tuple[Array, Mask, Mask]:
        """Run Newton's method, and tell where it contracted on one branch, and where slowly."""
        n, n_postures = q.shape
        x = np.concatenate([q, target])
        found = np.empty_like(q)
        accepted, slow = np.zeros((2, n_postures), dtype=bool)
        here = np.arange(n_postures)  # the postures that are the columns of x
        going = np.ones(n_postures, dtype=bool)
        limit = np.full(n_postures, FIRST_CORRECTION)
        first = response = np.empty((n, 0))
        for iteration in range(_ITERATIONS):
            improved, residual, size, response = self._newton(x)
            if iteration == 0:
                first = response
            going &= (size <= np.maximum(limit, SETTLED)) & np.isfinite(residual)
            settled = going & (size <= SETTLED)
            x[:n] = improved
            limit = CONTRACTION * size
            if settled.any():
                accepted[here[settled & same_branch(first, response)]] = True
                going &= ~settled
            left = np.count_nonzero(going)
            if left == 0:
                break
            # A further step does no harm to what has settled, and costs less than moving the rest.
            if left < _FULL * going.size:
                _put(found, here, x[:n])
                stay = np.flatnonzero(going)
                x, first, response = (np.take(A, stay, axis=1) for A in (x, first, response))
                here, going, limit = here[stay], going[stay], limit[stay]
        else:
            # Slow but steady: towards a limit of reach Newton's method gains a bit per step.
            slow[here[going]] = True
            accepted[here[going & same_branch(first, response)]] = True
        _put(found, here, x[:n])
        return found, accepted, slow

    def _polish(self, q: Array, asked: Array, reached: Mask) -> tuple[Array, Mask]:
        closed = np.zeros(q.shape[1], dtype=bool)
        active = np.flatnonzero(reached)
        for _ in range(_POLISH):
            if active.size == 0:
                break
            x = np.concatenate([_columns(q, active), _columns(asked, active)])
            improved, residual, size, _ = self._newton(x)
            closed[active] = residual <= CLOSED
            _put(q, active, improved)
            active = active[(size > 1e-14) & ((residual > 1e-15) | (size > SETTLED))]
        q[:, ~closed] = np.nan
        return q, closed

    def _newton(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """Return improved unknowns, sizes of residual and step, and the response."""
        out = self.step(x)
        n = self.n
        return out[:n], np.sqrt(out[n]), np.sqrt(out[n + 1]), out[n + 2 :]

    def spread(
        self,
        q_home: Array,
        home: Array,
        asked: Array,
        span: Array,
        detours: Callable[[int], Tracker] | None = None,
    ) -> tuple[Array, Mask]:
        """Reach many tool poses ``asked`` (m, N) from one known posture.

        Return the unknowns, NaN where a pose was not reached, and where it was. ``span`` (m,) makes
        distances comparable. ``detours`` gives a tracker for so many poses, far more than may be
        asked for; without it only ways between these poses are tried.
        """
        spread = _Spread(self, asked, span)
        spread.explore(q_home, home)
        if detours is not None and spread.missing.size and 0 < home.size <= _MOST_DIMENSIONS:
            # Holes may bar all ways between the poses asked for, and leave others around them.
            around = _Spread(detours(_PIECES * _WAYPOINTS), _waypoints(home, asked, span), span)
            around.explore(q_home, home)
            spread.enter_from(around)
        return spread.q, spread.reached


@dataclass(frozen=True, eq=False)
class _Known:
    """Postures that others can be reached from."""

    q: Array
    """(n, N), unknowns."""
    asked: Array
    """(m, N), tool coordinates."""


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
        missing = self.missing
        few = min(_ANCHORS, missing.size)
        rng = np.random.default_rng(0)
        return np.sort(rng.choice(missing, few, replace=False, shuffle=False))

    def explore(self, q_home: Array, home: Array) -> None:
        """Reach a few poses from home, the rest from the nearest one, and then from neighbours."""
        at_home = _Known(q_home, home[:, None])
        first = self.some_missing()
        self.extend_from(at_home, first, np.zeros_like(first))
        if not self.leads_on.any():
            missing = self.missing
            self.extend_from(at_home, missing, np.zeros_like(missing))
        if self.leads_on.any() and self.missing.size:
            self.extend_from_nearest(np.flatnonzero(self.leads_on))
            self.grow(np.flatnonzero(self.leads_on))

    def extend_from_nearest(self, sources: Indices) -> None:
        """Try to reach whatever is missing, from the nearest one of some poses reached."""
        known, missing = _Known(self.q, self.asked), self.missing
        nearest = Nearest(self.scaled[sources], self.scaled)

        def work(block: slice) -> None:
            targets = missing[block]
            self.follow(known, targets, sources[nearest.of(self.scaled[targets])])

        over_blocks(missing.size, BLOCK, work)

    def enter_from(self, other: _Spread) -> None:
        """Reach a few poses from the nearest ones of another set, and the rest from these."""
        targets, known = self.some_missing(), np.flatnonzero(other.leads_on)
        if known.size == 0:
            return
        nearest = nearest_few(other.scaled[known], self.scaled[targets], _NEIGHBOURS)
        for column in nearest.T:
            still = ~self.reached[targets]
            there = _Known(other.q, other.asked)
            self.extend_from(there, targets[still], known[column[still]])
        self.grow(targets[self.leads_on[targets]])

    def extend_from(self, known: _Known, targets: Indices, sources: Indices) -> None:
        """Try to reach some poses, each from one that is known."""
        over_blocks(targets.size, BLOCK, lambda b: self.follow(known, targets[b], sources[b]))

    def follow(self, known: _Known, targets: Indices, sources: Indices) -> None:
        start = np.take(known.q, sources, axis=1), np.take(known.asked, sources, axis=1)
        found = self.tracker.follow(*start, _columns(self.asked, targets))
        _put(self.q, targets, found.q)
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
                here = _Known(self.q, self.asked)
                self.extend_from(here, missing[near], sources[nearest[near, j]])
            # What was reached already has been tried; only the new layer can lead further.
            sources = missing[self.leads_on[missing]]


def _waypoints(home: Array, asked: Array, span: Array) -> Array:
    """Return poses (m, n) all around home and the poses asked for."""
    ends = np.hstack([home[:, None], asked])
    low, high = ends.min(axis=1), ends.max(axis=1)
    margin = 0.5 * np.maximum(high - low, 0.2 * span)
    rng = np.random.default_rng(0)
    return np.asarray(rng.uniform(low - margin, high + margin, (_WAYPOINTS, home.size)).T)


def _columns(A: Array, which: Indices) -> Array:
    """Return some columns of A; A itself where these are all of them, one after the other."""
    return A if which.size == A.shape[1] else np.take(A, which, axis=1)


def _put(A: Array, which: Indices, columns: Array) -> None:
    """Replace some columns of A, which are given in their order."""
    if which.size == A.shape[1]:
        A[:] = columns
    else:
        # Row by row, which NumPy does twice as fast as all rows at once.
        for row, values in zip(A, columns, strict=True):
            row[which] = values


def same_branch(first: Array, last: Array) -> Mask:
    """Tell whether responses (n, N) at both ends of a piece point the same way."""
    sizes = np.sqrt(_dots(first, first) * _dots(last, last))
    return np.asarray(_dots(first, last) > _SAME_BRANCH * sizes)


def _dots(A: Array, B: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->j", A, B))


def _typical_spacing(points: Array) -> float:
    """Return the median distance to the nearest other point, of a few of the points (N, m)."""
    nearest = []
    for sample in points[:: 1 + len(points) // 8]:
        squared = np.sum((points - sample) ** 2, axis=1)
        apart = squared[squared > 0.0]
        nearest.append(np.sqrt(apart.min()) if apart.size else 0.0)
    return float(np.median(nearest))
