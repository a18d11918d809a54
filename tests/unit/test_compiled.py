"""Kernels: the three modes agree, and compiled code is shared by topology."""

from __future__ import annotations

import importlib.util
import warnings
from importlib.machinery import ModuleSpec

import numpy as np
import pytest

from stiffkit.compiled import BatchFunction, Constants, Kernel, function, heyoka_available
from stiffkit.errors import StiffkitError
from stiffkit.smallmat import Vector, cos, dot, multiply, sqrt, vector, where_less


def sample(a: float, b: float, topology: str = "sample") -> Kernel:
    """A kernel that uses all that kernels use."""
    constants = Constants()
    constants.add("a", np.array([a]))
    constants.add("b", np.array([b, 0.0, 2.0]))

    def compute(x: Vector, c: Vector) -> Vector:
        length = constants.read(c, "b")
        scaled = multiply(constants.read(c, "a")[0], cos(x[0]))
        norm = sqrt(dot(x, x))
        return vector([scaled, where_less(x[0], x[1], norm, -norm), dot(length, vector([*x, 1.0]))])

    return Kernel(topology, compute, 2, constants, topology)


def test_the_three_modes_agree() -> None:
    x = np.random.default_rng(0).normal(size=(2, 3000))
    kernel = sample(1.3, 0.7)
    batch = BatchFunction(kernel, "numpy")(x)
    single = np.stack([BatchFunction(kernel, "numpy")(x[:, [i]])[:, 0] for i in range(20)], axis=1)
    compiled = BatchFunction(kernel, "heyoka")(x)
    assert np.abs(single - batch[:, :20]).max() < 1e-14
    assert np.abs(compiled - batch).max() < 1e-13


def test_a_changed_dimension_does_not_compile_again() -> None:
    first, second = BatchFunction(sample(1.3, 0.7)), BatchFunction(sample(-0.2, 0.9))
    assert first.compile() is second.compile()
    x = np.array([[0.3, 0.4], [0.1, 0.9]])
    for f in (first, second):
        f.backend = "heyoka"
    assert first(x)[0] == pytest.approx(1.3 * np.cos(x[0]))
    assert second(x)[0] == pytest.approx(-0.2 * np.cos(x[0]))


def test_a_dimension_that_becomes_zero_compiles_again() -> None:
    # Zeros are left out of the arithmetic, so they belong to the topology.
    f, g = BatchFunction(sample(1.3, 0.7)), BatchFunction(sample(0.0, 0.7), "heyoka")
    assert f.compile() is not g.compile()
    assert not g(np.ones((2, 5)))[0].any()


def test_auto_interprets_little_and_compiles_much() -> None:
    f = BatchFunction(sample(1.0, 2.0, "auto"))
    key = f._key
    f(np.ones((2, 10)))
    assert key not in function._compiled
    f(np.ones((2, function.WORTH_COMPILING)))
    assert key in function._compiled


def test_no_postures_give_no_outputs() -> None:
    assert BatchFunction(sample(1.0, 2.0))(np.empty((2, 0))).shape == (3, 0)


def test_without_heyoka_it_says_so_once_and_works(monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec

    def without(name: str, package: str | None = None) -> ModuleSpec | None:
        return None if name == "heyoka" else find(name, package)

    monkeypatch.setattr(importlib.util, "find_spec", without)
    heyoka_available.cache_clear()
    try:
        f = BatchFunction(sample(1.0, 2.0, "without"), "auto")
        with pytest.warns(UserWarning, match="heyoka is not installed"):
            many = f(np.ones((2, 5000)))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            again = f(np.ones((2, 5000)))
    finally:
        heyoka_available.cache_clear()
    assert np.array_equal(many, again)
    assert many[0] == pytest.approx(np.cos(1.0))


def test_an_unknown_backend_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFKIT_BACKEND", "cuda")
    with pytest.raises(StiffkitError, match="STIFFKIT_BACKEND is 'cuda'"):
        BatchFunction(sample(1.0, 2.0))
