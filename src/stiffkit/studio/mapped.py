"""The workspace in colours: which poses are seen, and what colour each has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Status
from stiffkit.plots import DisplayUnit, display_unit
from stiffkit.plots.quantities import kind_of
from stiffkit.plots.scale import Scale
from stiffkit.studio.looks import map_colours
from stiffkit.studio.machine import Variant
from stiffkit.studio.wish import SLICE, Wish
from stiffkit.study import QUANTITIES

Array = NDArray[np.float64]

_FILLED = 1.04
"""Size of a point over the spacing of the grid where points make a surface, ..."""
_LOOSE = 0.3
"""... and where one should see through them."""


@dataclass(frozen=True, eq=False)
class Mapped:
    """A quantity over the poses that are seen."""

    which: NDArray[np.intp]
    """(P,), their numbers among the variant's poses."""
    values: Array
    """(P,), in ``unit``; NaN where there is no answer."""
    status: NDArray[np.int8]
    """(P,), `stiffkit.kinematics.Status`."""
    colours: NDArray[np.uint8]
    """(P, 3)."""
    scale: Scale
    unit: DisplayUnit
    point_size: float
    """m."""
    worst: tuple[int, float] | None
    """The worst pose of the whole workspace, a number among the variant's poses, and the value
    there, in ``unit``; None where no pose has a finite value."""
    median: float
    """Of the whole workspace, in ``unit``."""
    slice_at: float | None
    """Where the slice is, m or rad; None where all poses are seen."""


@dataclass(frozen=True, eq=False)
class HeldScale:
    """A scale that is kept, with what it belongs to."""

    quantity: str
    scale: Scale
    unit: DisplayUnit


def map_of(variant: Variant, wish: Wish, held: HeldScale | None = None) -> Mapped:
    """Return what is seen of a variant's workspace; ``held`` is a scale to keep, if it fits."""
    quantity = QUANTITIES[wish.quantity]
    load = wish.load if quantity.per_load else None
    si = variant.quantity(wish.quantity, wish.model, load)
    keeps = held is not None and held.quantity == wish.quantity
    unit = held.unit if held and keeps else display_unit(kind_of(quantity), si)
    values = unit.of(si)
    scale = held.scale if held and keeps else Scale.of(values)
    finite = values[np.isfinite(values)]
    worst = variant.worst(wish.quantity, wish.model, load)
    status = variant.status(wish.model)
    slice_at = _slice_at(variant, wish)
    which = _seen(variant, wish.slice_axis, slice_at, status)
    return Mapped(
        which=which,
        values=values[which],
        status=status[which],
        colours=map_colours(values[which], status[which], scale),
        scale=scale,
        unit=unit,
        point_size=_point_size(variant, is_slice=slice_at is not None),
        worst=None if worst is None else (worst[0], float(unit.of(worst[1]))),
        median=float(np.median(finite)) if finite.size else np.nan,
        slice_at=slice_at,
    )


def _slice_at(variant: Variant, wish: Wish) -> float | None:
    """Return where the slice is that is wished for, a value of the grid; None without one."""
    if wish.extent != SLICE or wish.slice_axis not in variant.axes:
        return None
    places = variant.axes[wish.slice_axis]
    return float(places[round(wish.slice_share * (places.size - 1))])


def _seen(
    variant: Variant, axis: str, slice_at: float | None, status: NDArray[np.int8]
) -> NDArray[np.intp]:
    """Return the numbers of the poses that are seen."""
    inside = status != Status.OUTSIDE
    if slice_at is not None:
        inside = inside & (variant.poses[variant.swept.index(axis)] == slice_at)
    return np.flatnonzero(inside)


def _point_size(variant: Variant, *, is_slice: bool) -> float:
    """Return a size with which points of a plane touch, and those of a volume do not."""
    moves = [i for i, row in enumerate(variant.poses) if variant.swept[i] in "xyz" and np.ptp(row)]
    if not moves:
        return 0.01 * variant.size
    rows = variant.poses[moves]
    extents = np.ptp(rows, axis=1)
    # As many poses as there are, spread evenly over the box.
    spacing = float((np.prod(extents) / rows.shape[1]) ** (1.0 / len(moves)))
    is_plane = len(moves) < 3 or is_slice
    return spacing * (_FILLED if is_plane else _LOOSE)
