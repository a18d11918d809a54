"""The foot of an Orthoglide's leg: an arm that leans from the carriage to the near axle."""

from __future__ import annotations

import math
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

_LEAN = math.radians(45.0)


def _check(d: Dimensions) -> None:
    require_ring(d)
    require(
        max(d["height"], d["width"]) <= d["ring"],
        f"the arm of {millimetres(d['width'])} by {millimetres(d['height'])} is thicker than the"
        f" ring of {millimetres(d['ring'])}",
        "make the ring larger",
    )
    across = d["length"] * math.sin(_LEAN)
    require(
        across > d["ring"] / 2.0 + d["plate"] + d["rounding"],
        f"a foot of {millimetres(d['length'])} has no arm between its plate and its ring",
        "make the length larger",
    )
    taken = d["height"] / math.sin(_LEAN) + 2.0 * d["plate"] + 4.0 * d["rounding"] + 2.0 * d["bolt"]
    require(
        taken < d["plate_length"] and d["width"] + 2.0 * d["rounding"] < d["plate_width"],
        f"arm and bolts do not fit onto a plate of {millimetres(d['plate_length'])} by"
        f" {millimetres(d['plate_width'])}",
        "make plate_length or plate_width larger",
    )


def _build(d: Dimensions) -> Any:
    from netgen.occ import Axis, Box, Cylinder, Y, Z

    across = d["length"] / MM * math.sin(_LEAN)
    plate, ring = d["plate"] / MM, d["ring"] / 2.0 / MM
    a, b = d["plate_length"] / 2.0 / MM, d["plate_width"] / 2.0 / MM
    w, h = d["width"] / 2.0 / MM, d["height"] / 2.0 / MM
    seat = d["seat"] / 2.0 / MM
    # The plate lies under the middle of the arm where it comes out of it.
    shift = plate
    # The arm begins below the plate's top, so that nothing of it ends inside.
    arm = Box((0.0, -w, -h), (d["length"] / MM, w, h))
    arm = arm.Rotate(Axis((0.0, 0.0, 0.0), Y), -math.degrees(_LEAN))
    arm = arm - Box((-4.0 * a, -4.0 * b, -4.0 * a), (4.0 * a, 4.0 * b, plate / 2.0))
    base = Box((shift - a, -b, 0.0), (shift + a, b, plate))
    body = base + arm
    body = body.MakeFillet(_foot_of_arm(body, plate, w, h), d["rounding"] / MM)
    body = body + Cylinder((across, -seat, across), Y, r=ring, h=2.0 * seat)
    bolt = d["bolt"] / MM
    for sx in (-1.0, 1.0):
        for sy in (-1.0, 1.0):
            x, y = shift + sx * (a - 1.2 * bolt), sy * (b - 1.2 * bolt)
            body = body - Cylinder((x, y, -1.0), Z, r=bolt / 2.0, h=plate + 2.0)
    bearing = Cylinder((across, -2.0 * seat, across), Y, r=d["bore"] / 2.0 / MM, h=4.0 * seat)
    body = bored(body, bearing, "bearing")
    for face in body.faces:
        if face.bounding_box[1].z < 1e-3:
            face.name = "carriage"
        elif face.name != "bearing":
            face.name = ""
    return body


def _foot_of_arm(body: Any, plate: float, w: float, h: float) -> Any:
    """Return the edges where the arm stands on the plate."""
    reach = plate + 2.0 * h
    return [
        edge
        for edge in body.edges
        if abs(edge.bounding_box[0].z - plate) < 1e-3
        and abs(edge.bounding_box[1].z - plate) < 1e-3
        and abs(edge.center.y) < w + 1e-3
        and abs(edge.center.x - plate) < reach
    ]


ORTHOGLIDE_FOOT = ParametricPart(
    name="orthoglide-foot",
    title="Foot of an Orthoglide's leg",
    description="An arm that leans by 45 degrees from a plate, bolted to the carriage, to a ring "
    "for the near axle's bearing. x along the drive, y along the axle, z up from the plate; the "
    "origin lies on the plate's lower face, the axle at an equal height and distance from it.",
    edition=1,
    dimensions=(
        PartDimension(
            "length",
            150e-3,
            "from the origin to the axle's axis",
            "inferred: Table 7's single-beam row is a beam of this length",
        ),
        PartDimension("width", 16e-3, "of the arm, along the axle", "inferred from Table 7"),
        PartDimension("height", 26e-3, "of the arm, across the axle", "inferred from Table 7"),
        PartDimension("plate_length", 90e-3, "of the plate, along the drive", "chosen"),
        PartDimension("plate_width", 50e-3, "of the plate, along the axle", "chosen"),
        PartDimension("plate", 10e-3, "thickness of the plate", "chosen"),
        PartDimension("bolt", 6.6e-3, "diameter of the four bolt holes", "chosen: for M6"),
        PartDimension("ring", 34e-3, "outer diameter of the ring", "chosen"),
        PartDimension("seat", 24e-3, "length of the ring along the axle", "chosen"),
        PartDimension("bore", 24e-3, "diameter of the bearing's bore", "chosen"),
        PartDimension("rounding", 5e-3, "radius where the arm meets the plate", "chosen"),
    ),
    faces={"carriage": "the plate's lower face", "bearing": "the bore of the ring"},
    check=_check,
    build=_build,
)
"""Length and section follow from Table 7; the lean of 45 degrees too; plate and ring are chosen."""
