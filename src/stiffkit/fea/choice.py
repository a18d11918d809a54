"""Where to refine: which elements get a higher order, and which are cut into smaller ones.

Both are told from one solution. What its highest order holds in an element is compared with what
the order below holds: where that falls fast, the solution is smooth there, and the next order
gains most; where it falls slowly, at edges that the stress is infinite at, only smaller elements
help. P. Houston, E. Suli, "A note on the design of hp-adaptive finite element methods for elliptic
partial differential equations", Comput. Methods Appl. Mech. Eng. 194, 2005.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiffkit.fea.orders import Orders
from stiffkit.spatial.rotation import Array

Mask = NDArray[np.bool_]

HIGHEST = 5
"""Of orders. Assembly takes work with their ninth power: beyond this, smaller elements are cheaper.
"""

_SHARE = 0.87
"""Of all that is to be gained, the share of the elements that are chosen together. W. Doerfler, "A
convergent adaptive algorithm for Poisson's equation", SIAM J. Numer. Anal. 33, 1996."""

_SMOOTH = 0.35
"""The ratio of what two successive orders hold up to which the solution counts as smooth."""

_DECAYS = (0.05, 0.9)
"""Such ratios, at least and at most, as believed. An order may hold nothing where the next one
holds much: the warping of a square bar under torsion is of order four."""

_USUAL_DECAY = 0.2
"""The ratio in elements of too low an order to tell it."""

_TELLING = 3
"""The lowest order that tells a ratio."""


class Choice(NamedTuple):
    """What is to be done to each element of a mesh."""

    raised: Mask
    """(e,), to the next order."""
    cut: Mask
    """(e,), in half."""


def choose(orders: Orders, contents: Array) -> Choice:
    """Choose the elements that promise most of what is to be gained, for what they cost.

    ``orders`` (e,); ``contents`` (2, e): the energies, J, of what the highest order and the one
    below it hold in each element.
    """
    decays = np.full(len(orders), _USUAL_DECAY)
    tells = orders >= _TELLING
    highest, below = contents[:, tells]
    decays[tells] = np.clip(highest / np.maximum(below, 1e-300), *_DECAYS)
    gains = decays * contents[0]
    raisable = (decays < _SMOOTH) & (orders < HIGHEST)
    ranked = np.argsort(-gains / _costs(orders, raisable), kind="stable")
    reached = np.cumsum(gains[ranked])
    count = int(np.searchsorted(reached, _SHARE * reached[-1])) + 1
    chosen = np.zeros(len(orders), dtype=np.bool_)
    chosen[ranked[:count]] = True
    return Choice(chosen & raisable, chosen & ~raisable)


def _costs(orders: Orders, raisable: Mask) -> Array:
    """Return how many more nodes (e,) each element costs.

    An element has about p^3 / 6, and the next order adds p^2 / 2. One that is cut is cut with its
    neighbours at the edge; of each, a half is new. Their number is shared by the elements there
    that are chosen too, so three halves are counted.
    """
    p = orders.astype(float)
    return np.where(raisable, p**2 / 2.0, 1.5 * p**3 / 6.0)
