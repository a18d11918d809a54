from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stiffkit.errors import ExpressionError
from stiffkit.files.expressions import Expression
from stiffkit.files.parameters import ParameterError, evaluate, resolve
from stiffkit.units import Exponents, parse_quantity

NAMES = {
    "base": parse_quantity("300 mm"),
    "mass": parse_quantity("3 kg"),
    "alpha": parse_quantity("30 deg"),
    "m": parse_quantity(2),
    "zero": parse_quantity(0),
}
NUMBER, LENGTH, AREA = (0, 0, 0), (1, 0, 0), (2, 0, 0)


@pytest.mark.parametrize(
    ("text", "si", "dims"),
    [
        ("= base/2", 0.15, LENGTH),
        ("= -base/2 + 30 mm", -0.12, LENGTH),
        ("= 30mm*2", 0.06, LENGTH),
        ("= 1 + 2 * 3", 7.0, None),
        ("= 8 - 3 - 2", 3.0, None),
        ("= 8 / 4 / 2", 1.0, None),
        ("= (1 + 2) * 3", 9.0, None),
        ("= -2^2", -4.0, None),
        ("= 2^-1", 0.5, None),
        ("= 2^3^2", 512.0, None),
        ("= 2**3", 8.0, None),
        ("= m * base", 0.6, LENGTH),
        ("= base + 1", 1.3, LENGTH),
        ("= base^2", 0.09, AREA),
        ("= 2 m^2 + base*base", 2.09, AREA),
        ("= sqrt(base^2 + (400 mm)^2)", 0.5, LENGTH),
        ("= hypot(base, 400 mm)", 0.5, LENGTH),
        ("= sin(alpha)", 0.5, NUMBER),
        ("= cos(60 deg) * base", 0.15, LENGTH),
        ("= atan2(base, base)", math.pi / 4, NUMBER),
        ("= asin(0.5)", math.pi / 6, NUMBER),
        ("= acos(0.5)", math.pi / 3, NUMBER),
        ("= atan(1)", math.pi / 4, NUMBER),
        ("= tan(45 deg)", 1.0, NUMBER),
        ("= pi", math.pi, None),
        ("= max(base, 1 m, 20 mm)", 1.0, LENGTH),
        ("= min(base, 1)", 0.3, LENGTH),
        ("= abs(-base)", 0.3, LENGTH),
        ("= 5 N m / 1 rad", 5.0, (2, 1, -2)),
        ("= \N{MINUS SIGN}3", -3.0, None),
        ("=" + "1+" * 140 + "1", 141.0, None),
    ],
)
def test_value(text: str, si: float, dims: Exponents | None) -> None:
    value = evaluate(text, NAMES)
    assert value.si == pytest.approx(si, rel=1e-14)
    assert value.dims == dims


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("= base + mass", "a length (300 mm) and a mass (3 kg) cannot be added"),
        ("= base - alpha", "cannot be subtracted"),
        ("= hypot(base, mass)", "cannot stand in one hypot"),
        ("= max(base, mass)", "cannot be compared"),
        ("= sin(base)", "the argument of sin must be an angle"),
        ("= 2^base", "an exponent must be"),
        ("= base^0.3", "cannot be raised"),
        ("= base^1e30", "cannot be raised"),
        ("= 1/zero", "division by zero"),
        ("= zero^-1", "no real number"),
        ("= (-8)^(1/3)", "no real number"),
        ("= asin(2)", "asin(2) is no real number"),
        ("= sqrt(-1)", "no real number"),
        ("= 9**9**9", "too large"),
        ("= 1e300 * 1e300", "too large"),
        ("= 1e400", "too large"),
        ("= bse/2", "did you mean 'base'"),
        ("= 5 N/mm", "a unit stands directly behind a number"),
        ("= 2 base", "write '2 * base'"),
        ("= 3 nM", "did you mean 'nm'"),
        ("= 2 m^x", "the power of a unit is an integer"),
        ("= 1 2", "an operator is expected instead of '2' (character 3)"),
        ("= base +", "a value is expected at the end"),
        ("= * 2", "a value is expected instead of '*' (character 1)"),
        ("= min(base", 'needs quotes: "= min(a, b)"'),
        ("= sin 3", "'(' after sin"),
        ("= sin(1, 2)", "sin takes 1 arguments, 2 are given"),
        ("= min(1)", "min takes 2 or more"),
        ("= base.__class__", "'.' (character 5) has no meaning"),
        ("= __import__('os')", "has no meaning"),
        ("= lambda", "is no parameter"),
        ("=", "a value is expected"),
        ("= " + "(" * 100, "levels deep"),
        ("= " + "-" * 100 + "1", "levels deep"),
        ("= 1" + "^1" * 100, "levels deep"),
        ("= " + "1+" * 200 + "1", "longer than 300 characters"),
    ],
)
def test_errors_say_what_is_wrong(text: str, told: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        evaluate(text, NAMES)
    assert told in str(caught.value)


def test_names_in_an_expression() -> None:
    assert Expression("= a*sin(b) + 3 mm - pi + m").names == {"a", "b", "m"}


def test_parameters_refer_to_each_other_in_any_order() -> None:
    values = resolve({"half": "= base/2", "base": "300 mm", "quarter": "= half/2", "n": 1.5})
    assert list(values) == ["half", "base", "quarter", "n"]
    assert values["quarter"].si == pytest.approx(0.075)
    assert values["quarter"].unit == "m"
    assert values["base"].unit == "mm"
    assert values["n"].dims is None


@pytest.mark.parametrize(
    ("given", "name", "told"),
    [
        ({"a": "= b", "b": "= a"}, "a", "parameter a refers to itself: a -> b -> a"),
        ({"a": "= a + 1"}, "a", "a -> a"),
        ({"a": "= lenght", "length": 1}, "a", "did you mean 'length'"),
        ({"ok": 1, "a": "= 1/0"}, "a", "division by zero"),
        ({"a": "3 nM"}, "a", "no unit"),
    ],
)
def test_parameters_that_cannot_be_resolved(
    given: dict[str, str | float], name: str, told: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        resolve(given)
    assert told in str(caught.value)
    assert caught.value.name == name


def test_a_long_chain_of_parameters_needs_no_recursion() -> None:
    chain: dict[str, str | float] = {f"p{i}": f"= p{i + 1} + 1" for i in range(3000)}
    assert resolve(chain | {"p3000": 0})["p0"].si == 3000.0


@given(st.text(max_size=40) | st.text("0123456789.e+-*/^() ,abmsinqrtpi", max_size=40))
def test_any_text_is_a_value_or_an_error(text: str) -> None:
    with contextlib.suppress(ExpressionError):
        assert math.isfinite(evaluate("=" + text, NAMES).si)
