"""Units: their names, and the text that combines them."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any

from stiffkit.errors import UnitError
from stiffkit.units.dimensions import Exponents

LONGEST_TEXT = 100
"""Characters of a quantity or a unit."""

_HIGHEST_POWER = 12


@dataclass(frozen=True)
class Unit:
    """A unit: what one of it is in SI, and its dimension."""

    factor: Fraction
    """Exact where the unit is a decimal one, so that 350 mm is 0.35 and not 0.35000000000000003."""
    dims: Exponents


_PREFIXES = {
    "n": Fraction(1, 10**9),
    "u": Fraction(1, 10**6),
    "\N{MICRO SIGN}": Fraction(1, 10**6),
    "\N{GREEK SMALL LETTER MU}": Fraction(1, 10**6),
    "m": Fraction(1, 10**3),
    "c": Fraction(1, 10**2),
    "": Fraction(1),
    "k": Fraction(10**3),
    "M": Fraction(10**6),
    "G": Fraction(10**9),
}
_MICRO = ("u", "\N{MICRO SIGN}", "\N{GREEK SMALL LETTER MU}")
_DEGREE = Unit(Fraction(math.pi) / 180, (0, 0, 0))


def _family(
    symbol: str, prefixes: tuple[str, ...], factor: Fraction, dims: Exponents
) -> dict[str, Unit]:
    """Return the units of one symbol with several prefixes."""
    return {prefix + symbol: Unit(_PREFIXES[prefix] * factor, dims) for prefix in prefixes}


_COMMON: Mapping[str, Unit] = {
    **_family("m", ("n", *_MICRO, "m", "c", "", "k"), Fraction(1), (1, 0, 0)),
    **_family("g", ("m", "", "k"), Fraction(1, 1000), (0, 1, 0)),
    **_family("t", ("",), Fraction(1000), (0, 1, 0)),
    **_family("s", ("n", *_MICRO, "m", ""), Fraction(1), (0, 0, 1)),
    **_family("Hz", ("", "k", "M"), Fraction(1), (0, 0, -1)),
    **_family("N", ("m", "", "k", "M"), Fraction(1), (1, 1, -2)),
    **_family("Nm", ("m", "", "k", "M"), Fraction(1), (2, 1, -2)),
    **_family("Nmm", ("", "k"), Fraction(1, 1000), (2, 1, -2)),
    **_family("Pa", ("", "k", "M", "G"), Fraction(1), (-1, 1, -2)),
    **_family("rad", (*_MICRO, "m", ""), Fraction(1), (0, 0, 0)),
    "deg": _DEGREE,
    "°": _DEGREE,
}

_UNIT_TOKEN = re.compile(
    r"\s*(?:(?P<raised>[²³])|(?P<name>[^\W\d_²³][^\W\d²³]*|°)|(?P<power>\*\*|\^)"
    r"|(?P<sign>[*/()·])|(?P<integer>[+-]?[0-9]+))\s*"
)
_ONE = Unit(Fraction(1), (0, 0, 0))


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> Unit:
    """Return the unit that a text such as ``N m/rad`` or ``kg/m^3`` says; "" is the unit 1.

    Products (a blank, ``*``), quotients, integer powers and parentheses are known; what follows a
    quotient is taken from left to right, as everywhere. Raises UnitError where a name is unknown.
    """
    if not text.strip():
        return _ONE
    common = _COMMON.get(text)
    return common if common is not None else _UnitText(text).parse()


def is_unit(name: str) -> bool:
    """Tell whether a single name is a unit that is known here."""
    try:
        parse_unit(name)
    except UnitError:
        return False
    return True


class _UnitText:
    """Recursive descent over the tokens of a unit."""

    def __init__(self, text: str) -> None:
        self.text = text
        if len(text) > LONGEST_TEXT:
            raise self.error("is too long for a unit")
        self.tokens = self.split()
        self.position = 0

    def error(self, what: str) -> UnitError:
        return UnitError(
            f"'{shorten(self.text)}' {what}", mend="write a unit such as 'N m/rad' or 'kg/m^3'"
        )

    def split(self) -> list[tuple[str, str]]:
        tokens, position = [], 0
        while position < len(self.text):
            match = _UNIT_TOKEN.match(self.text, position)
            if match is None or match.lastgroup is None:
                raise self.error("is no unit")
            tokens.append((match.lastgroup, match[match.lastgroup]))
            position = match.end()
        return tokens

    def peek(self) -> tuple[str, str]:
        return self.tokens[self.position] if self.position < len(self.tokens) else ("end", "")

    def take(self) -> tuple[str, str]:
        token = self.peek()
        self.position += 1
        return token

    def parse(self) -> Unit:
        unit = self.product()
        if self.peek()[0] != "end":
            raise self.error("is no unit")
        return unit

    def product(self) -> Unit:
        unit = self.factor()
        while True:
            kind, sign = self.peek()
            if sign in ("*", "/", "·"):
                self.take()
            elif kind != "name" and sign != "(":
                return unit
            unit = _times(unit, self.factor(), -1 if sign == "/" else 1)

    def factor(self) -> Unit:
        kind, text = self.take()
        if kind == "name":
            # Only a name takes a power: powers of powers would make numbers that fill the memory.
            return _times(_ONE, _named_unit(text), self.power())
        if text == "(":
            unit = self.product()
            if self.take()[1] != ")":
                raise self.error("has a parenthesis that is not closed")
            return unit
        if text == "1":
            return _ONE
        raise self.error("is no unit")

    def power(self) -> int:
        kind, text = self.peek()
        if kind == "raised":
            self.take()
            return 2 if text == "²" else 3
        if kind != "power":
            return 1
        self.take()
        kind, text = self.take()
        if kind != "integer" or len(text) > 3 or abs(int(text)) > _HIGHEST_POWER:
            raise self.error(f"needs a small integer after '^', at most {_HIGHEST_POWER}")
        return int(text)


def _times(left: Unit, right: Unit, power: int) -> Unit:
    dims = tuple(a + power * b for a, b in zip(left.dims, right.dims, strict=True))
    return Unit(left.factor * right.factor**power, dims)


def _named_unit(name: str) -> Unit:
    unit = _COMMON.get(name) or _registered_unit(name)
    if unit is None:
        raise UnitError(f"'{name}' is no unit known here", mend=_unit_hint(name))
    return unit


def _unit_hint(name: str) -> str:
    same = [known for known in _COMMON if known.lower() == name.lower()]
    close = same or difflib.get_close_matches(name, _COMMON, n=3, cutoff=0.5)
    listed = " or ".join(f"'{unit}'" for unit in close)
    return f"did you mean {listed}?" if close else "for example mm, deg, N, kg, GPa, N m/rad"


@cache
def _registered_unit(name: str) -> Unit | None:
    """Return a mechanical unit that pint knows, None where it knows none of this name."""
    registry = _registry()
    if not registry.parse_unit_name(name):
        return None
    quantity = registry.Quantity(1, name)
    # An offset or a logarithm (degC, dB) is no factor; molar or ampere are not of mechanics.
    exponents = dict(quantity.dimensionality)
    dims = tuple(Fraction(exponents.pop(base, 0)) for base in ("[length]", "[mass]", "[time]"))
    if exponents or not quantity._is_multiplicative:
        return None
    return Unit(Fraction(float(quantity.to_base_units().magnitude)), dims)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


def shorten(text: str, longest: int = 60) -> str:
    """Return a text on one line, cut where it is too long for a message."""
    line = " ".join(text.split())
    return line if len(line) <= longest else line[: longest - 3] + "..."
