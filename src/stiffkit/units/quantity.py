"""Quantities: a number and its unit, read from text and written as text."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache

from stiffkit.errors import UnitError
from stiffkit.units.dimensions import Dimension, Exponents, describe, si_unit
from stiffkit.units.unit import LONGEST_TEXT, parse_unit, shorten


@dataclass(frozen=True)
class Value:
    """A number with its dimension."""

    si: float
    dims: Exponents | None = None
    """Exponents of length, mass and time; None for a bare number, which fits any dimension."""
    text: str = field(default="", compare=False)
    """What was written, for messages."""
    unit: str = field(default="", compare=False)
    """The unit it was written with, "" for a bare number."""

    def __str__(self) -> str:
        """Return what was written, or else the SI value with its unit."""
        return self.text or f"{self.si:.6g} {si_unit(self.dims or ())}".strip()


_QUANTITY = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*)", re.DOTALL)


def parse_quantity(given: str | float | Value) -> Value:
    """Return the quantity that a text such as ``310 mm``, or a bare number, says.

    Raises UnitError where the number or its unit cannot be read, or the number is not finite.
    """
    if isinstance(given, Value):
        return given
    if isinstance(given, str):
        return _parse_text(given)
    if isinstance(given, bool):
        raise UnitError(f"'{given}' is no number", mend="give a number, for example '310 mm'")
    try:
        number = float(given)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise UnitError("a number is not finite, or too large to compute with")
    return Value(number, None, text=f"{given:.12g}")


@lru_cache(maxsize=4096)
def _parse_text(given: str) -> Value:
    text = given.strip().replace("\N{MINUS SIGN}", "-")
    match = _QUANTITY.fullmatch(text)
    if match is None or len(text) > LONGEST_TEXT:
        raise UnitError(
            f"'{shorten(text)}' is no quantity",
            mend="write a number and its unit, for example '310 mm', or a bare number in SI units",
        )
    number, unit_text = match.groups()
    if unit_text[:1] == ",":
        raise UnitError(f"'{text}' has a comma", mend="write a decimal point")
    unit = parse_unit(unit_text)
    si = _scaled(number, unit.factor)
    if not math.isfinite(si):
        raise UnitError(f"'{text}' is too large a number")
    return Value(si, unit.dims if unit_text else None, text=text, unit=unit_text)


def _scaled(number: str, factor: Fraction) -> float:
    """Return number times factor, rounded once; inf where that is too large for a float."""
    rough = float(number)
    # The exact fraction of 1e-999999999 would fill the memory: ask the float first.
    if rough == 0.0 or not math.isfinite(rough):
        return rough
    try:
        return float(Fraction(number) * factor)
    except OverflowError:
        return math.inf


def to_si(given: str | float | Value, dimension: Dimension) -> float:
    """Return the SI value of a quantity that must have a dimension; a bare number is SI already.

    Raises UnitError where it has another one.
    """
    value = parse_quantity(given)
    if value.dims is not None and value.dims != dimension.dims:
        raise UnitError(
            f"'{value}' is {describe(value.dims)}, {dimension.name} is expected "
            f"(for example '{dimension.example}')"
        )
    return value.si


def format_quantity(si: float, unit: str, *, digits: int = 6) -> str:
    """Return an SI value as text in a unit, such as ``310 mm``, with so many significant digits.

    Raises UnitError where the unit is not known.
    """
    return f"{in_unit(si, unit):.{digits}g} {unit}".rstrip()


def in_unit(si: float, unit: str) -> float:
    """Return an SI value as a number of units. Raises UnitError where the unit is not known."""
    factor = parse_unit(unit).factor
    return float(Fraction(si) / factor) if math.isfinite(si) else si


_ANGLE = re.compile(r"rad|deg|°|arc|turn|rev")


def si_unit_of(unit: str) -> str:
    """Return the SI unit of what is written in a unit: "N/m" for kN/mm, "rad" for deg.

    Where the unit names an angle, so does that: "N m/rad" for N mm/deg. It is "" for a number.
    Raises UnitError where the unit is not known.
    """
    return si_unit(parse_unit(unit).dims, angles=_ANGLE.search(unit) is not None)
