"""Every operation gives NumPy's answer for floats, for batches and for compiled expressions."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit import smallmat as sm
from stiffkit.smallmat import Matrix, Scalar, Vector

Array = NDArray[np.float64]
Run = Callable[[Callable[[Vector], Scalar | Matrix], Array], Array]
"""Applies a function of a vector of scalars to columns (n, N); returns (..., N)."""

N = 5


def _by_floats(function: Callable[[Vector], Scalar | Matrix], inputs: Array) -> Array:
    results = [np.array(function(sm.as_objects(column)), dtype=float) for column in inputs.T.copy()]
    return np.stack(results, axis=-1)


def _by_batches(function: Callable[[Vector], Scalar | Matrix], inputs: Array) -> Array:
    result = _entries(function(sm.vector(inputs)))
    batches = [np.broadcast_to(x, inputs.shape[1:]) for x in result.ravel()]
    return np.array(batches, dtype=float).reshape(*result.shape, -1)


def _by_expressions(function: Callable[[Vector], Scalar | Matrix], inputs: Array) -> Array:
    import heyoka

    names = heyoka.make_vars(*(f"x{i}" for i in range(len(inputs))))
    names = names if isinstance(names, list) else [names]
    result = _entries(function(sm.vector(names)))
    expressions = [heyoka.expression(x) if isinstance(x, float) else x for x in result.ravel()]
    compiled = heyoka.cfunc(expressions, names)
    return np.asarray(compiled(np.ascontiguousarray(inputs))).reshape(*result.shape, -1)


def _entries(result: Scalar | Matrix) -> Matrix:
    """Return a result as an object array, a scalar as one without dimensions."""
    if isinstance(result, np.ndarray) and result.dtype == object:
        return result
    entry = np.empty((), dtype=object)
    entry[()] = result
    return entry


@pytest.fixture(params=["floats", "batches", "expressions"])
def run(request: pytest.FixtureRequest) -> Run:
    if request.param == "floats":
        return _by_floats
    if request.param == "batches":
        return _by_batches
    if importlib.util.find_spec("heyoka") is None:
        pytest.skip("heyoka is not installed")
    return _by_expressions


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def at_each(function: Callable[[Array], Any], inputs: Array) -> Array:
    """Return a NumPy function's values (..., N) at columns (n, N)."""
    return np.stack([np.asarray(function(column)) for column in inputs.T], axis=-1)


# Scalars.


@pytest.mark.parametrize(
    ("operation", "reference"),
    [
        (sm.add, np.add),
        (sm.subtract, np.subtract),
        (sm.multiply, np.multiply),
        (lambda a, b: sm.sin(a), lambda a, b: np.sin(a)),
        (lambda a, b: sm.cos(a), lambda a, b: np.cos(a)),
        (lambda a, b: sm.sqrt(a), lambda a, b: np.sqrt(a)),
        (lambda a, b: sm.reciprocal(a), lambda a, b: 1 / a),
        (lambda a, b: sm.where_less(a, b, a, 7.0), lambda a, b: np.where(a < b, a, 7.0)),
        (lambda a, b: sm.where_less(1.0, b, 2.0, a), lambda a, b: np.where(b > 1.0, 2.0, a)),
        (lambda a, b: sm.smallest([a, 1.0, b]), lambda a, b: np.minimum(np.minimum(a, b), 1.0)),
    ],
)
def test_scalar_operations(
    run: Run,
    rng: np.random.Generator,
    operation: Callable[[Scalar, Scalar], Scalar],
    reference: Callable[[Array, Array], Array],
) -> None:
    inputs = rng.uniform(0.1, 2.0, (2, N))
    np.testing.assert_allclose(run(lambda x: operation(*x), inputs), reference(*inputs), rtol=1e-15)


@pytest.mark.parametrize("constant", [0.0, 1.0, -1.0, 2.5])
def test_structural_constants_change_nothing(
    run: Run, rng: np.random.Generator, constant: float
) -> None:
    inputs = rng.normal(size=(1, N))

    def operations(x: Vector) -> Vector:
        return sm.vector(
            op(*pair)
            for op in (sm.add, sm.subtract, sm.multiply)
            for pair in ((x[0], constant), (constant, x[0]))
        )

    (x,) = inputs
    expected = [x + constant, x + constant, x - constant, constant - x, constant * x, constant * x]
    np.testing.assert_allclose(run(operations, inputs), expected, rtol=1e-15)


def test_structural_zeros_are_left_out_of_the_arithmetic() -> None:
    batch = np.ones(3)
    assert sm.multiply(0.0, batch) == 0.0
    assert sm.multiply(1.0, batch) is batch
    assert sm.add(batch, 0.0) is batch
    assert sm.subtract(batch, 0.0) is batch
    assert sm.dot(sm.vector([0.0, batch]), sm.vector([batch, 0.0])) == 0.0


def test_an_array_is_never_structural() -> None:
    assert sm.is_structural(0.0, 0.0)
    assert not sm.is_structural(np.zeros(1), 0.0)
    assert not sm.is_structural(1.0, 0.0)


def test_one_over_zero_is_infinite_not_an_exception() -> None:
    assert sm.reciprocal(0.0) == math.inf


# Matrices.


def square(x: Vector, n: int = 3) -> Matrix:
    return x[: n * n].reshape(n, n)


def symmetric(x: Vector, n: int = 3) -> Matrix:
    A = square(x, n)
    return sm.plus(A, A.T)


@pytest.mark.parametrize(
    ("operation", "reference"),
    [
        (
            lambda x: sm.matmul(square(x), square(x[9:])),
            lambda x: x[:9].reshape(3, 3) @ x[9:18].reshape(3, 3),
        ),
        (lambda x: sm.matmul(square(x), x[9:12]), lambda x: x[:9].reshape(3, 3) @ x[9:12]),
        (lambda x: sm.plus(square(x), square(x[9:])), lambda x: (x[:9] + x[9:]).reshape(3, 3)),
        (lambda x: sm.minus(square(x), square(x[9:])), lambda x: (x[:9] - x[9:]).reshape(3, 3)),
        (lambda x: sm.scale(x[9], square(x)), lambda x: x[9] * x[:9].reshape(3, 3)),
        (lambda x: sm.scale(x[9], x[:3]), lambda x: x[9] * x[:3]),
        (lambda x: sm.dot(x[:4], x[4:8]), lambda x: x[:4] @ x[4:8]),
        (lambda x: sm.cross(x[:3], x[3:6]), lambda x: np.cross(x[:3], x[3:6])),
        (
            lambda x: sm.matmul(sm.skew(x[:3]), x[3:6]),
            lambda x: np.cross(x[:3], x[3:6]),
        ),
        (lambda x: sm.gram(x.reshape(6, 3)), lambda x: x.reshape(6, 3).T @ x.reshape(6, 3)),
        (
            lambda x: sm.congruence(square(x), symmetric(x[9:])),
            lambda x: x[:9].reshape(3, 3) @ _sym(x[9:]) @ x[:9].reshape(3, 3).T,
        ),
        (
            lambda x: sm.outer_sum(symmetric(x), x[9:12], x[12]),
            lambda x: _sym(x[:9]) + x[12] * np.outer(x[9:12], x[9:12]),
        ),
        (
            lambda x: sm.from_lower_triangle(sm.lower_triangle(symmetric(x))),
            lambda x: _sym(x[:9]),
        ),
        (
            lambda x: sm.symmetric(2, lambda i, j: x[i + 2 * j]),
            lambda x: np.array([[x[0], x[1]], [x[1], x[3]]]),
        ),
        (
            lambda x: sm.plus(sm.identity(3), sm.zeros(3, 3)),
            lambda x: np.eye(3),
        ),
    ],
)
def test_matrix_operations(
    run: Run,
    rng: np.random.Generator,
    operation: Callable[[Vector], Matrix],
    reference: Callable[[Array], Array],
) -> None:
    inputs = rng.normal(size=(18, N))
    expected = at_each(reference, inputs)
    np.testing.assert_allclose(run(operation, inputs), expected, rtol=1e-13, atol=1e-13)


def _sym(x: Array) -> Array:
    A = x.reshape(3, 3)
    return A + A.T


def test_lower_triangle_goes_row_by_row() -> None:
    S = sm.as_objects(np.array([[1.0, 2.0, 4.0], [2.0, 3.0, 5.0], [4.0, 5.0, 6.0]]))
    assert list(sm.lower_triangle(S)) == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


# Elimination.


def definite(x: Vector) -> Matrix:
    """Return a positive definite matrix (6, 6) of 36 scalars."""
    A = x[:36].reshape(6, 6)
    return sm.plus(sm.gram(A), sm.identity(6))


def definite_array(x: Array) -> Array:
    A = x[:36].reshape(6, 6)
    return np.asarray(A.T @ A + np.eye(6))


def test_inverse(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(36, N))
    found = run(lambda x: sm.factor(definite(x)).inverse(), inputs)
    expected = at_each(lambda x: np.linalg.inv(definite_array(x)), inputs)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)


def test_solve(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(42, N))
    found = run(lambda x: sm.factor(definite(x)).solve(x[36:]), inputs)
    expected = at_each(lambda x: np.linalg.solve(definite_array(x), x[36:]), inputs)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)


def test_half_solve_gives_the_energy(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(42, N))

    def energy(x: Vector) -> Scalar:
        factors = sm.factor(definite(x))
        half = factors.solve_half(x[36:])
        weighted = [sm.multiply(d, h) for d, h in zip(factors.inverse_pivots, half, strict=True)]
        return sm.dot(half, sm.vector(weighted))

    expected = at_each(lambda x: x[36:] @ np.linalg.solve(definite_array(x), x[36:]), inputs)
    np.testing.assert_allclose(run(energy, inputs), expected, rtol=1e-10)


def test_factors_multiply_to_the_matrix(rng: np.random.Generator) -> None:
    x = rng.normal(size=36)
    factors = sm.factor(definite(sm.as_objects(x)))
    L, D = np.array(factors.L, dtype=float), np.diag(np.array(factors.pivots, dtype=float))
    np.testing.assert_allclose(L @ D @ L.T, definite_array(x), rtol=1e-13, atol=1e-13)
    np.testing.assert_array_equal(L, np.tril(L))


def test_shares_have_no_unit(rng: np.random.Generator) -> None:
    S = definite_array(rng.normal(size=36))
    scaled = np.diag([1e6, 1e-3, 1.0, 1e4, 1e-6, 3.0])
    plain = sm.factor(sm.as_objects(S)).shares
    other = sm.factor(sm.as_objects(scaled @ S @ scaled)).shares
    np.testing.assert_allclose(plain.astype(float), other.astype(float), rtol=1e-9)


def test_semidefinite_factors_solve_within_the_range(run: Run, rng: np.random.Generator) -> None:
    """S of rank 3 and a right side in its range: any solution reproduces the right side."""
    inputs = rng.normal(size=(24, N))

    def reproduced(x: Vector) -> Vector:
        S = sm.gram(x[:18].reshape(3, 6))
        b = sm.matmul(S, x[18:])
        return sm.matmul(S, sm.factor(S, semidefinite=True).solve(b))

    def expected(x: Array) -> Array:
        A = x[:18].reshape(3, 6)
        return np.asarray(A.T @ A @ x[18:])

    np.testing.assert_allclose(run(reproduced, inputs), at_each(expected, inputs), rtol=1e-6)


def test_semidefinite_factors_of_zero() -> None:
    factors = sm.factor(sm.zeros(3, 3), semidefinite=True)
    assert list(factors.solve(sm.vector([0.0, 0.0, 0.0]))) == [0.0, 0.0, 0.0]
    assert list(factors.shares) == [0.0, 0.0, 0.0]


def test_a_scale_tells_rounding_from_stiffness() -> None:
    """1e-9 is a stiffness of its own, and rounding beside 1e6."""
    S = sm.as_objects(np.diag([1.0, 1e-9]))
    scale = sm.as_objects(np.array([1.0, 1e6]))
    assert sm.factor(S, semidefinite=True).inverse_pivots[1] == pytest.approx(1e9)
    assert sm.factor(S, scale=scale, semidefinite=True).inverse_pivots[1] == 0.0


# Passive directions, series and soft directions.


def released_array(K: Array, J: Array) -> Array:
    """Return the stiffness with directions J (6, q) free, by the pseudo-inverse of J^T K J."""
    KJ = K @ J
    return np.asarray(K - KJ @ np.linalg.pinv(J.T @ KJ, rcond=1e-12) @ KJ.T)


def test_release_is_the_block_inverse_of_the_papers(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(48, N))
    found = run(lambda x: sm.release(definite(x), [x[36:42], x[42:48]]), inputs)

    def block_inverse(x: Array) -> Array:
        S, J = np.linalg.inv(definite_array(x)), x[36:48].reshape(2, 6).T
        return np.linalg.inv(np.block([[S, J], [J.T, np.zeros((2, 2))]]))[:6, :6]

    expected = at_each(block_inverse, inputs)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-10)


def test_released_directions_carry_no_load(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(48, N))

    def loads(x: Vector) -> Matrix:
        K = sm.release(definite(x), [x[36:42], x[42:48]])
        return sm.matmul(K, sm.vector([*x[36:42]]))

    np.testing.assert_allclose(run(loads, inputs), 0.0, atol=1e-12)


@pytest.mark.parametrize("given_scale", [False, True])
def test_redundant_directions_are_skipped(
    run: Run, rng: np.random.Generator, given_scale: bool
) -> None:
    """The third direction is a sum of the first two, the fourth one of them again."""
    inputs = rng.normal(size=(48, N))

    def found(x: Vector) -> Matrix:
        K, u, v = definite(x), x[36:42], x[42:48]
        both = sm.plus(u, sm.scale(-2.0, v))
        scale = sm.vector(K[i, i] for i in range(6)) if given_scale else None
        return sm.release(K, [u, v, both, u], scale=scale)

    expected = at_each(
        lambda x: released_array(definite_array(x), x[36:48].reshape(2, 6).T), inputs
    )
    np.testing.assert_allclose(run(found, inputs), expected, rtol=1e-8, atol=1e-9)


def test_all_six_directions_released_leave_nothing(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(36, N))

    def found(x: Vector) -> Matrix:
        return sm.release(definite(x), list(sm.identity(6)))

    np.testing.assert_allclose(run(found, inputs), 0.0, atol=1e-12)


@pytest.mark.parametrize("position", [0, 1])
def test_a_zero_direction_releases_nothing(
    run: Run, rng: np.random.Generator, position: int
) -> None:
    inputs = rng.normal(size=(42, N))

    def found(x: Vector) -> Matrix:
        directions = [x[36:42]]
        directions.insert(position, sm.zeros(6))
        return sm.release(definite(x), directions)

    expected = at_each(lambda x: released_array(definite_array(x), x[36:42, None]), inputs)
    np.testing.assert_allclose(run(found, inputs), expected, rtol=1e-9, atol=1e-11)


def test_no_directions_leave_the_stiffness(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(36, N))
    found = run(lambda x: sm.release(definite(x), []), inputs)
    np.testing.assert_allclose(found, at_each(definite_array, inputs), rtol=1e-13)


def semidefinite(x: Vector) -> tuple[Matrix, Vector]:
    """Return a stiffness (6, 6) that x[36:42] does not strain, and its diagonal before that."""
    K = definite(x)
    return sm.release(K, [x[36:42]]), sm.vector(K[i, i] for i in range(6))


def test_release_of_a_stiffness_that_has_free_motions(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(48, N))

    def found(x: Vector) -> Matrix:
        K, scale = semidefinite(x)
        return sm.release(K, [x[36:42], x[42:48]], scale=scale)

    expected = at_each(
        lambda x: released_array(definite_array(x), x[36:48].reshape(2, 6).T), inputs
    )
    np.testing.assert_allclose(run(found, inputs), expected, rtol=1e-8, atol=1e-9)


def test_series_adds_compliances(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(72, N))

    def found(x: Vector) -> Matrix:
        K1, K2 = definite(x), definite(x[36:])
        return sm.series(K1, K2, sm.vector(K1[i, i] + K2[i, i] for i in range(6)))

    def expected(x: Array) -> Array:
        k1, k2 = (np.linalg.inv(definite_array(part)) for part in (x[:36], x[36:]))
        return np.linalg.inv(k1 + k2)

    np.testing.assert_allclose(run(found, inputs), at_each(expected, inputs), rtol=1e-7, atol=1e-9)


def test_series_of_semidefinite_stiffnesses(run: Run, rng: np.random.Generator) -> None:
    """Two stiffnesses, each with a free motion: the chain has both."""
    inputs = rng.normal(size=(84, N))

    def found(x: Vector) -> Matrix:
        K1, scale1 = semidefinite(x[:42])
        K2, scale2 = semidefinite(x[42:])
        return sm.series(K1, K2, sm.plus(scale1, scale2))

    def expected(x: Array) -> Array:
        K1, K2 = (released_array(definite_array(y), y[36:42, None]) for y in (x[:42], x[42:]))
        return K1 - K1 @ np.linalg.pinv(K1 + K2, rcond=1e-10) @ K1

    K = run(found, inputs)
    np.testing.assert_allclose(K, at_each(expected, inputs), rtol=1e-6, atol=1e-8)
    for n in range(N):
        np.testing.assert_allclose(K[..., n] @ inputs[36:42, n], 0.0, atol=1e-9)
        np.testing.assert_allclose(K[..., n] @ inputs[78:84, n], 0.0, atol=1e-9)


def test_series_of_stiffnesses_that_are_free_alike(run: Run, rng: np.random.Generator) -> None:
    """A common free motion leaves a zero pivot in their sum."""
    inputs = rng.normal(size=(78, N))

    def found(x: Vector) -> Matrix:
        K1, scale1 = semidefinite(x[:42])
        K2, scale2 = semidefinite(sm.vector([*x[42:], *x[36:42]]))
        return sm.series(K1, K2, sm.plus(scale1, scale2))

    def expected(x: Array) -> Array:
        K1, K2 = (released_array(definite_array(y), x[36:42, None]) for y in (x[:36], x[42:]))
        return K1 - K1 @ np.linalg.pinv(K1 + K2, rcond=1e-10) @ K1

    np.testing.assert_allclose(run(found, inputs), at_each(expected, inputs), rtol=1e-6, atol=1e-8)


def test_soften_adds_a_compliance_along_one_direction(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(43, N))
    inputs[42] = np.array([0.0, 1e-3, 0.1, 1.0, 10.0])
    found = run(lambda x: sm.soften(definite(x), x[36:42], x[42]), inputs)

    def expected(x: Array) -> Array:
        k = np.linalg.inv(definite_array(x)) + x[42] * np.outer(x[36:42], x[36:42])
        return np.linalg.inv(k)

    np.testing.assert_allclose(found, at_each(expected, inputs), rtol=1e-8, atol=1e-10)


def test_soften_keeps_free_motions(run: Run, rng: np.random.Generator) -> None:
    inputs = rng.normal(size=(42, N))

    def found(x: Vector) -> Matrix:
        K, _ = semidefinite(x)
        return sm.soften(K, x[36:42], 1.0)

    expected = at_each(lambda x: released_array(definite_array(x), x[36:42, None]), inputs)
    np.testing.assert_allclose(run(found, inputs), expected, rtol=1e-9, atol=1e-10)
