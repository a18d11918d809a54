"""The few operations on scalars that the posture kernels need, whatever a scalar is.

A scalar is a float (one posture), a NumPy array (a batch of postures), a recorded scalar (a batch
whose derivatives are wanted) or a heyoka expression (the kernel is being traced, to be compiled).
A Python float in a batch or in a trace is a *structural* constant: it belongs to the topology of
the robot and is the same in every posture, so a structural 0 or 1 can be left out of the
arithmetic.
"""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np

from stiffkit.smallmat.recorded import Recorded, recorded_where_less

Scalar = Any
"""float, NDArray, Recorded or heyoka.expression; arithmetic operators mean the same for all."""


def is_structural(x: Scalar, value: float) -> bool:
    """Tell whether ``x`` is the constant ``value`` in every posture."""
    return isinstance(x, float) and x == value


def add(a: Scalar, b: Scalar) -> Scalar:
    """Return ``a + b``, keeping structural constants."""
    if is_structural(a, 0.0):
        return b
    if is_structural(b, 0.0):
        return a
    return a + b


def subtract(a: Scalar, b: Scalar) -> Scalar:
    """Return ``a - b``, keeping structural constants."""
    if is_structural(b, 0.0):
        return a
    if is_structural(a, 0.0):
        return -b
    return a - b


def multiply(a: Scalar, b: Scalar) -> Scalar:
    """Return ``a b``, keeping structural constants."""
    if isinstance(a, float):
        if isinstance(b, float):
            return a * b
        return _multiply_structural(a, b)
    if isinstance(b, float):
        return _multiply_structural(b, a)
    return a * b


def _multiply_structural(a: float, b: Scalar) -> Scalar:
    if a == 0.0:
        return 0.0
    if a == 1.0:
        return b
    return -b if a == -1.0 else a * b


def sin(x: Scalar) -> Scalar:
    """Return the sine."""
    return _apply("sin", x)


def cos(x: Scalar) -> Scalar:
    """Return the cosine."""
    return _apply("cos", x)


def sqrt(x: Scalar) -> Scalar:
    """Return the square root."""
    return _apply("sqrt", x)


def arccos(x: Scalar) -> Scalar:
    """Return the angle in [0, pi] of a cosine, which must lie in [-1, 1]."""
    if isinstance(x, np.ndarray):
        return np.arccos(x)
    return _apply("acos", x)


def magnitude(x: Scalar) -> Scalar:
    """Return the absolute value."""
    return where_less(x, 0.0, -x, x)


def where_less(a: Scalar, b: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
    """Return ``then`` where ``a < b`` and ``otherwise`` elsewhere; both are evaluated."""
    if _is_expression(a) or _is_expression(b):
        heyoka = sys.modules["heyoka"]
        return heyoka.select(heyoka.lt(a, b), then, otherwise)
    if any(isinstance(x, Recorded) for x in (a, b, then, otherwise)):
        return recorded_where_less(a, b, then, otherwise)
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.where(np.less(a, b), then, otherwise)
    return then if a < b else otherwise


def reciprocal(x: Scalar) -> Scalar:
    """Return ``1/x``, and infinity at zero instead of an exception."""
    if isinstance(x, float):
        return 1.0 / x if x != 0.0 else math.inf
    return 1.0 / x


def smallest(values: list[Scalar]) -> Scalar:
    """Return the smallest of several scalars, posture by posture."""
    least = values[0]
    for value in values[1:]:
        least = where_less(value, least, value, least)
    return least


def _is_expression(x: Scalar) -> bool:
    return type(x).__module__.partition(".")[0] == "heyoka"


def _apply(name: str, x: Scalar) -> Scalar:
    if isinstance(x, float):
        return getattr(math, name)(x)
    if isinstance(x, np.ndarray):
        return getattr(np, name)(x)
    if isinstance(x, Recorded):
        return x.apply(name)
    return getattr(sys.modules["heyoka"], name)(x)
