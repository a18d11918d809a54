"""A posture as it is drawn: every vertex where it is at rest, and how far a shape moves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.studio.solid import Solid
from stiffkit.studio.solids import Anatomy, suggested_scale
from stiffkit.studio.variant import Variant
from stiffkit.studio.view import PoseView
from stiffkit.studio.wish import LOADED, REST, Wish

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Drawn:
    """A mechanism at a posture; metres, world axes."""

    solids: tuple[Solid, ...]
    rest: tuple[Array, ...]
    """(V, 3) of each solid."""
    moved: tuple[Array, ...] | None
    """(V, 3) of each solid, its displacement, true to scale; None for a mechanism at rest."""
    magnification: float
    """By which displacements are drawn."""
    is_faint: bool

    def bent(self, share: float = 1.0) -> Sequence[Array]:
        """Return all vertices (V, 3) with a share of the displacement, magnified."""
        if self.moved is None:
            return self.rest
        factor = share * self.magnification
        return [rest + factor * moved for rest, moved in zip(self.rest, self.moved, strict=True)]


def anatomy_of(variant: Variant) -> Anatomy:
    """Return the solids of a variant."""
    home = variant.closed.home_unknowns[: variant.tree.n_coordinates]
    return Anatomy.of(variant.tree, home, variant.q)


def draw(anatomy: Anatomy, view: PoseView, wish: Wish, size: float) -> Drawn:
    """Return a posture as it is wished for; the robot's ``size``, m, says what can be seen.

    Raises LinkError where masses that a mode needs are at fault.
    """
    rest = tuple(anatomy.vertices(view.q))
    shape = _shape(view, wish)
    if shape is None:
        return Drawn(anatomy.solids, rest, None, 1.0, wish.is_faint)
    moved = tuple(m[0] for m in anatomy.displacements(view.variant.modal, view.q, shape))
    magnification = _magnification(moved, wish, size)
    return Drawn(anatomy.solids, rest, moved, magnification, wish.is_faint)


def _shape(view: PoseView, wish: Wish) -> Array | None:
    """Return what is drawn as a column (n_shape, 1), None where there is nothing to draw."""
    if wish.shape == REST:
        return None
    if wish.shape == LOADED:
        return None if wish.load is None else view.static_shape(wish.load)
    number = int(wish.shape)
    modes = view.modes()
    if modes is None or modes.shapes.shape[1] < number:
        return None
    return np.asarray(modes.shapes[:, [number - 1]])


def _magnification(moved: Sequence[Array], wish: Wish, size: float) -> float:
    # A mode has no size of its own, so it cannot be true to scale.
    if wish.magnification == 0.0 and wish.shape == LOADED:
        return 1.0
    return suggested_scale(moved, size) * (wish.magnification or 1.0)
