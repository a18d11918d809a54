"""Polynomial orders that differ from element to element."""

from __future__ import annotations

import numpy as np
import pytest

from stiffkit.fea.orders import HIGHEST, Gains

E = np.array([1.0, 1e-2, 1e-4, 1e-6])


def test_elements_that_promise_most_are_raised() -> None:
    gains = Gains(np.full(4, 2), E)
    np.testing.assert_array_equal(gains.raised(), [3, 2, 2, 2])


def test_what_was_gained_tells_what_will_be() -> None:
    gains = Gains(np.full(4, 2), np.ones(4))
    gains.learn(np.array([3, 3, 2, 2]), np.array([0.5, 0.2, 0.0, 0.0]))
    left = gains.left()
    assert left[0] == pytest.approx(0.5 * 0.5 / 0.5)
    assert left[1] == pytest.approx(0.2 * 0.2 / 0.8)
    # The others have what they had, at the usual rate.
    assert left[2] == left[3] == pytest.approx(1.0 * 0.2 / 0.8)


def test_the_highest_order_is_not_exceeded_and_what_is_left_there_is_told() -> None:
    orders = np.array([HIGHEST, 2, 2, 2])
    gains = Gains(orders, np.array([1.0, 0.5, 0.5, 0.5]))
    raised = gains.raised()
    assert raised[0] == HIGHEST
    assert gains.stuck() == 0.0
    gains.learn(raised, np.array([9.0, 0.1, 0.1, 0.1]))
    assert gains.stuck() == pytest.approx(1.0 * 0.2 / 0.8 / 9.3)
    assert gains.waiting() == gains.stuck()


def test_an_order_that_gains_nothing_is_not_the_end() -> None:
    """The warping of a square bar under torsion is of order four: order three adds nothing."""
    gains = Gains(np.full(4, 2), np.ones(4))
    gains.learn(np.full(4, 3), np.array([0.3, 0.0, 0.0, 0.0]))
    assert gains.left()[1] > 0.01


def test_nothing_is_raised_where_nothing_can_be() -> None:
    orders = np.full(4, HIGHEST)
    np.testing.assert_array_equal(Gains(orders, E).raised(), orders)


def test_spaces_have_the_orders_asked_for() -> None:
    pytest.importorskip("ngsolve")
    from netgen.csg import unit_cube
    from ngsolve import Mesh

    from stiffkit.fea.orders import Topology

    topology = Topology(Mesh(unit_cube.GenerateMesh(maxh=0.5)))
    n = topology.n_elements
    sizes = [topology.space(np.full(n, order)).ndof for order in (2, 3)]
    orders = np.full(n, 2)
    orders[0] = 3
    one = topology.space(orders).ndof
    # Six edges and four faces of the tetrahedron get one function more each.
    assert one == sizes[0] + 6 + 4
    assert sizes[0] < one < sizes[1]
