"""Polynomial orders that differ from element to element."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("ngsolve")

from stiffkit.fea.orders import Topology


@pytest.fixture(scope="module")
def topology() -> Topology:
    from netgen.csg import unit_cube
    from ngsolve import Mesh

    return Topology(Mesh(unit_cube.GenerateMesh(maxh=0.5)))


def test_spaces_have_the_orders_asked_for(topology: Topology) -> None:
    n = topology.n_elements
    sizes = [topology.space(np.full(n, order)).ndof for order in (2, 3)]
    orders = np.full(n, 2)
    orders[0] = 3
    one = topology.space(orders).ndof
    # Six edges and four faces of the tetrahedron get one function more each.
    assert one == sizes[0] + 6 + 4
    assert sizes[0] < one < sizes[1]


@pytest.mark.parametrize("seed", range(3))
def test_nodes_are_counted_without_making_the_space(topology: Topology, seed: int) -> None:
    orders = np.random.default_rng(seed).integers(1, 7, topology.n_elements)
    assert topology.node_count(orders) == topology.space(orders).ndof
