"""Dimensions of mechanics, and what they are called."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

Exponents = tuple[int | Fraction, ...]
"""Exponents of length, mass and time. An angle has none: rad is 1."""


@dataclass(frozen=True)
class Dimension:
    """A dimension that a number in a file must have."""

    name: str
    dims: Exponents
    example: str


LENGTH = Dimension("a length", (1, 0, 0), "310 mm")
AREA = Dimension("an area", (2, 0, 0), "400 mm^2")
SECOND_MOMENT = Dimension("a second moment of area", (4, 0, 0), "8.5e4 mm^4")
ANGLE = Dimension("an angle", (0, 0, 0), "30 deg")
NUMBER = Dimension("a pure number", (0, 0, 0), "0.3")
MASS = Dimension("a mass", (0, 1, 0), "1.5 kg")
DENSITY = Dimension("a density", (-3, 1, 0), "7850 kg/m^3")
INERTIA = Dimension("a moment of inertia", (2, 1, 0), "0.02 kg m^2")
TIME = Dimension("a time", (0, 0, 1), "10 ms")
FREQUENCY = Dimension("a frequency", (0, 0, -1), "50 Hz")
VELOCITY = Dimension("a velocity", (1, 0, -1), "2 m/s")
ACCELERATION = Dimension("an acceleration", (1, 0, -2), "9.81 m/s^2")
FORCE = Dimension("a force", (1, 1, -2), "100 N")
MOMENT = Dimension("a moment", (2, 1, -2), "5 N m")
PRESSURE = Dimension("a pressure", (-1, 1, -2), "210 GPa")
STIFFNESS_TRANSLATION = Dimension("a translational stiffness", (0, 1, -2), "1e7 N/m")
STIFFNESS_ROTATION = Dimension("a rotational stiffness", (2, 1, -2), "2e4 N m/rad")
COMPLIANCE_TRANSLATION = Dimension("a translational compliance", (0, -1, 2), "1e-5 mm/N")
COMPLIANCE_COUPLING = Dimension("a coupling compliance", (-1, -1, 2), "1e-6 rad/N")
COMPLIANCE_ROTATION = Dimension("a rotational compliance", (-2, -1, 2), "1e-8 rad/(N mm)")

# rad is 1, so some names share their exponents: a message gives both.
_NAMES: dict[Exponents, str] = {
    dimension.dims: dimension.name
    for dimension in (
        LENGTH,
        AREA,
        SECOND_MOMENT,
        MASS,
        DENSITY,
        INERTIA,
        TIME,
        FREQUENCY,
        VELOCITY,
        ACCELERATION,
        FORCE,
        PRESSURE,
        STIFFNESS_TRANSLATION,
        COMPLIANCE_TRANSLATION,
        COMPLIANCE_COUPLING,
        COMPLIANCE_ROTATION,
    )
} | {
    (0, 0, 0): "an angle or a pure number",
    (3, 0, 0): "a volume",
    (2, 1, -2): "a moment or a rotational stiffness",
}


def describe(dims: Exponents | None) -> str:
    """Return the dimension in words, such as "a length"."""
    if dims is None:
        return "a bare number"
    return _NAMES.get(dims) or f"a quantity in {si_unit(dims)}"


_WRITTEN: dict[Exponents, str] = {
    FORCE.dims: "N",
    MOMENT.dims: "N m",
    PRESSURE.dims: "Pa",
    STIFFNESS_TRANSLATION.dims: "N/m",
    COMPLIANCE_TRANSLATION.dims: "m/N",
    COMPLIANCE_COUPLING.dims: "1/N",
    COMPLIANCE_ROTATION.dims: "1/(N m)",
    DENSITY.dims: "kg/m^3",
    FREQUENCY.dims: "1/s",
    VELOCITY.dims: "m/s",
    ACCELERATION.dims: "m/s^2",
}
"""Units as engineers write them, where that is not a product of powers."""

_WRITTEN_WITH_ANGLES: dict[Exponents, str] = {
    ANGLE.dims: "rad",
    STIFFNESS_ROTATION.dims: "N m/rad",
    COMPLIANCE_COUPLING.dims: "rad/N",
    COMPLIANCE_ROTATION.dims: "rad/(N m)",
    FREQUENCY.dims: "rad/s",
}


def si_unit(dims: Exponents, *, angles: bool = False) -> str:
    """Return the SI unit of a dimension, such as "kg m^2" or "N/m"; "" for a pure number.

    With ``angles`` it is written for a quantity that has to do with angles: "N m/rad".
    """
    known = (_WRITTEN_WITH_ANGLES if angles else {}).get(dims) or _WRITTEN.get(dims)
    if known:
        return known
    parts = (
        (symbol, exponent) for symbol, exponent in zip(("kg", "m", "s"), _order(dims), strict=True)
    )
    return " ".join(
        symbol if exponent == 1 else f"{symbol}^{exponent}"
        for symbol, exponent in parts
        if exponent
    )


def _order(dims: Exponents) -> Exponents:
    return (dims[1], dims[0], dims[2]) if dims else (0, 0, 0)
