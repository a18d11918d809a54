"""Arithmetic on quantities: the numbers and their dimensions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from stiffkit.errors import ExpressionError
from stiffkit.units import Exponents, Value, describe

_NO_DIMENSION: Exponents = (0, 0, 0)
_HIGHEST_POWER = 12


def add(left: Value, right: Value) -> Value:
    """Return the sum. Raises ExpressionError where the dimensions differ."""
    return Value(left.si + right.si, _common_dims("be added", left, right))


def subtract(left: Value, right: Value) -> Value:
    """Return the difference. Raises ExpressionError where the dimensions differ."""
    return Value(left.si - right.si, _common_dims("be subtracted", left, right))


def multiply(left: Value, right: Value) -> Value:
    """Return the product; a bare number leaves the dimension of the other as it is."""
    return Value(left.si * right.si, _product_dims(left, right, 1))


def divide(left: Value, right: Value) -> Value:
    """Return the quotient. Raises ExpressionError at a division by zero."""
    if right.si == 0.0:
        raise ExpressionError(f"division by zero: {right} is zero")
    return Value(left.si / right.si, _product_dims(left, right, -1))


def power(base: Value, exponent: Value) -> Value:
    """Return a power. Raises ExpressionError where the exponent has a dimension or fits none."""
    _require_pure("an exponent", exponent)
    try:
        number = math.pow(base.si, exponent.si)
    except ValueError:
        raise ExpressionError(f"{base} ^ {exponent} is no real number") from None
    if base.dims is None or not any(base.dims):
        return Value(number, base.dims)
    ratio = Fraction(exponent.si).limit_denominator(4)
    if float(ratio) != exponent.si or abs(ratio) > _HIGHEST_POWER:
        raise ExpressionError(
            f"{describe(base.dims)} cannot be raised to the power {exponent}",
            mend="powers of quantities with a unit are small integers or simple fractions",
        )
    return Value(number, tuple(ratio * one for one in base.dims))


def negative(value: Value) -> Value:
    """Return the value with the other sign."""
    return Value(-value.si, value.dims)


def _common_dims(what: str, *values: Value) -> Exponents | None:
    """Return the dimension that all values share; bare numbers fit any."""
    first = next((value for value in values if value.dims is not None), None)
    if first is None:
        return None
    for value in values:
        if value.dims is not None and value.dims != first.dims:
            raise ExpressionError(
                f"{describe(first.dims)} ({first}) and {describe(value.dims)} ({value}) "
                f"cannot {what}"
            )
    return first.dims


def _product_dims(left: Value, right: Value, sign: int) -> Exponents | None:
    if left.dims is None and right.dims is None:
        return None
    return tuple(
        a + sign * b
        for a, b in zip(left.dims or _NO_DIMENSION, right.dims or _NO_DIMENSION, strict=True)
    )


def _require_pure(what: str, value: Value) -> None:
    if value.dims is not None and any(value.dims):
        raise ExpressionError(
            f"{what} must be an angle or a pure number, {value} is {describe(value.dims)}"
        )


# --- functions ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Function:
    """A function that expressions may call."""

    fewest: int
    most: int | None
    """Number of arguments; None for any number."""
    apply: Callable[..., Value]


def _of_pure(name: str, function: Callable[[float], float]) -> Function:
    """Return a function of a pure number whose value is a pure number (or an angle)."""

    def apply(value: Value) -> Value:
        _require_pure(f"the argument of {name}", value)
        try:
            return Value(function(value.si), _NO_DIMENSION)
        except ValueError:
            raise ExpressionError(f"{name}({value}) is no real number") from None

    return Function(1, 1, apply)


def _square_root(value: Value) -> Value:
    if value.si < 0.0:
        raise ExpressionError(f"sqrt({value}) is no real number")
    dims = None if value.dims is None else tuple(Fraction(one) / 2 for one in value.dims)
    return Value(math.sqrt(value.si), dims)


def _atan2(y: Value, x: Value) -> Value:
    _common_dims("stand in one atan2", y, x)
    return Value(math.atan2(y.si, x.si), _NO_DIMENSION)


def _hypot(*values: Value) -> Value:
    dims = _common_dims("stand in one hypot", *values)
    return Value(math.hypot(*(value.si for value in values)), dims)


def _smallest(*values: Value) -> Value:
    return Value(min(value.si for value in values), _common_dims("be compared", *values))


def _largest(*values: Value) -> Value:
    return Value(max(value.si for value in values), _common_dims("be compared", *values))


FUNCTIONS: Mapping[str, Function] = {
    "sqrt": Function(1, 1, _square_root),
    "sin": _of_pure("sin", math.sin),
    "cos": _of_pure("cos", math.cos),
    "tan": _of_pure("tan", math.tan),
    "asin": _of_pure("asin", math.asin),
    "acos": _of_pure("acos", math.acos),
    "atan": _of_pure("atan", math.atan),
    "atan2": Function(2, 2, _atan2),
    "hypot": Function(2, None, _hypot),
    "abs": Function(1, 1, lambda value: Value(abs(value.si), value.dims)),
    "min": Function(2, None, _smallest),
    "max": Function(2, None, _largest),
}
CONSTANTS: Mapping[str, Value] = {"pi": Value(math.pi)}
