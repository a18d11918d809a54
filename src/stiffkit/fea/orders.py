"""Polynomial orders that differ from element to element."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Orders = NDArray[np.intp]


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

    @property
    def _kinds(self) -> tuple[tuple[NDArray[np.intp], int], ...]:
        """Edges, faces and insides of the elements (e, k), and how many of each there are."""
        insides = np.arange(self.n_elements)[:, None]
        return (
            (self.edges, int(self.mesh.nedge)),
            (self.faces, int(self.mesh.nface)),
            (insides, self.n_elements),
        )

    def _highest(self, orders: Orders) -> tuple[Orders, Orders, Orders]:
        """Return the highest orders of the elements that edges, faces and insides belong to."""
        found = []
        for nodes, count in self._kinds:
            highest = np.zeros(count, dtype=np.intp)
            np.maximum.at(highest, nodes, orders[:, None])
            found.append(highest)
        edges, faces, insides = found
        return edges, faces, insides

    def node_count(self, orders: Orders) -> int:
        """Return how many nodes elements of orders (e,) have: the dimension of `space`."""
        edges, faces, insides = self._highest(orders)
        in_faces = (faces - 1) * (faces - 2) // 2
        inside = (insides - 1) * (insides - 2) * (insides - 3) // 6
        return int(self.mesh.nv + (edges - 1).sum() + in_faces.sum() + inside.sum())

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
        for kind, wanted in zip((EDGE, FACE, CELL), self._highest(orders), strict=True):
            for node in np.flatnonzero(wanted > lowest):
                space.SetOrder(NodeId(kind, int(node)), int(wanted[node]))
        space.UpdateDofTables()
        return space
