from __future__ import annotations

import contextlib
import math
import subprocess
import sys

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stiffkit.errors import UnitError
from stiffkit.units import (
    ANGLE,
    DENSITY,
    FORCE,
    INERTIA,
    LENGTH,
    MOMENT,
    PRESSURE,
    STIFFNESS_ROTATION,
    STIFFNESS_TRANSLATION,
    Dimension,
    Value,
    format_quantity,
    parse_quantity,
    parse_unit,
    si_unit_of,
    to_si,
)


@pytest.mark.parametrize(
    ("text", "dimension", "si"),
    [
        ("310 mm", LENGTH, 0.31),
        ("350mm", LENGTH, 0.35),
        ("-5 µm", LENGTH, -5e-6),
        ("\N{MINUS SIGN}5 um", LENGTH, -5e-6),
        (".5 m", LENGTH, 0.5),
        ("12 in", LENGTH, 0.3048),
        ("180 deg", ANGLE, math.pi),
        ("30°", ANGLE, math.pi / 6),
        ("1 mrad", ANGLE, 1e-3),
        ("1e5 N/mm", STIFFNESS_TRANSLATION, 1e8),
        ("2 N/um", STIFFNESS_TRANSLATION, 2e6),
        ("2e4 N m/rad", STIFFNESS_ROTATION, 2e4),
        ("2e4 N*m/rad", STIFFNESS_ROTATION, 2e4),
        ("3 Nm/rad", STIFFNESS_ROTATION, 3.0),
        ("5 N m", MOMENT, 5.0),
        ("1.5 kN", FORCE, 1500.0),
        ("210 GPa", PRESSURE, 210e9),
        ("7850 kg/m^3", DENSITY, 7850.0),
        ("7.85 g/cm³", DENSITY, 7850.0),
        ("4 kg mm^2", INERTIA, 4e-6),
        ("4 kg*mm**2", INERTIA, 4e-6),
        ("0.2", LENGTH, 0.2),
        (0.2, FORCE, 0.2),
        (3, LENGTH, 3.0),
    ],
)
def test_quantity_in_si(text: str | float, dimension: Dimension, si: float) -> None:
    assert to_si(text, dimension) == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize("text", ["350 mm", "0.1 kN", "70 GPa", "2.7 kN/um"])
def test_decimal_units_round_once(text: str) -> None:
    # 350 * 0.001 is 0.35000000000000003.
    exact = {"350 mm": 0.35, "0.1 kN": 100.0, "70 GPa": 70e9, "2.7 kN/um": 2.7e9}
    assert parse_quantity(text).si == exact[text]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("310 kg", "'310 kg' is a mass, a length is expected (for example '310 mm')"),
        ("5 N", "'5 N' is a force"),
        ("5 N m", "a moment or a rotational stiffness"),
        ("30 deg", "an angle or a pure number"),
    ],
)
def test_wrong_dimension_is_named(text: str, told: str) -> None:
    with pytest.raises(UnitError) as caught:
        to_si(text, LENGTH)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("3 nM", "did you mean 'nm'"),
        ("3 MM", "did you mean 'mm'"),
        ("3 KN", "did you mean 'kN'"),
        ("3 Mpa", "did you mean 'MPa'"),
        ("20 degC", "no unit"),
        ("20 degF", "no unit"),
        ("3 dB", "no unit"),
        ("3 A", "no unit"),
        ("nan", "no quantity"),
        ("inf m", "no quantity"),
        ("1e400 m", "too large"),
        ("9**9**9", "no unit"),
        ("9 m**9**9", "no unit"),
        ("3 m^99999", "small integer"),
        ("3 m^0.5", "no unit"),
        ("3 (m", "not closed"),
        ("3 m)", "no unit"),
        ("3 m//s", "no unit"),
        ("3,5 mm", "decimal point"),
        ("mm", "no quantity"),
        ("", "no quantity"),
        ("1_000 mm", "no unit"),
        ("__import__('os')", "no quantity"),
        ("1 " + "m " * 200, "no quantity"),
    ],
)
def test_what_cannot_be_read_is_refused(text: str, told: str) -> None:
    with pytest.raises(UnitError) as caught:
        parse_quantity(text)
    assert told in str(caught.value)


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 10**400])
def test_numbers_that_are_not_finite_are_refused(number: float) -> None:
    with pytest.raises(UnitError, match="not finite"):
        parse_quantity(number)


def test_tiny_exponents_are_zero_and_take_no_memory() -> None:
    assert parse_quantity("1e-999999999 m").si == 0.0


def test_bare_number_has_no_dimension() -> None:
    assert parse_quantity("3") == Value(3.0, None)
    assert parse_quantity("3 rad") == Value(3.0, (0, 0, 0))


COMMON = (
    *("mm", "um", "cm", "km", "g", "mg", "kg", "t", "ms", "Hz", "kN", "MN", "mN", "MPa", "GPa"),
    *("kPa", "deg", "mrad", "N/um", "kg/m^3", "1/s", "N*m", "rad/N"),
)


@pytest.mark.parametrize("unit", COMMON)
def test_the_table_of_common_units_agrees_with_pint(unit: str) -> None:
    expected = pint.UnitRegistry().Quantity(1.0, unit).to_base_units().magnitude
    assert float(parse_unit(unit).factor) == pytest.approx(expected, rel=1e-15)


def test_quantities_are_written_in_a_unit() -> None:
    assert format_quantity(0.31, "mm") == "310 mm"
    assert format_quantity(math.pi / 6, "deg") == "30 deg"
    assert format_quantity(1 / 3, "") == "0.333333"
    assert format_quantity(2.5e8, "N/mm", digits=3) == "2.5e+05 N/mm"
    assert format_quantity(math.nan, "mm") == "nan mm"
    with pytest.raises(UnitError):
        format_quantity(1.0, "mmm")


@given(
    st.floats(-1e12, 1e12).filter(lambda x: x == 0 or abs(x) > 1e-12),
    st.sampled_from(["mm", "kN/um", "deg", "in"]),
)
def test_writing_and_reading_gives_the_number_back(si: float, unit: str) -> None:
    text = format_quantity(si, unit, digits=17)
    assert parse_quantity(text).si == pytest.approx(si, rel=1e-14)


@given(st.text(max_size=30) | st.text("0123456789.eE+-*/^() mNkgrad_", max_size=30))
def test_any_text_is_a_quantity_or_an_error(text: str) -> None:
    with contextlib.suppress(UnitError):
        assert math.isfinite(parse_quantity(text).si)


@pytest.mark.parametrize(
    ("written", "si"),
    [
        *(("mm", "m"), ("deg", "rad"), ("", ""), ("kN", "N"), ("Nmm", "N m"), ("GPa", "Pa")),
        *(("kN/mm", "N/m"), ("N m/rad", "N m/rad"), ("N mm/deg", "N m/rad"), ("mm/N", "m/N")),
        *(("rad/N", "rad/N"), ("rad/(N mm)", "rad/(N m)"), ("g/mm^3", "kg/m^3"), ("1/ms", "1/s")),
        *(("mm^4", "m^4"), ("kg mm^2", "kg m^2"), ("deg/s", "rad/s"), ("kg mm/s", "kg m s^-1")),
    ],
)
def test_si_units_are_written_as_engineers_write_them(written: str, si: str) -> None:
    assert si_unit_of(written) == si
    assert parse_unit(si).dims == parse_unit(written).dims


def test_common_units_do_not_import_pint() -> None:
    code = (
        "import sys; from stiffkit.units import parse_quantity; parse_quantity('2e4 N m/rad');"
        "sys.exit('pint' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
