"""Which elements are refined, and how."""

from __future__ import annotations

import numpy as np

from stiffkit.fea.choice import HIGHEST, choose


def test_elements_that_promise_most_are_chosen() -> None:
    held = np.array([1.0, 1e-2, 1e-4, 1e-6])
    choice = choose(np.full(4, 2), np.array([held, 10.0 * held]))
    np.testing.assert_array_equal(choice.raised, [True, False, False, False])
    assert not choice.cut.any()


def test_smooth_elements_are_raised_and_singular_ones_cut() -> None:
    choice = choose(np.full(2, 3), np.array([[1.0, 1.0], [10.0, 1.5]]))
    np.testing.assert_array_equal(choice.raised, [True, False])
    np.testing.assert_array_equal(choice.cut, [False, True])


def test_the_lowest_order_tells_nothing_of_smoothness() -> None:
    choice = choose(np.full(2, 2), np.array([[1.0, 1.0], [0.1, 0.1]]))
    assert choice.raised.all()


def test_elements_of_the_highest_order_are_cut_even_if_smooth() -> None:
    choice = choose(np.full(1, HIGHEST), np.array([[1.0], [10.0]]))
    assert choice.cut.all()
    assert not choice.raised.any()


def test_the_cheaper_of_two_that_gain_the_same_comes_first() -> None:
    many = np.ones(100)
    orders = np.where(np.arange(100) % 2, 4, 3)
    choice = choose(orders, np.array([many, 10.0 * many]))
    assert choice.raised[orders == 3].all()
    assert not choice.raised[orders == 4].all()


def test_an_order_that_holds_nothing_is_not_the_end() -> None:
    """The warping of a square bar under torsion is of order four: order three adds nothing."""
    choice = choose(np.full(1, 3), np.array([[1e-30], [1.0]]))
    assert choice.raised.all()
