"""Polynomial orders that differ from element to element, and where to raise them."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.spatial.rotation import Array

Orders = NDArray[np.intp]

HIGHEST = 7
"""Assembly takes work with the ninth power of the order: beyond this, smaller elements are cheaper.
"""

_MOST_OF_GAIN = 0.93
"""The share of the gain to be expected that the elements to be raised have together."""

_DECAYS = (0.1, 0.6)
"""Ratios of an element's gain to that by its order before, at least and at most, as believed. An
order may gain nothing where the next one gains much: the warping of a square bar under torsion is
of order four."""

_SINGULAR = 1.2
"""The energy of the error at a re-entrant right angle goes with this power of the size."""

_SMOOTH = 0.4
"""The ratio up to which the solution in an element counts as smooth."""

_USUAL_DECAY = 0.2
"""The ratio as long as nothing is known."""


class Topology:
    """Which edges and faces the elements of a mesh have, in NGSolve's numbers."""

    def __init__(self, mesh: Any) -> None:
        """``mesh`` as NGSolve has it."""
        self.mesh = mesh
        self.n_elements = int(mesh.ne)

    @cached_property
    def edges(self) -> NDArray[np.intp]:
        """Edges (e, 6) of the elements."""
        return np.array([[edge.nr for edge in element.edges] for element in self.mesh.Elements()])

    @cached_property
    def faces(self) -> NDArray[np.intp]:
        """Faces (e, 4) of the elements."""
        return np.array([[face.nr for face in element.faces] for element in self.mesh.Elements()])

    def space(self, orders: Orders, *, dim: int = 1, held: str = "") -> Any:
        """Return NGSolve's continuous functions with orders (e,) in the elements.

        An edge or a face has the highest order of the elements that it belongs to. ``dim``
        components; ``held``: NGSolve's pattern of the faces where the functions vanish.
        """
        from ngsolve import CELL, EDGE, FACE, H1, NodeId

        lowest = int(orders.min())
        space = H1(self.mesh, order=lowest, dim=dim, dirichlet=held)
        if lowest == orders.max():
            return space
        for kind, nodes, count in (
            (EDGE, self.edges, self.mesh.nedge),
            (FACE, self.faces, self.mesh.nface),
            (CELL, np.arange(self.n_elements)[:, None], self.n_elements),
        ):
            wanted = np.zeros(count, dtype=np.intp)
            np.maximum.at(wanted, nodes, orders[:, None])
            for node in np.flatnonzero(wanted > lowest):
                space.SetOrder(NodeId(kind, int(node)), int(wanted[node]))
        space.UpdateDofTables()
        return space


class Gains:
    """What raising the order has gained in each element, and what it may gain yet.

    Gains are energies, J. That of the next order is foretold from the ratio of the last two, as
    element by element the error falls geometrically where the solution is smooth.
    """

    def __init__(self, orders: Orders, energies: Array) -> None:
        """``energies`` (e,) of the differences that the last of ``orders`` (e,) made."""
        self.orders = orders
        self._energies = energies
        self._last_gain = float(energies.sum())
        self._waiting = np.zeros(len(orders), dtype=np.bool_)
        self._decays = np.full(len(orders), _USUAL_DECAY)

    def moved(self, orders: Orders, there: NDArray[np.intp], shrink: Array) -> Gains:
        """Return what to expect of another mesh's elements with ``orders`` (e,).

        ``there`` (e,) are the elements of this mesh that lie where they do, and ``shrink`` (e,)
        the ratios of their sizes. Where the error is singular it falls with a power of the size.
        """
        decays = self._decays[there]
        energies = self._energies[there] * shrink ** (3.0 + _SINGULAR)
        # What lost an order wins it back first.
        lost = orders < self.orders[there]
        out = Gains(orders, np.where(lost, energies / decays, energies))
        out._decays = decays
        return out

    def raised(self) -> Orders:
        """Return orders (e,), higher by one where most is to be gained; the same if nowhere."""
        gains = np.where(self.orders < HIGHEST, self._decays * self._energies, 0.0)
        ranked = np.argsort(-gains)
        reached = np.cumsum(gains[ranked])
        count = int(np.searchsorted(reached, _MOST_OF_GAIN * reached[-1])) + 1
        chosen = ranked[:count]
        out = self.orders.copy()
        out[chosen[gains[chosen] > 0.0]] += 1
        return out

    def learn(self, orders: Orders, energies: Array) -> None:
        """Take in the energies (e,) of the differences that new orders (e,) made."""
        new = orders > self.orders
        before = np.maximum(self._energies[new], 1e-300)
        self._decays[new] = np.clip(energies[new] / before, *_DECAYS)
        self._energies[new] = np.maximum(energies[new], _DECAYS[0] * before)
        self._last_gain = float(energies.sum())
        self._waiting = ~new
        self.orders = orders

    def left(self) -> Array:
        """Return the energies (e,) that all further orders may gain, as foretold."""
        return np.asarray(self._energies * self._decays / (1.0 - self._decays))

    def smooth(self) -> float:
        """Return the share of what is left that falls fast with the order."""
        left = self.left()
        return float(left[self._decays < _SMOOTH].sum() / left.sum())

    def waiting(self) -> float:
        """Return what is left in elements that the last solution did not raise.

        As a share of what it gained.
        """
        return float(self.left()[self._waiting].sum()) / self._last_gain

    def stuck(self) -> float:
        """Return that part of it that is in elements of the highest order."""
        stuck = self._waiting & (self.orders >= HIGHEST)
        return float(self.left()[stuck].sum()) / self._last_gain
