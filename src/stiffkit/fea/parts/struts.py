"""Hollow bars and legs: a box tube whose ends are eyes or forks on pins along z.

All of them have x from the base's pin to the tip's, z along the pins, and the origin on the
base's pin, in the middle of its length.
"""

from __future__ import annotations

from typing import Any

from stiffkit.fea.geometry import MM
from stiffkit.fea.parts.parametric import (
    Dimensions,
    ParametricPart,
    PartDimension,
    bored,
    millimetres,
    require,
)

_TABLE_7 = "inferred: the box whose area and second moments give Table 7's single-beam row"
_CHOSEN = "chosen"


def _end_dimensions(end_width: float, bore: float, reach: float, cap: float) -> list[PartDimension]:
    return [
        PartDimension("end_width", end_width, "width of eyes and cheeks along y", _CHOSEN),
        PartDimension("bore", bore, "diameter of the bores for the pins", _CHOSEN),
        PartDimension("reach", reach, "from a pin's axis to where the end closes", _CHOSEN),
        PartDimension("cap", cap, "length of the solid piece between an end and the tube", _CHOSEN),
    ]


def _fork_dimensions(gap: float, cheek: float, rounding: float) -> list[PartDimension]:
    return [
        PartDimension("gap", gap, "between the cheeks of a fork, along z", _CHOSEN),
        PartDimension("cheek", cheek, "thickness of a cheek, along z", _CHOSEN),
        PartDimension("rounding", rounding, "radius of the inner corners of a fork", _CHOSEN),
    ]


def _check(d: Dimensions) -> None:
    """Raise `CadError` where tube and ends do not fit together."""
    require(
        d["wall"] < min(d["width"], d["height"]) / 2.0,
        f"a wall of {millimetres(d['wall'])} leaves no hole in a tube of {millimetres(d['width'])}"
        f" by {millimetres(d['height'])}",
        "make the wall thinner",
    )
    require(
        d["bore"] < 0.9 * d["end_width"],
        f"a bore of {millimetres(d['bore'])} does not fit into ends of"
        f" {millimetres(d['end_width'])}",
        "make the bore smaller, or end_width larger",
    )
    require(
        d["reach"] > 0.55 * d["bore"],
        f"the pin of {millimetres(d['bore'])} does not fit into a reach of"
        f" {millimetres(d['reach'])}",
        "make reach larger",
    )
    ends = 2.0 * (d["reach"] + d["cap"])
    require(
        d["length"] > 1.05 * ends,
        f"the two ends are {millimetres(ends)} long and leave no room for a tube in a length of"
        f" {millimetres(d['length'])}",
        "make the length larger, or reach and cap smaller",
    )


def _check_fork(d: Dimensions) -> None:
    _check(d)
    require(
        d["rounding"] < min(0.45 * d["gap"], 0.9 * (d["reach"] - d["bore"] / 2.0)),
        f"corners of radius {millimetres(d['rounding'])} do not fit into the fork",
        "make the rounding smaller",
    )


def _eye(d: Dimensions) -> Any:
    """Return an eye on the pin at the origin that reaches along +x."""
    return _plan(d, d["eye"] / MM)


def _fork(d: Dimensions) -> Any:
    """Return a fork on the pin at the origin that reaches along +x, with its web."""
    from netgen.occ import Axes, WorkPlane, X, Y

    reach, gap, cheek = d["reach"] / MM, d["gap"] / MM, d["cheek"] / MM
    width, web, r = d["end_width"] / MM, d["cap"] / MM, d["rounding"] / MM
    body = _plan(d, gap + 2.0 * cheek, web)
    # The slot, drawn in the plane across y, with rounded corners at its bottom.
    profile = WorkPlane(Axes((-width, width, -gap / 2.0), n=-Y, h=X))
    profile.Line(width + reach - r).Arc(r, 90.0).Line(gap - 2.0 * r).Arc(r, 90.0)
    profile.Line(width + reach - r).Rotate(90.0).Line(gap).Close()
    # The plane's normal is -y: the slot goes through the whole width from y = width.
    return body - profile.Face().Extrude(2.0 * width)


def _plan(d: Dimensions, height: float, beyond: float = 0.0) -> Any:
    """Return a slab with a round end about the pin at the origin, mm, from there along +x."""
    from netgen.occ import Box, Cylinder, Z

    half, reach = d["end_width"] / 2.0 / MM, d["reach"] / MM + beyond
    slab = Box((0.0, -half, -height / 2.0), (reach, half, height / 2.0))
    return slab + Cylinder((0.0, 0.0, -height / 2.0), Z, r=half, h=height)


def _strut(d: Dimensions, base: Any, tip: Any) -> Any:
    """Return a tube between two ends, each about the origin and along +x, with named bores."""
    from netgen.occ import Axis, Box, Cylinder, Z

    length, reach, cap = d["length"] / MM, d["reach"] / MM, d["cap"] / MM
    b, h, wall = d["width"] / 2.0 / MM, d["height"] / 2.0 / MM, d["wall"] / MM
    turned = tip.Rotate(Axis((0.0, 0.0, 0.0), Z), 180.0).Move((length, 0.0, 0.0))
    tube = Box((reach, -b, -h), (length - reach, b, h))
    hole = Box((reach + cap, wall - b, wall - h), (length - reach - cap, b - wall, h - wall))
    body = (base + tube + turned) - hole
    tall = length / 2.0
    for name, x in (("base", 0.0), ("tip", length)):
        pin = Cylinder((x, 0.0, -tall), Z, r=d["bore"] / 2.0 / MM, h=2.0 * tall)
        body = bored(body, pin, name)
    return body


ORTHOGLIDE_BAR = ParametricPart(
    name="orthoglide-bar",
    title="Bar of the Orthoglide's parallelogram",
    description="A box tube with a fork at each end, which holds the axle's end on a pin. "
    "x from pin to pin, z along the pins, origin at the base's pin.",
    edition=1,
    dimensions=(
        PartDimension(
            "length", 310e-3, "from pin to pin", "printed: Pashkevich 2009, section 5.1, L"
        ),
        PartDimension("width", 16.4e-3, "of the tube, along y", _TABLE_7),
        PartDimension("height", 10.0e-3, "of the tube, along z", _TABLE_7),
        PartDimension("wall", 2.85e-3, "of the tube", _TABLE_7),
        *_end_dimensions(22e-3, 12e-3, 20e-3, 10e-3),
        *_fork_dimensions(28e-3, 6e-3, 3e-3),
    ),
    faces={"base": "the two bores at the origin", "tip": "the two bores at the other end"},
    check=_check_fork,
    build=lambda d: _strut(d, _fork(d), _fork(d)),
)
"""L is printed; the tube follows from Table 7 (area, Iy and Iz of the single beam, and within 4 %
its torsion constant too); the forks are chosen."""


def _leg_dimensions(length: float, symbol: str) -> list[PartDimension]:
    printed = f"printed: Briot 2009, section 2, {symbol}"
    return [
        PartDimension("length", length, "from pin to pin", printed),
        PartDimension("width", 120e-3, "of the tube, along y", _CHOSEN),
        PartDimension("height", 80e-3, "of the tube, along z", _CHOSEN),
        PartDimension("wall", 8e-3, "of the tube", _CHOSEN),
        *_end_dimensions(90e-3, 50e-3, 85e-3, 25e-3),
        PartDimension("eye", 60e-3, "height of an eye, along z", _CHOSEN),
    ]


BIGLIDE_LEG_1 = ParametricPart(
    name="biglide-leg-1",
    title="Leg of the Biglide with an eye at each end",
    description="A box tube with an eye at each end. x from pin to pin, z along the pins, origin "
    "at the base's pin.",
    edition=1,
    dimensions=tuple(_leg_dimensions(0.85, "L1")),
    faces={"base": "the bore at the origin", "tip": "the bore at the other end"},
    check=_check,
    build=lambda d: _strut(d, _eye(d), _eye(d)),
)

BIGLIDE_LEG_2 = ParametricPart(
    name="biglide-leg-2",
    title="Leg of the Biglide with an eye and a fork",
    description="A box tube with an eye at the base, and a fork at the tip that takes the eye of "
    "the other leg. x from pin to pin, z along the pins, origin at the base's pin.",
    edition=1,
    dimensions=(*_leg_dimensions(0.775, "L2"), *_fork_dimensions(64e-3, 20e-3, 12e-3)),
    faces={"base": "the bore at the origin", "tip": "the two bores at the other end"},
    check=_check_fork,
    build=lambda d: _strut(d, _eye(d), _fork(d)),
)
