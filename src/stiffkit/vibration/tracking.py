"""Following modes from posture to posture by their shapes, so that "mode 2" stays one mode.

Sorted by frequency, two modes change places where their frequencies cross, and keep them where the
frequencies come close and turn away from each other. Which of the two happens is told by the shapes
alone: of neighbouring postures, those modes belong together whose vectors overlap most (the modal
assurance criterion; R. J. Allemang, "The modal assurance criterion: twenty years of use and abuse",
Sound and Vibration 37(8), 2003). Postures are visited from a start along a spanning tree of the
surest pairs of neighbours, so that a doubtful pair is passed only where no way leads around it.

Modes of equal frequency have no shapes of their own, any mixture of them is a mode. They are
compared by the subspace that they span, and what lies around such a posture is compared directly.

Where two modes of one kind meet in a single point of a plane, each turns into the other on a round
trip about that point (M. V. Berry, M. Wilkinson, "Diabolical points in the spectra of triangles",
Proc. R. Soc. Lond. A 392, 1984), and no numbering is free of jumps. Pairs that keep the order of
the frequencies go first then, which leaves the jumps where the two frequencies are close.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

LOST = 0.5
"""A mode whose best overlap is smaller has left the modes that were computed."""

_EQUAL = 1e-4
"""Frequencies as near as this, over the frequency, are equal: no model tells them apart better."""
_CLOSE = 1e-2
"""Frequencies as near as this may mix, so that the posture says little on which is which."""
_CROSSING = 0.1
"""Overlap by which pairs that keep the order of the frequencies go before those that do not."""
_ROUNDING = 6
"""Decimals of an overlap that decide which pair is surer, the same ones on every machine."""
_BLOCK = 1 << 13
"""Pairs at a time: what is computed of them then stays in the cache."""


@dataclass(frozen=True, eq=False)
class ModeVectors:
    """The lowest modes of N postures, in coordinates in which postures can be compared."""

    frequencies: Array
    """(m, N), Hz, ascending; NaN where there is no such mode."""
    vectors: NDArray[np.floating]
    """(N, m, r), orthonormal in each posture but for what r coordinates leave out; zero where there
    is no such mode. Signs are arbitrary."""

    def part(self, postures: Indices) -> ModeVectors:
        """Return the modes of some of the postures."""
        return ModeVectors(self.frequencies[:, postures], self.vectors[postures])


@dataclass(frozen=True, eq=False)
class Branches:
    """The modes of each posture, numbered as they continue those of the start."""

    modes: NDArray[np.intp]
    """(n, N): which of the computed modes, from 0, belongs to each branch; -1 where the branch has
    left them."""
    overlaps: Array
    """(n, N), 0 to 1: the smallest overlap on the way from the start; NaN where there is none."""
    start: int
    """The posture at which branch k is mode k, and frequencies differ if there is such a one."""
    pairs: int
    """Number of pairs of neighbours."""
    jumps: int
    """Number of those across which a branch is not continued by the mode that resembles it most,
    without those in which modes have equal frequencies."""

    @property
    def lowest_overlap(self) -> float:
        """The smallest overlap by which any branch was continued; 1 if there was none to make."""
        known = self.overlaps[np.isfinite(self.overlaps)]
        return float(known.min()) if known.size else 1.0

    def of(self, values: Array) -> Array:
        """Return values (m, N) of the modes as those of the branches (n, N), NaN where lost."""
        taken = np.take_along_axis(values, np.maximum(self.modes, 0), axis=0)
        return np.where(self.modes < 0, np.nan, taken)


def track_modes(modes: ModeVectors, pairs: Indices, start: int, n: int) -> Branches:
    """Return the branches of the lowest ``n`` modes of a start.

    Args:
        modes: of N postures, some more of them than n, for branches that rise.
        pairs: (E, 2), neighbouring postures; those that are not connected to the start stay
            without branches.
        start: posture at which branch k is mode k; the nearest one to it where that one has modes
            of equal frequency, which have no order.
        n: how many branches.
    """
    n = min(n, modes.frequencies.shape[0])
    n_postures = modes.frequencies.shape[1]
    graph = _unique(pairs, n_postures)
    start = _distinct(graph, modes.frequencies, start, n)
    bridges = _bridges(graph, modes.frequencies, n)
    compared = _compare(modes, np.concatenate([graph, bridges]), n)
    step, overlap, before = _steps(compared, start, n_postures)
    exists = np.isfinite(modes.frequencies[:, start])
    mode, lowest = _from_start(step, overlap, before, start, exists)
    lost = modes.frequencies.shape[0]
    mode = np.where(mode == lost, -1, mode).T[:n]
    overlaps = np.where(mode < 0, np.nan, lowest.T[:n])
    jumps = _jumps(compared, mode, len(graph), modes.frequencies)
    return Branches(mode, overlaps, start, len(graph), jumps)


@dataclass(frozen=True, eq=False)
class _Compared:
    """Pairs of postures a, b, and how their modes belong together."""

    pairs: Indices
    """(E, 2)."""
    partner: NDArray[np.intp]
    """(E, m), mode of b that continues each mode of a."""
    overlap: Array
    """(E, m), of a mode of a with its partner."""
    rank: NDArray[np.intp]
    """(E,), place in the order in which they are trusted, from 0."""


def _unique(pairs: Indices, n_postures: int) -> Indices:
    """Return each pair once, the smaller index first."""
    low, high = pairs.min(axis=1, initial=n_postures), pairs.max(axis=1, initial=0)
    numbers = np.unique((low * n_postures + high)[low != high])
    return np.asarray(np.stack(np.divmod(numbers, n_postures), axis=1), dtype=np.intp)


def _gaps(frequencies: Array, n: int) -> Array:
    """Return the gaps (k, N) above each of the first n modes, over the frequency; inf where none.

    There are n of them, or one less where no mode was computed beyond those.
    """
    gaps = np.diff(frequencies[: n + 1], axis=0) / frequencies[: n + 1][1:]
    return np.where(np.isnan(gaps), np.inf, gaps)


def _has_equal(frequencies: Array, n: int) -> NDArray[np.bool_]:
    """Tell at which postures (N,) one of the first n modes has the frequency of another."""
    return np.asarray((_gaps(frequencies, n) <= _EQUAL).any(axis=0))


def _distinct(pairs: Indices, frequencies: Array, start: int, n: int) -> int:
    """Return the posture, fewest pairs away from a start, at which no frequencies are equal.

    The start itself if there is none.
    """
    n_postures = frequencies.shape[1]
    beside = sparse.csr_array((np.ones(len(pairs)), pairs.T), shape=(n_postures, n_postures))
    order, _ = csgraph.breadth_first_order(beside, start, directed=False)
    return int(order[np.argmin(_has_equal(frequencies, n)[order])])


def _bridges(pairs: Indices, frequencies: Array, n: int) -> Indices:
    """Return the pairs of postures (E, 2) between which lies one whose modes may have mixed."""
    narrowest = _gaps(frequencies, n).min(axis=0, initial=np.inf)
    n_postures = narrowest.size
    ones = np.ones(len(pairs))
    beside = sparse.csr_array((ones, pairs.T), shape=(n_postures, n_postures))
    beside = (beside + beside.T).tocsr()
    # A bridge is to end where the modes are told apart.
    ends = sparse.diags_array((narrowest > _EQUAL).astype(float)) @ beside
    middles = sparse.diags_array((narrowest < _CLOSE).astype(float))
    around = sparse.triu(ends @ middles @ ends.T, k=1)
    # Neighbours are compared already.
    around = sparse.coo_array(around - around.multiply(beside))
    a, b = around.coords
    kept = np.flatnonzero(around.data)
    return np.asarray(np.stack([a[kept], b[kept]], axis=1), dtype=np.intp)


def _compare(modes: ModeVectors, pairs: Indices, n: int) -> _Compared:
    """Find out which modes of each pair of postures belong together, and how surely."""
    m = modes.frequencies.shape[0]
    partner = np.zeros((len(pairs), m), dtype=np.intp)
    overlap = np.zeros((len(pairs), m))
    group = _groups(modes.frequencies)
    for start in range(0, len(pairs), _BLOCK):
        block = slice(start, start + _BLOCK)
        a, b = pairs[block].T
        products = modes.vectors[a] @ np.swapaxes(modes.vectors[b], 1, 2)
        single = products.astype(np.float64) ** 2
        shares = _shares_of_groups(single, group[a], group[b])
        # Within a group any partner is as good as another: the most alike is the plainest choice.
        partner[block] = _best_partners(shares + 1e-3 * single)
        chosen = np.take_along_axis(shares, partner[block][:, :, None], axis=2)[:, :, 0]
        overlap[block] = np.sqrt(np.minimum(chosen, 1.0))
    sureness = _sureness(modes.frequencies, pairs, partner, overlap, n)
    rank = np.empty(len(pairs), dtype=np.intp)
    rank[np.argsort(-np.round(sureness, _ROUNDING), kind="stable")] = np.arange(len(pairs))
    return _Compared(pairs, partner, overlap, rank)


def _groups(frequencies: Array) -> NDArray[np.intp]:
    """Return a number (N, m) for each mode, the same for modes of equal frequency."""
    m, n_postures = frequencies.shape
    apart = _gaps(frequencies, m) > _EQUAL
    group = np.zeros((n_postures, m), dtype=np.intp)
    group[:, 1:] = np.cumsum(apart, axis=0).T
    return group


def _shares_of_groups(single: Array, group_a: Indices, group_b: Indices) -> Array:
    """Return squared overlaps (E, m, m) with groups of equal frequency taken as subspaces.

    The share of one subspace in another is the sum of squared products over the smaller dimension:
    1 where one contains the other, whatever mixtures the modes are.
    """
    shares = single.copy()
    m = single.shape[1]
    grouped = np.flatnonzero((group_a[:, -1] < m - 1) | (group_b[:, -1] < m - 1))
    in_a, in_b = (
        (g[grouped, :, None] == g[grouped, None, :]).astype(float) for g in (group_a, group_b)
    )
    smaller = np.minimum(in_a.sum(axis=2)[:, :, None], in_b.sum(axis=2)[:, None, :])
    shares[grouped] = in_a @ single[grouped] @ in_b / smaller
    return shares


def _best_partners(score: Array) -> NDArray[np.intp]:
    """Return the column (E, m) of each row by which the scores (E, m, m) have the largest sum.

    Rows are served one after the other; of each set of columns that they may have used, the best
    way to use it is kept (M. Held, R. M. Karp, J. SIAM 10, 1962). For the few modes at hand this is
    far faster over many pairs than one assignment problem at a time.
    """
    n_pairs, m, _ = score.shape
    best = np.full((1 << m, n_pairs), -np.inf)
    best[0] = 0.0
    last = np.zeros((1 << m, n_pairs), dtype=np.int8)
    for used in range(1, 1 << m):
        row = used.bit_count() - 1
        for column in range(m):
            if used >> column & 1:
                total = best[used ^ (1 << column)] + score[:, row, column]
                better = total > best[used]
                best[used][better] = total[better]
                last[used][better] = column
    partner = np.empty((n_pairs, m), dtype=np.intp)
    used_up = np.full(n_pairs, (1 << m) - 1)
    for row in reversed(range(m)):
        partner[:, row] = last[used_up, np.arange(n_pairs)]
        used_up ^= 1 << partner[:, row]
    return partner


def _sureness(
    frequencies: Array,
    pairs: Indices,
    partner: NDArray[np.intp],
    overlap: Array,
    n: int,
) -> Array:
    """Return how much each pair (E,) is trusted: by the least overlap of the lowest n modes."""
    a, b = pairs.T
    rows = np.arange(partner.shape[1])
    exists = np.isfinite(frequencies).T
    either = exists[a] | np.take_along_axis(exists[b], partner, axis=1)
    counts = np.logical_and((rows < n) | (partner < n), either)
    crosses = np.asarray(counts & (partner != rows))[:, :n].any(axis=1)
    # Through modes of equal frequency nothing can be followed: these pairs come last of all.
    equal = _has_equal(frequencies, n).astype(float)
    least = np.where(counts, overlap, 1.0).min(axis=1, initial=1.0)
    return np.asarray(least - _CROSSING * crosses - equal[a] - equal[b])


def _steps(
    compared: _Compared, start: int, n_postures: int
) -> tuple[NDArray[np.intp], Array, Indices]:
    """Return, for each posture, what continues the modes of the one before it.

    That is the mode (N, m + 1), with m for those that are lost, the overlap (N, m + 1), and the
    posture before it (N,) on the way from the start; the start itself for what is not connected.
    """
    m = compared.partner.shape[1]
    step = np.full((n_postures, m + 1), m)
    overlap = np.ones((n_postures, m + 1))
    before = np.full(n_postures, start)
    step[start] = np.arange(m + 1)
    a, b = compared.pairs.T
    # Zero would be no pair at all.
    weights = sparse.csr_array((compared.rank + 1.0, (a, b)), shape=(n_postures, n_postures))
    tree = csgraph.minimum_spanning_tree(weights)
    _, found = csgraph.breadth_first_order(tree, start, directed=False)
    chosen = np.argsort(compared.rank)[np.asarray(tree.data, dtype=np.intp) - 1]
    forward = chosen[found[b[chosen]] == a[chosen]]
    backward = chosen[found[a[chosen]] == b[chosen]]
    # Read from b to a, the partners are those of the inverse permutation.
    inverse = np.argsort(compared.partner[backward], axis=1)
    step[b[forward], :m] = compared.partner[forward]
    step[a[backward], :m] = inverse
    overlap[b[forward], :m] = compared.overlap[forward]
    overlap[a[backward], :m] = np.take_along_axis(compared.overlap[backward], inverse, axis=1)
    before[b[forward]], before[a[backward]] = a[forward], b[backward]
    return np.where(overlap < LOST, m, step), overlap, before


def _from_start(
    step: NDArray[np.intp], overlap: Array, before: Indices, start: int, exists: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], Array]:
    """Return the mode (N, m + 1) of each branch, and the least overlap on the way to it.

    ``exists`` (m,) tells which modes the start has. Each round joins the way from a posture to the
    last one known with the way from there, which doubles its length.
    """
    m = exists.size
    step[start, :m] = np.where(exists, np.arange(m), m)
    for _ in range(len(before).bit_length()):
        middle = step[before]
        overlap = np.minimum(overlap[before], np.take_along_axis(overlap, middle, axis=1))
        step = np.take_along_axis(step, middle, axis=1)
        before = before[before]
    return step, overlap


def _jumps(compared: _Compared, mode: NDArray[np.intp], n_pairs: int, frequencies: Array) -> int:
    """Return across how many of the first pairs a branch is not continued by what resembles it."""
    a, b = compared.pairs[:n_pairs].T
    partner, group = compared.partner[:n_pairs], _groups(frequencies)
    here, there = mode[:, a].T, mode[:, b].T
    expected = np.take_along_axis(partner, np.maximum(here, 0), axis=1)
    differ = np.take_along_axis(group[b], expected, axis=1) != np.take_along_axis(
        group[b], np.maximum(there, 0), axis=1
    )
    equal = _has_equal(frequencies, len(mode))
    both = (here >= 0) & (there >= 0) & ~(equal[a] | equal[b])[:, None]
    return int((differ & both).any(axis=1).sum())
