"""Parameters: named quantities that may refer to each other in any order."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from graphlib import CycleError, TopologicalSorter

from stiffkit.errors import ExpressionError, UnitError
from stiffkit.files.expressions import Expression, is_expression
from stiffkit.units import Value, describe, parse_quantity, si_unit

Given = str | float | Value
"""A quantity as somebody writes it: ``310 mm``, ``= base/2``, or a bare SI number."""


class ParameterError(ExpressionError):
    """A parameter that cannot be resolved; ``name`` tells which."""

    def __init__(self, name: str, what: str, *, mend: str = "") -> None:
        """Keep the ``name`` of the parameter."""
        super().__init__(what, mend=mend)
        self.name = name


def evaluate(given: Given, names: Mapping[str, Value]) -> Value:
    """Return what a text or a number says, where ``names`` are the parameters.

    Raises UnitError or ExpressionError where it cannot be read or evaluated.
    """
    if not (isinstance(given, str) and is_expression(given)):
        return parse_quantity(given)
    value = _taken_apart(given).evaluate(names)
    unit = "" if value.dims is None else si_unit(value.dims)
    return Value(value.si, value.dims, text=given.strip(), unit=unit)


@lru_cache(maxsize=4096)
def _taken_apart(text: str) -> Expression:
    """Return an expression; the same text is met again in each variant of a robot."""
    return Expression(text)


def resolve(given: Mapping[str, Given]) -> dict[str, Value]:
    """Return the values of parameters, in the order in which they are given.

    Raises ParameterError at one that cannot be read or evaluated, and where they refer to each
    other in a circle.
    """
    values: dict[str, Value] = {}
    for name in _order(given):
        try:
            values[name] = evaluate(given[name], values)
        except (UnitError, ExpressionError) as error:
            raise ParameterError(name, error.what, mend=error.mend) from None
    return {name: values[name] for name in given}


def _order(given: Mapping[str, Given]) -> list[str]:
    """Return the names so that each comes after those it refers to."""
    graph = {name: _references(name, given) for name in given}
    try:
        return list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        # Each name of the cycle is one that the next refers to.
        circle = list(reversed(error.args[1]))
        raise ParameterError(
            circle[0],
            f"parameter {circle[0]} refers to itself: {' -> '.join(circle)}",
            mend="give one of them a value of its own",
        ) from None


def _references(name: str, given: Mapping[str, Given]) -> frozenset[str]:
    text = given[name]
    if not (isinstance(text, str) and is_expression(text)):
        return frozenset()
    try:
        expression = _taken_apart(text)
        for used in sorted(expression.names - given.keys()):
            raise expression.unknown_name(used, given)
    except ExpressionError as error:
        raise ParameterError(name, error.what, mend=error.mend) from None
    return expression.names


def check_same_dimension(name: str, old: Value, new: Value) -> None:
    """Raise UnitError where a parameter would change from one dimension to another."""
    if old.dims is not None and new.dims is not None and old.dims != new.dims:
        raise UnitError(
            f"'{new}' is {describe(new.dims)}, parameter {name} is {describe(old.dims)} ({old})"
        )
