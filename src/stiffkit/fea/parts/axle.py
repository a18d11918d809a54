"""Half an axle of the Orthoglide's parallelogram: a shaft with a journal and a bore for a pin."""

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


def _check(d: Dimensions) -> None:
    require(
        d["journal"] + 2.0 * d["rounding"] < d["diameter"],
        f"a journal of {millimetres(d['journal'])} with a rounding of"
        f" {millimetres(d['rounding'])} is no step on a shaft of {millimetres(d['diameter'])}",
        "make the journal or its rounding smaller",
    )
    require(
        d["bore"] < 0.7 * d["diameter"],
        f"a bore of {millimetres(d['bore'])} across a shaft of {millimetres(d['diameter'])} leaves"
        " too little of it",
        "make the bore smaller",
    )
    require(
        d["overhang"] > 0.6 * d["bore"],
        f"the bore of {millimetres(d['bore'])} breaks out of an overhang of"
        f" {millimetres(d['overhang'])}",
        "make the overhang larger",
    )
    require(
        d["seat"] + d["rounding"] + 0.6 * d["bore"] < d["length"],
        f"the seat of {millimetres(d['seat'])} and the bore meet in a length of"
        f" {millimetres(d['length'])}",
        "make the seat shorter, or the length larger",
    )


def _build(d: Dimensions) -> Any:
    from netgen.occ import Axes, Axis, Cylinder, WorkPlane, X, Y

    r, R = d["journal"] / 2.0 / MM, d["diameter"] / 2.0 / MM
    seat, rounding = d["seat"] / MM, d["rounding"] / MM
    length, end = d["length"] / MM, (d["length"] + d["overhang"]) / MM
    # Half of the section along the shaft, counter-clockwise from the origin, then turned about x.
    profile = WorkPlane(Axes((0.0, 0.0, 0.0), n=-Y, h=X))
    profile.Line(end).Rotate(90.0).Line(R).Rotate(90.0).Line(end - seat - rounding).Rotate(90.0)
    # The shoulder, down to the rounding that ends on the journal.
    profile.Line(R - r - rounding).Arc(rounding, -90.0).Line(seat).Rotate(90.0).Line(r).Close()
    body = profile.Face().Revolve(Axis((0.0, 0.0, 0.0), X), 360.0)
    for face in body.faces:
        if face.bounding_box[1].x < 1e-3:
            face.name = "middle"
        elif face.bounding_box[1].x < seat + 1e-3:
            face.name = "journal"
    pin = Cylinder((length, -2.0 * R, 0.0), Y, r=d["bore"] / 2.0 / MM, h=4.0 * R)
    return bored(body, pin, "pin")


ORTHOGLIDE_AXLE = ParametricPart(
    name="orthoglide-axle",
    title="Half an axle of the Orthoglide's parallelogram",
    description="A round shaft from the middle of the axle, where a bearing sits on a journal, to "
    "beyond the pin that holds a bar. x along the shaft, y along the pin, origin in the middle of "
    "the axle.",
    edition=1,
    dimensions=(
        PartDimension(
            "length",
            50e-3,
            "from the middle of the axle to the pin's axis",
            "printed: Pashkevich 2009, section 5.1, d / 2",
        ),
        PartDimension(
            "diameter",
            26e-3,
            "of the shaft",
            "inferred: Table 7's single-beam row is a round bar of this diameter",
        ),
        PartDimension("journal", 18e-3, "diameter of the bearing's seat", "chosen"),
        PartDimension("seat", 12e-3, "half the length of the bearing's seat", "chosen"),
        PartDimension("rounding", 2e-3, "radius where the journal meets the shaft", "chosen"),
        PartDimension("bore", 12e-3, "diameter of the bore for the pin", "chosen"),
        PartDimension("overhang", 12e-3, "of the shaft beyond the pin's axis", "chosen"),
    ),
    faces={
        "middle": "the cut through the middle of the axle",
        "journal": "the bearing's seat",
        "pin": "the bore for the pin",
    },
    check=_check,
    build=_build,
)
"""Length and diameter follow from the paper; journal and bore are chosen."""
