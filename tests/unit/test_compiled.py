"""Kernels: three modes, one answer; compiled once for each topology."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.compiled import BatchFunction, Constants, Kernel, default_backend, heyoka_available
from stiffkit.compiled import function as module
from stiffkit.smallmat import (
    Vector,
    add,
    cos,
    factor,
    identity,
    matmul,
    multiply,
    plus,
    sin,
    sqrt,
    vector,
    where_less,
)
from stiffkit.spatial import exp_rotation

Array = NDArray[np.float64]

needs_heyoka = pytest.mark.skipif(
    importlib.util.find_spec("heyoka") is None, reason="heyoka is not installed"
)


def sample(
    S: Array | None = None, turn: float = 0.3, offset: float = 2.0, topology: str = "sample"
) -> Kernel:
    """Return a kernel of two inputs that uses all kinds of constants and operations."""
    constants = Constants()
    constants.add_symmetric("S", np.diag([1.0, 2.0, 3.0]) if S is None else S)
    constants.add("R", exp_rotation([0.0, 0.0, turn]), rotation=True)
    constants.add("offset", np.array([offset]))
    constants.add("unused", np.array([7.0]))

    def function(x: Vector, c: Vector) -> Vector:
        S = constants.read_symmetric(c, "S")
        R = constants.read(c, "R")
        offset = constants.read(c, "offset")[0]
        A = plus(identity(3), S)
        A[0, 0] = add(A[0, 0], multiply(x[0], x[0]))
        turned = matmul(R, vector([sin(x[0]), cos(x[1]), 1.0]))
        solution = factor(A).solve(turned)
        switch = where_less(x[0], x[1], sqrt(add(multiply(x[1], x[1]), offset)), 0.0)
        return vector([*solution, switch, 4.0])

    return Kernel("sample", function, 2, constants, topology)


@pytest.fixture
def inputs() -> Array:
    return np.random.default_rng(0).normal(size=(2, 50))


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Empty the cache, and count what is compiled."""
    import heyoka

    monkeypatch.setattr(module, "_compiled", type(module._compiled)())
    compile_function = heyoka.cfunc
    counted: list[int] = []

    def count(*args: Any, **keywords: Any) -> Any:
        counted.append(1)
        return compile_function(*args, **keywords)

    monkeypatch.setattr(heyoka, "cfunc", count)
    return counted


@needs_heyoka
def test_floats_batches_and_compiled_code_agree(inputs: Array) -> None:
    kernel = sample()
    compiled = BatchFunction(kernel, "heyoka")(inputs)
    batch = BatchFunction(kernel, "numpy")(inputs)
    interpreted = BatchFunction(kernel, "numpy")
    one_by_one = np.hstack([interpreted(column[:, None]) for column in inputs.T])
    assert compiled.shape == (5, 50)
    np.testing.assert_allclose(compiled, batch, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(one_by_one, batch, rtol=1e-12, atol=1e-14)


@needs_heyoka
@pytest.mark.parametrize(
    "n", [1, 2, *(k * module.LARGEST_CHUNK + i for k, i in ((1, -1), (1, 0), (2, 3)))]
)
def test_every_size_of_batch(n: int) -> None:
    inputs = np.random.default_rng(1).normal(size=(2, n))
    kernel = sample()
    compiled = BatchFunction(kernel, "heyoka")(inputs)
    np.testing.assert_allclose(compiled, BatchFunction(kernel, "numpy")(inputs), rtol=1e-12)


@pytest.mark.parametrize("backend", ["numpy", pytest.param("heyoka", marks=needs_heyoka)])
def test_an_empty_batch(backend: module.Backend) -> None:
    assert BatchFunction(sample(), backend)(np.empty((2, 0))).shape == (5, 0)


@needs_heyoka
def test_inputs_need_not_be_contiguous(inputs: Array) -> None:
    f = BatchFunction(sample(), "heyoka")
    np.testing.assert_array_equal(f(inputs[:, ::2]), f(inputs)[:, ::2])


@needs_heyoka
def test_nan_goes_in_and_comes_out(inputs: Array) -> None:
    inputs[:, 3] = np.nan
    for backend in ("numpy", "heyoka"):
        out = BatchFunction(sample(), backend)(inputs)
        assert np.isnan(out[:2, 3]).all()
        assert np.isfinite(np.delete(out, 3, axis=1)).all()


@needs_heyoka
def test_a_kernel_without_free_constants(inputs: Array) -> None:
    constants = Constants()
    constants.add("zero", np.zeros(1))
    kernel = Kernel(
        "plain", lambda x, c: vector([add(multiply(x[0], x[1]), c[0])]), 2, constants, ()
    )
    np.testing.assert_allclose(BatchFunction(kernel, "heyoka")(inputs)[0], inputs[0] * inputs[1])


@needs_heyoka
def test_new_values_of_constants_do_not_compile_again(
    inputs: Array, compilations: list[int]
) -> None:
    full = np.array([[4.0, 1.0, 0.5], [1.0, 5.0, 0.3], [0.5, 0.3, 6.0]])
    for scale, turn, offset in ((1.0, 0.3, 2.0), (3.0, -1.2, 0.5), (0.1, 2.0, 9.0)):
        kernel = sample(scale * full, turn, offset)
        found = BatchFunction(kernel, "heyoka")(inputs)
        np.testing.assert_allclose(found, BatchFunction(kernel, "numpy")(inputs), rtol=1e-12)
    assert len(compilations) == 1


@needs_heyoka
@pytest.mark.parametrize(
    "other",
    [
        sample(np.diag([1.0, 2.0, 0.0])),
        sample(np.diag([1.0, 2.0, 3.0]) + 0.1),
        sample(turn=0.0),
        sample(offset=0.0),
        sample(topology="another"),
    ],
    ids=["a zero more", "zeros less", "no rotation", "no offset", "topology"],
)
def test_another_pattern_of_zeros_compiles_again(
    inputs: Array, compilations: list[int], other: Kernel
) -> None:
    for kernel in (sample(), other, sample(), other):
        found = BatchFunction(kernel, "heyoka")(inputs)
        np.testing.assert_allclose(
            found, BatchFunction(kernel, "numpy")(inputs), rtol=1e-12, atol=1e-14
        )
    assert len(compilations) == 2


@needs_heyoka
def test_constants_in_another_order_compile_again(inputs: Array, compilations: list[int]) -> None:
    def kernel(*names: str) -> Kernel:
        constants = Constants()
        for name in names:
            constants.add(name, np.array([{"a": 2.0, "b": 3.0}[name]]))
        return Kernel(
            "order",
            lambda x, c: vector([multiply(x[0], constants.read(c, "a")[0])]),
            2,
            constants,
            ("equal",),
        )

    for names in (("a", "b"), ("b", "a")):
        np.testing.assert_allclose(
            BatchFunction(kernel(*names), "heyoka")(inputs)[0], 2 * inputs[0]
        )
    assert len(compilations) == 2


@needs_heyoka
def test_auto_compiles_when_it_is_worth_it(inputs: Array, compilations: list[int]) -> None:
    f = BatchFunction(sample(), "auto")
    few = f(inputs)
    assert len(compilations) == 0
    many = f(np.tile(inputs, 1 + module.WORTH_COMPILING // inputs.shape[1]))
    assert len(compilations) == 1
    np.testing.assert_allclose(few, many[:, : inputs.shape[1]], rtol=1e-12)
    np.testing.assert_allclose(f(inputs), few, rtol=1e-12)
    assert len(compilations) == 1


@needs_heyoka
def test_auto_takes_compiled_code_that_is_there(inputs: Array, compilations: list[int]) -> None:
    BatchFunction(sample(), "heyoka")(inputs)
    second = BatchFunction(sample(offset=5.0), "auto")
    np.testing.assert_allclose(
        second(inputs), BatchFunction(second.kernel, "numpy")(inputs), rtol=1e-12
    )
    assert len(compilations) == 1


@needs_heyoka
def test_the_cache_forgets_what_was_used_longest_ago(
    inputs: Array, compilations: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_CACHE_SIZE", 2)
    for topology in ("first", "second", "first", "third", "first", "second"):
        BatchFunction(sample(topology=topology), "heyoka")(inputs)
    assert len(compilations) == 4


@pytest.fixture
def without_heyoka(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util,
        "find_spec",
        lambda name, *args: None if name == "heyoka" else find_spec(name, *args),
    )
    monkeypatch.setattr(module, "_compiled", type(module._compiled)())
    heyoka_available.cache_clear()
    yield
    heyoka_available.cache_clear()


@pytest.mark.usefixtures("without_heyoka")
def test_without_heyoka_everything_works_and_says_once_that_it_is_slower() -> None:
    many = np.random.default_rng(0).normal(size=(2, module.WORTH_COMPILING))
    with pytest.warns(UserWarning, match="heyoka is not installed.*slower"):
        found = BatchFunction(sample(), "auto")(many)
    np.testing.assert_array_equal(found, BatchFunction(sample(), "numpy")(many))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        BatchFunction(sample(offset=3.0), "auto")(many)


@pytest.mark.parametrize("named", ["auto", "numpy", "heyoka"])
def test_the_environment_names_the_backend(monkeypatch: pytest.MonkeyPatch, named: str) -> None:
    monkeypatch.setenv("STIFFKIT_BACKEND", named)
    assert default_backend() == named
    assert BatchFunction(sample()).backend == named


def test_pattern_holds_zeros_and_the_ones_of_rotations() -> None:
    constants = Constants()
    constants.add("free", np.array([0.0, 1.0, -2.0]))
    constants.add("R", np.array([[0.0, -1.0], [1.0, 0.5]]), rotation=True)
    assert constants.pattern == (0.0, None, None, 0.0, -1.0, 1.0, None)


def test_extended_constants_leave_the_original_alone() -> None:
    constants = Constants()
    constants.add("a", np.array([1.0]))
    more = constants.extended("b", np.array([2.0]))
    np.testing.assert_array_equal(constants.values, [1.0])
    np.testing.assert_array_equal(more.values, [1.0, 2.0])
