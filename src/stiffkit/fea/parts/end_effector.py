"""The Orthoglide's end-effector: a block with a ring for the far axle of each leg, and a flange."""

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
    require_ring,
)


def _check(d: Dimensions) -> None:
    require_ring(d)
    require(
        (d["seat"] + d["ring"]) / 2.0 < d["r"],
        f"rings of {millimetres(d['ring'])}, {millimetres(d['seat'])} long, meet at a distance of"
        f" {millimetres(d['r'])} from the tool point",
        "make the rings smaller or shorter, or r larger",
    )
    require(
        d["r"] - d["ring"] / 2.0 + 1e-3 < d["block"] / 2.0 < d["r"] - d["bore"] / 2.0,
        f"a block of {millimetres(d['block'])} does not hold rings of {millimetres(d['ring'])} at"
        f" {millimetres(d['r'])} without closing their bores",
        "let the block end between the outside of a ring and its bore",
    )
    require(
        d["flange"] < d["block"],
        f"a flange of {millimetres(d['flange'])} is wider than the block of"
        f" {millimetres(d['block'])}",
        "make the flange smaller",
    )


def _build(d: Dimensions) -> Any:
    from netgen.occ import Box, Cylinder, X, Y, Z

    r, ring, bore = d["r"] / MM, d["ring"] / 2.0 / MM, d["bore"] / 2.0 / MM
    half, seat = d["block"] / 2.0 / MM, d["seat"] / 2.0 / MM
    top = half + d["flange_height"] / MM
    body = Box((-half, -half, -half), (half, half, half))
    body = body + Cylinder((0.0, 0.0, 0.0), Z, r=d["flange"] / 2.0 / MM, h=top)
    # Each leg's ring lies against its drive, about the axle: x and y, y and z, z and x.
    axles = ((-r, 0.0, 0.0), Y), ((0.0, -r, 0.0), Z), ((0.0, 0.0, -r), X)
    for centre, axis in axles:
        body = body + Cylinder(_back(centre, axis, seat), axis, r=ring, h=2.0 * seat)
    for leg, (centre, axis) in enumerate(axles, start=1):
        hole = Cylinder(_back(centre, axis, seat + 1.0), axis, r=bore, h=2.0 * seat + 2.0)
        body = bored(body, hole, f"leg_{leg}")
    for face in body.faces:
        if face.bounding_box[0].z > top - 1e-3:
            face.name = "tool"
    return body


def _back(centre: tuple[float, float, float], axis: Any, by: float) -> tuple[float, float, float]:
    """Return a point moved against an axis."""
    return centre[0] - by * axis.x, centre[1] - by * axis.y, centre[2] - by * axis.z


ORTHOGLIDE_END_EFFECTOR = ParametricPart(
    name="orthoglide-end-effector",
    title="End-effector of the Orthoglide",
    description="A block about the tool point with three rings, one for the far axle of each leg, "
    "and a flange for the tool. x, y and z along the drives; the origin is the tool point.",
    edition=1,
    dimensions=(
        PartDimension(
            "r",
            31e-3,
            "from the tool point to an axle's axis",
            "printed: Pashkevich 2009, section 5.1",
        ),
        PartDimension("ring", 34e-3, "outer diameter of a ring", "chosen"),
        PartDimension("seat", 24e-3, "length of a ring along its axle", "chosen"),
        PartDimension("bore", 24e-3, "diameter of a bearing's bore", "chosen"),
        PartDimension("block", 34e-3, "side of the block", "chosen"),
        PartDimension("flange", 30e-3, "diameter of the flange", "chosen"),
        PartDimension("flange_height", 8e-3, "of the flange above the block", "chosen"),
    ),
    faces={
        **{f"leg_{leg}": f"the bore for the far axle of leg {leg}" for leg in (1, 2, 3)},
        "tool": "the flange's face",
    },
    check=_check,
    build=_build,
)
"""r is printed; everything else is chosen."""
