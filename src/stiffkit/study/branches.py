"""The modes of a study, followed from posture to posture: over the workspace, and along lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.study.grid import PoseGrid
from stiffkit.study.neighbours import Indices, lines_through, neighbours
from stiffkit.vibration import Branches, ModeVectors, track_modes

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Followed:
    """Frequencies of branches: modes that continue each other."""

    everywhere: Array
    """(n, N), Hz; NaN where there is no answer, or where a branch has left the computed modes."""
    facts: dict[str, Any]
    """Where the branches are numbered, and how surely they were followed."""
    along: dict[str, Array]
    """(n, n_axis), Hz, for each axis of a grid: along the line through the middle. What happens off
    the line does not count here: on an axis of symmetry modes cross that elsewhere do not."""
    facts_along: dict[str, dict[str, Any]]
    """The same facts for each line, and through which pose it goes."""


def follow(modes: ModeVectors, grid: PoseGrid, known: NDArray[np.bool_], n: int) -> Followed:
    """Follow the lowest n modes of the ``known`` (N,) poses of a grid, which is one pose at least.

    They are numbered by frequency near the middle of the grid.
    """
    flat = np.flatnonzero(known)
    beside = neighbours(grid, known)
    branches = track_modes(modes, beside.pairs, beside.middle, n)
    everywhere = np.full((n, known.size), np.nan)
    everywhere[:, flat] = branches.of(modes.frequencies)
    followed = Followed(everywhere, _facts(branches, grid, flat), {}, {})
    number = np.cumsum(known) - 1
    middle = int(flat[beside.middle])
    for axis, line in lines_through(grid, middle).items():
        on = np.flatnonzero(known[line])
        chosen = number[line[on]]
        start = int(np.flatnonzero(line[on] == middle)[0])
        branches = track_modes(modes.part(chosen), _chain(on.size), start, n)
        followed.along[axis] = np.full((n, line.size), np.nan)
        followed.along[axis][:, on] = branches.of(modes.frequencies[:, chosen])
        facts = {"through": _place(grid, middle)} | _facts(branches, grid, flat[chosen])
        followed.facts_along[axis] = facts
    return followed


def _chain(count: int) -> Indices:
    return np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)


def _facts(branches: Branches, grid: PoseGrid, flat: Indices) -> dict[str, Any]:
    return {
        "start": _place(grid, int(flat[branches.start])),
        "lowest_overlap": round(branches.lowest_overlap, 4),
        "neighbours": branches.pairs,
        "jumps": branches.jumps,
    }


def _place(grid: PoseGrid, pose: int) -> dict[str, float]:
    return {name: round(float(values[pose]), 12) for name, values in grid.values().items()}
