"""Quantities with units, at the border where text comes in and numbers go out.

Inside stiffkit every number is SI. Files and command lines write ``310 mm`` or ``2e4 N m/rad``; a
bare number is SI and fits any dimension. Text is taken apart here: pint is asked only for single
unit names that the table of common units does not hold, so no arithmetic of the text is ever
evaluated, and pint, which is slow to import, is rarely needed.
"""

from stiffkit.units.dimensions import (
    ACCELERATION,
    ANGLE,
    AREA,
    COMPLIANCE_COUPLING,
    COMPLIANCE_ROTATION,
    COMPLIANCE_TRANSLATION,
    DENSITY,
    FORCE,
    FREQUENCY,
    INERTIA,
    LENGTH,
    MASS,
    MOMENT,
    NUMBER,
    PRESSURE,
    SECOND_MOMENT,
    STIFFNESS_ROTATION,
    STIFFNESS_TRANSLATION,
    TIME,
    VELOCITY,
    Dimension,
    Exponents,
    describe,
    si_unit,
)
from stiffkit.units.quantity import (
    Value,
    format_quantity,
    in_unit,
    parse_quantity,
    si_unit_of,
    to_si,
)
from stiffkit.units.unit import Unit, is_unit, parse_unit, shorten

__all__ = [
    "ACCELERATION",
    "ANGLE",
    "AREA",
    "COMPLIANCE_COUPLING",
    "COMPLIANCE_ROTATION",
    "COMPLIANCE_TRANSLATION",
    "DENSITY",
    "FORCE",
    "FREQUENCY",
    "INERTIA",
    "LENGTH",
    "MASS",
    "MOMENT",
    "NUMBER",
    "PRESSURE",
    "SECOND_MOMENT",
    "STIFFNESS_ROTATION",
    "STIFFNESS_TRANSLATION",
    "TIME",
    "VELOCITY",
    "Dimension",
    "Exponents",
    "Unit",
    "Value",
    "describe",
    "format_quantity",
    "in_unit",
    "is_unit",
    "parse_quantity",
    "parse_unit",
    "shorten",
    "si_unit",
    "si_unit_of",
    "to_si",
]
