"""Expressions in a robot file: ``= base/2 + 30 mm * cos(alpha)``.

The grammar, by recursive descent over a short list of tokens:

    sum     = product {("+" | "-") product}
    product = signed {("*" | "/") signed}
    signed  = ["+" | "-"] signed | power
    power   = atom [("^" | "**") signed]
    atom    = NUMBER [UNIT] | NAME | FUNCTION "(" sum {"," sum} ")" | "(" sum ")"

A name directly behind a number is a unit (``30 mm``, ``5 N m``, ``2 m^2``), anywhere else it is a
parameter; so a parameter may be called ``m``. Dimensions are checked as the value is computed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from stiffkit.errors import ExpressionError, StiffkitError
from stiffkit.files.arithmetic import (
    CONSTANTS,
    FUNCTIONS,
    add,
    divide,
    multiply,
    negative,
    power,
    subtract,
)
from stiffkit.files.names import suggest
from stiffkit.units import Value, is_unit, parse_quantity, shorten

LONGEST_EXPRESSION = 300
"""Characters."""
DEEPEST = 24
"""Levels of parentheses, signs and powers."""

RESERVED_NAMES = frozenset({*FUNCTIONS, *CONSTANTS})
"""Names that no parameter can have."""

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)"
    r"|(?P<name>[^\W\d]\w*|°)|(?P<sign>\*\*|[-+*/^(),]))\s*"
)


def is_expression(text: str) -> bool:
    """Tell whether a text is an expression: it begins with "="."""
    return text.lstrip().startswith("=")


@dataclass(frozen=True)
class _Token:
    kind: str
    """number, unit, name, sign or end."""
    text: str
    column: int
    """From 1."""


class Expression:
    """An expression that has been taken apart, to be evaluated once its names are known."""

    def __init__(self, text: str) -> None:
        """Take ``text``, with or without the "=" in front.

        Raises ExpressionError where it is too long or holds a character that means nothing.
        """
        self.text = text.strip().replace("\N{MINUS SIGN}", "-").removeprefix("=").strip()
        if len(self.text) > LONGEST_EXPRESSION:
            raise ExpressionError(
                f"'= {shorten(self.text)}' is longer than {LONGEST_EXPRESSION} characters",
                mend="name parts of it as parameters",
            )
        self.tokens = self._split()

    @property
    def names(self) -> frozenset[str]:
        """Names of the parameters in it."""
        used = {token.text for token in self.tokens if token.kind == "name"}
        return frozenset(used - RESERVED_NAMES)

    def evaluate(self, names: Mapping[str, Value]) -> Value:
        """Return the value, where ``names`` are the parameters.

        Raises ExpressionError where the expression or its dimensions are wrong, a name is not
        known, or the value is no finite number.
        """
        return _Evaluation(self, names).result()

    def unknown_name(self, name: str, known: Iterable[str]) -> ExpressionError:
        """Return the error for a name that is not among the ``known`` parameters."""
        mend = suggest(name, [*known, *CONSTANTS, *FUNCTIONS])
        if is_unit(name):
            mend = f"a unit stands directly behind a number, as in '5 N / 1 {name}'; {mend}"
        return ExpressionError(
            f"in '= {shorten(self.text)}': '{shorten(name)}' is no parameter", mend=mend
        )

    def _split(self) -> list[_Token]:
        tokens: list[_Token] = []
        position = 0
        while position < len(self.text):
            match = _TOKEN.match(self.text, position)
            if match is None or match.lastgroup is None:
                raise ExpressionError(
                    f"in '= {shorten(self.text)}': '{self.text[position:].split()[0][:1]}' "
                    f"(character {position + 1}) has no meaning"
                )
            kind = match.lastgroup
            if kind == "name" and tokens and tokens[-1].kind in ("number", "unit"):
                kind = "unit"
            tokens.append(_Token(kind, match[match.lastgroup], match.start(match.lastgroup) + 1))
            position = match.end()
        return tokens


class _Evaluation:
    """One pass over the tokens of an expression."""

    def __init__(self, expression: Expression, names: Mapping[str, Value]) -> None:
        self.expression = expression
        self.text = expression.text
        self.tokens = expression.tokens
        self.names = names
        self.position = 0
        self.depth = 0

    def error(self, what: str, mend: str = "") -> ExpressionError:
        return ExpressionError(f"in '= {shorten(self.text)}': {what}", mend=mend)

    def unexpected(self, token: _Token, expected: str) -> ExpressionError:
        if token.kind == "end":
            what = f"{expected} is expected at the end"
            mend = 'inside [ ] and { } an expression with commas needs quotes: "= min(a, b)"'
            is_cut = self.text.count("(") > self.text.count(")")
            return self.error(what, mend if is_cut else "")
        return self.error(
            f"{expected} is expected instead of '{token.text}' (character {token.column})"
        )

    def result(self) -> Value:
        try:
            value = self.sum()
        except OverflowError:
            raise self.error("the value is too large a number") from None
        token = self.peek()
        if token.kind != "end":
            raise self.unexpected(token, "an operator")
        return value

    def peek(self) -> _Token:
        if self.position < len(self.tokens):
            return self.tokens[self.position]
        return _Token("end", "", len(self.text) + 1)

    def take(self) -> _Token:
        token = self.peek()
        self.position += 1
        return token

    def take_sign(self, *signs: str) -> str | None:
        """Take the next token if it is one of these signs."""
        token = self.peek()
        if token.kind != "sign" or token.text not in signs:
            return None
        self.position += 1
        return token.text

    def apply(self, operation: Callable[..., Value], *values: Value) -> Value:
        """Compute, and say in which expression it failed."""
        try:
            value = operation(*values)
        except ExpressionError as error:
            raise self.error(error.what, error.mend) from None
        if not math.isfinite(value.si):
            raise self.error("the value is too large a number")
        return value

    def sum(self) -> Value:
        value = self.product()
        while sign := self.take_sign("+", "-"):
            value = self.apply(add if sign == "+" else subtract, value, self.product())
        return value

    def product(self) -> Value:
        value = self.signed()
        while sign := self.take_sign("*", "/"):
            value = self.apply(multiply if sign == "*" else divide, value, self.signed())
        return value

    def signed(self) -> Value:
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.error(f"nested more than {DEEPEST} levels deep")
        sign = self.take_sign("+", "-")
        if sign is None:
            value = self.power()
        else:
            operand = self.signed()
            value = negative(operand) if sign == "-" else operand
        self.depth -= 1
        return value

    def power(self) -> Value:
        base = self.atom()
        if self.take_sign("^", "**"):
            return self.apply(power, base, self.signed())
        return base

    def atom(self) -> Value:
        token = self.take()
        match token.kind, token.text:
            case "number", _:
                return self.quantity(token)
            case "name", name if name in FUNCTIONS:
                return self.call(name)
            case "name", name:
                return self.named(name)
            case "sign", "(":
                value = self.sum()
                self.close()
                return value
        raise self.unexpected(token, "a value")

    def close(self) -> None:
        if not self.take_sign(")"):
            raise self.unexpected(self.peek(), "')'")

    def quantity(self, number: _Token) -> Value:
        """Read a number and the unit names directly behind it."""
        unit = []
        while self.peek().kind == "unit":
            unit.append(self.take().text + self.unit_power())
        try:
            return parse_quantity(" ".join([number.text, *unit]))
        except StiffkitError as error:
            is_product = any(name in self.names for name in unit)
            mend = f"write '{number.text} * {unit[0]}'" if is_product else error.mend
            raise self.error(error.what, mend) from None

    def unit_power(self) -> str:
        if not self.take_sign("^", "**"):
            return ""
        sign = self.take_sign("+", "-") or ""
        exponent = self.take()
        if not exponent.text.isdecimal():
            raise self.error(
                "the power of a unit is an integer", "put parentheses around the quantity"
            )
        return f"^{sign}{exponent.text}"

    def call(self, name: str) -> Value:
        function = FUNCTIONS[name]
        if not self.take_sign("("):
            raise self.unexpected(self.peek(), f"'(' after {name}")
        arguments = [self.sum()]
        while self.take_sign(","):
            arguments.append(self.sum())
        self.close()
        if not function.fewest <= len(arguments) <= (function.most or len(arguments)):
            wanted = function.fewest if function.most else f"{function.fewest} or more"
            raise self.error(f"{name} takes {wanted} arguments, {len(arguments)} are given")
        return self.apply(function.apply, *arguments)

    def named(self, name: str) -> Value:
        if name in CONSTANTS:
            return CONSTANTS[name]
        if name in self.names:
            return self.names[name]
        raise self.expression.unknown_name(name, self.names)
