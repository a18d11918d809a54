"""Products of small matrices of scalars.

Matrices are object arrays whose entries are scalars in the sense of `stiffkit.smallmat.scalars`.
`numpy.matmul` would do for most of this, but it multiplies structural zeros too, and these are
most of the entries of a mechanism's matrices.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from stiffkit.smallmat.scalars import Scalar, add, multiply, subtract

Matrix = NDArray[np.object_]
Vector = NDArray[np.object_]


def zeros(*shape: int) -> Matrix:
    """Return an array of structural zeros."""
    array = np.empty(shape, dtype=object)
    array.fill(0.0)
    return array


def as_objects(values: NDArray[np.float64]) -> Matrix:
    """Return an object array of Python floats, which are structural constants."""
    array = np.empty(values.shape, dtype=object)
    for index, value in np.ndenumerate(values):
        array[index] = float(value)
    return array


def identity(n: int) -> Matrix:
    """Return the identity as structural constants."""
    return as_objects(np.eye(n))


def vector(entries: Iterable[Scalar]) -> Vector:
    """Return a 1-D object array of scalars, also where a scalar is itself an array."""
    listed = list(entries)
    array = np.empty(len(listed), dtype=object)
    for i, entry in enumerate(listed):
        array[i] = entry
    return array


def _elementwise(operation: Callable[[Scalar, Scalar], Scalar], A: Matrix, B: Matrix) -> Matrix:
    result = np.empty(A.shape, dtype=object)
    for index in np.ndindex(A.shape):
        result[index] = operation(A[index], B[index])
    return result


def plus(A: Matrix, B: Matrix) -> Matrix:
    """Return ``A + B`` of two arrays of one shape."""
    return _elementwise(add, A, B)


def minus(A: Matrix, B: Matrix) -> Matrix:
    """Return ``A - B`` of two arrays of one shape."""
    return _elementwise(subtract, A, B)


def scale(s: Scalar, A: Matrix) -> Matrix:
    """Return ``s A``."""
    result = np.empty(A.shape, dtype=object)
    for index in np.ndindex(A.shape):
        result[index] = multiply(s, A[index])
    return result


def dot(a: Vector, b: Vector) -> Scalar:
    """Return the sum of products of two vectors."""
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        # The zeros are most of the entries; leaving at once is what makes tracing fast.
        if (type(x) is float and x == 0.0) or (type(y) is float and y == 0.0):
            continue
        total = add(total, multiply(x, y))
    return total


def matmul(A: Matrix, B: Matrix) -> Matrix:
    """Return ``A B``; B is a matrix or a vector."""
    if B.ndim == 1:
        return vector(dot(row, B) for row in A)
    result = np.empty((A.shape[0], B.shape[1]), dtype=object)
    for i, j in np.ndindex(result.shape):
        result[i, j] = dot(A[i], B[:, j])
    return result


def symmetric(n: int, entry: Callable[[int, int], Scalar]) -> Matrix:
    """Return the symmetric matrix (n, n) whose lower triangle is ``entry(i, j)``, ``i >= j``."""
    result = np.empty((n, n), dtype=object)
    for i in range(n):
        for j in range(i + 1):
            result[i, j] = result[j, i] = entry(i, j)
    return result


def congruence(A: Matrix, S: Matrix) -> Matrix:
    """Return ``A S A^T`` of a symmetric S, computing one triangle."""
    AS = matmul(A, S)
    return symmetric(A.shape[0], lambda i, j: dot(AS[i], A[j]))


def gram(A: Matrix) -> Matrix:
    """Return ``A^T A``, computing one triangle."""
    return symmetric(A.shape[1], lambda i, j: dot(A[:, i], A[:, j]))


def outer_sum(S: Matrix, u: Vector, weight: Scalar) -> Matrix:
    """Return ``S + weight u u^T`` of a symmetric S."""
    wu = scale(weight, u)
    return symmetric(len(u), lambda i, j: add(S[i, j], multiply(wu[i], u[j])))


def cross(a: Vector, b: Vector) -> Vector:
    """Return the cross product of two 3-vectors."""
    return vector(
        subtract(multiply(a[i], b[j]), multiply(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))
    )


def skew(a: Vector) -> Matrix:
    """Return the 3x3 matrix of ``a x``."""
    result = zeros(3, 3)
    result[2, 1], result[0, 2], result[1, 0] = a
    for i, j in ((1, 2), (2, 0), (0, 1)):
        result[i, j] = multiply(-1.0, result[j, i])
    return result


def lower_triangle(S: Matrix) -> Vector:
    """Return the lower triangle of a symmetric matrix row by row, (n (n + 1) / 2,)."""
    return vector(S[i, j] for i in range(S.shape[0]) for j in range(i + 1))


def from_lower_triangle(entries: Vector) -> Matrix:
    """Return the symmetric matrix of its lower triangle."""
    n = int((np.sqrt(8 * len(entries) + 1) - 1) / 2)
    return symmetric(n, lambda i, j: entries[i * (i + 1) // 2 + j])
