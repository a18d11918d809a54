"""Threads: blocks of fixed size, the same numbers with any number of threads, errors come out."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from stiffkit.compiled import (
    BatchFunction,
    Constants,
    Kernel,
    limited_threads,
    over_blocks,
    thread_count,
)
from stiffkit.errors import StiffkitError
from stiffkit.kinematics.nearest import Nearest
from stiffkit.robot import load_robot
from stiffkit.smallmat import multiply, sin, vector
from stiffkit.study import Analysis, map_workspace


@pytest.mark.parametrize("threads", [1, 3])
def test_every_posture_is_in_one_block(threads: int) -> None:
    seen = np.zeros(103, dtype=int)
    told: list[int] = []

    def work(block: slice) -> None:
        seen[block] += 1
        assert thread_count() == 1 or threads == 1  # nothing is spread twice

    with limited_threads(threads):
        over_blocks(103, 10, work, told.append)
    assert (seen == 1).all()
    assert told[-1] == 103
    assert told == sorted(told)


@pytest.mark.parametrize("threads", [1, 3])
def test_an_error_in_a_block_comes_out(threads: int) -> None:
    def work(block: slice) -> None:
        if block.start == 20:
            raise RuntimeError("block 20")

    with limited_threads(threads), pytest.raises(RuntimeError, match="block 20"):
        over_blocks(1000, 10, work)


def test_one_block_stays_in_this_thread() -> None:
    names: list[str] = []
    over_blocks(5, 10, lambda _block: names.append(threading.current_thread().name))
    assert names == [threading.current_thread().name]


def test_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFKIT_THREADS", "3")
    assert thread_count() == 3
    with limited_threads(2):
        assert thread_count() == 2
        with limited_threads(None):
            assert thread_count() == 2
    assert thread_count() == 3
    monkeypatch.delenv("STIFFKIT_THREADS")
    assert thread_count() >= 1
    for wrong in ("0", "-1", "many", ""):
        monkeypatch.setenv("STIFFKIT_THREADS", wrong)
        with pytest.raises(StiffkitError, match="STIFFKIT_THREADS"):
            thread_count()
    with pytest.raises(ValueError, match="at least one"), limited_threads(0):
        pass


def test_numbers_do_not_depend_on_the_size_of_a_batch() -> None:
    pytest.importorskip("heyoka")
    constants = Constants()
    constants.add("factor", np.array([1.7]))
    kernel = Kernel(
        "turn", lambda x, c: vector([sin(multiply(x[0], c[0]))]), 1, constants, ("turn",)
    )
    f = BatchFunction(kernel, "heyoka")
    inputs = np.random.default_rng(0).normal(scale=3.0, size=(1, 9001))
    whole = f(inputs)
    for n in (1, 7, 8, 1001, 9000):
        np.testing.assert_array_equal(f(inputs[:, :n]), whole[:, :n])
        np.testing.assert_array_equal(f(inputs[:, -n:]), whole[:, -n:])


def test_whether_to_compile_is_decided_before_the_work_is_cut(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("heyoka")
    monkeypatch.setenv("STIFFKIT_BACKEND", "auto")
    constants = Constants()
    constants.add("factor", np.array([1.7]))
    kernel = Kernel("few or many", lambda x, c: vector([x[0] * c[0]]), 1, constants, ())
    few = BatchFunction(kernel).ready_for(10)
    many = BatchFunction(kernel).ready_for(1_000_000)
    assert few.__class__ is not many.__class__
    inputs = np.linspace(0.0, 4.0, 5).reshape(1, 5)
    np.testing.assert_allclose(few(inputs), many(inputs))


@pytest.mark.parametrize("name", ["biglide", "five-bar"])
def test_a_map_is_the_same_with_any_number_of_threads(name: str) -> None:
    analysis = Analysis(load_robot(name))
    one, three = (
        map_workspace(analysis, points=30_000, frequencies=False, threads=n) for n in (1, 3)
    )
    for variable in one.data_vars:
        np.testing.assert_array_equal(one[variable], three[variable], err_msg=str(variable))


@pytest.mark.parametrize("m", [1, 2, 3])
def test_cells_find_a_point_that_is_nearly_the_nearest(m: int) -> None:
    rng = np.random.default_rng(m)
    points, queries = rng.random((50, m)), rng.random((80_000, m))
    found = Nearest(points, queries).of(queries)
    exact = Nearest(points, queries[:10]).of(queries)
    away = np.linalg.norm(queries - points[found], axis=1)
    nearest = np.linalg.norm(queries - points[exact], axis=1)
    diagonal = np.sqrt(m) / int(5000 ** (1.0 / m))
    assert (found != exact).any()
    assert (away <= nearest + diagonal).all()
