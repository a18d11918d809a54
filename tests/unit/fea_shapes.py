"""Shapes that the finite-element tests are made on; lengths in millimetres."""

from __future__ import annotations

import os
from typing import Any


def beam(length: float = 1000.0, width: float = 10.0) -> Any:
    from netgen.occ import Box, X

    bar = Box((0, 0, 0), (length, width, width))
    bar.faces.Min(X).name = "base"
    bar.faces.Max(X).name = "tip"
    bar.faces.Max(X).col = (1.0, 0.0, 0.0)
    return bar


def plate_with_hole() -> Any:
    from netgen.occ import Box, Cylinder, Z

    return Box((0, 0, 0), (40, 20, 5)) - Cylinder((10, 10, 0), Z, r=3, h=5)


def foot() -> Any:
    """A curved foot: base plate with four bolt holes, quarter-circle bar, boss with a bore."""
    from netgen.occ import Axes as Placement
    from netgen.occ import Axis, Box, Cylinder, WorkPlane, X, Y, Z

    plate = Box((-30, -30, 0), (30, 30, 12))
    profile = WorkPlane(Placement((0, 0, 12), Z, X)).RectangleC(26, 16).Face()
    bar = profile.Revolve(Axis((100, 0, 12), Y), 90)
    boss = Cylinder((100, -15, 112), Y, r=20, h=30)
    whole = plate + bar + boss
    joint = [e for e in whole.edges if abs(e.center.z - 12) < 1e-3 and _within(e, 14)]
    whole = whole.MakeFillet(joint, 4)
    for x in (-22, 22):
        for y in (-22, 22):
            whole = whole - Cylinder((x, y, 0), Z, r=4.5, h=12)
    whole = whole - Cylinder((100, -15, 112), Y, r=10, h=30)
    for face in whole.faces:
        c = face.center
        if abs(c.z) < 1e-6:
            face.name = "ground"
        if abs(c.x - 100) < 0.1 and abs(c.z - 112) < 0.1 and abs(c.y) < 0.1:
            face.name = "bore"
    return whole


def _within(edge: Any, reach: float) -> bool:
    return bool(abs(edge.center.x) < reach and abs(edge.center.y) < reach)


def apart() -> Any:
    from netgen.occ import Box, Compound

    return Compound([Box((0, 0, 0), (10, 10, 10)), Box((30, 0, 0), (40, 10, 10))])


def two_materials() -> Any:
    """A bar of two halves along x that share a face."""
    from netgen.occ import Box, Glue

    return Glue([Box((0, 0, 0), (50, 10, 10)), Box((50, 0, 0), (100, 10, 10))])


def shell() -> Any:
    from netgen.occ import Box, Compound

    return Compound(list(Box((0, 0, 0), (10, 10, 10)).faces)[:5])


def crash() -> Any:
    os.abort()


def hang() -> Any:
    import time

    time.sleep(60)


def impossible_fillet() -> Any:
    from netgen.occ import Box

    box = Box((0, 0, 0), (10, 10, 10))
    return box.MakeFillet(box.edges, 50)


def split_bar() -> Any:
    """A bar of two halves along x, with names for its ends and for the face in its middle."""
    from netgen.occ import Box, Glue

    bar = Glue([Box((0, 0, 0), (50, 10, 10)), Box((50, 0, 0), (100, 10, 10))])
    for face in bar.faces:
        for x, name in ((0.0, "base"), (50.0, "middle"), (100.0, "tip")):
            if abs(face.center.x - x) < 1e-6:
                face.name = name
    return bar
