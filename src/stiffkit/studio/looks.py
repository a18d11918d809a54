"""The colours of the studio: the palette of the figures, one colour for each meaning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Status
from stiffkit.plots import style
from stiffkit.plots.scale import Scale

if TYPE_CHECKING:
    from stiffkit.studio.solid import Solid

Array = NDArray[np.float64]
Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Look:
    """How solids of one kind look, and what the legend calls them."""

    colour: Colour
    words: str


LOOKS: Mapping[str, Look] = {
    "elastic": Look((86, 145, 190), "elastic link"),
    "equivalent": Look((134, 180, 214), "elastic link, shape unknown: a rod stands for it"),
    "rigid": Look((96, 100, 106), "rigid link"),
    "joint": Look((205, 208, 212), "passive joint"),
    "drive": Look((213, 94, 0), "drive"),
    "base": Look((150, 154, 160), "base"),
    "tool": Look((34, 34, 34), "tool"),
}
"""Okabe and Ito's blue for what yields and vermilion for drives, greys for the rest."""

BRAND: Colour = (0, 114, 178)
WORST: Colour = (204, 40, 110)
LOADS: Colour = (204, 40, 110)
TRANSLATION: Colour = (0, 158, 115)
ROTATION: Colour = (230, 159, 0)

NO_ANSWER: Mapping[Status, Colour] = {
    Status.UNREACHABLE: (226, 226, 226),
    Status.SINGULAR: (90, 90, 90),
    Status.UNCONTROLLED: (154, 154, 154),
    Status.OUTSIDE: (255, 255, 255),
}


def look_of(solid: Solid) -> str:
    """Return the name of a solid's look, one of `LOOKS`."""
    if solid.role != "link":
        return solid.role
    if not solid.elastic:
        return "rigid"
    return "equivalent" if solid.is_equivalent else "elastic"


def map_colours(values: Array, status: NDArray[np.integer], scale: Scale) -> NDArray[np.uint8]:
    """Return a colour (P, 3) for each value (P,) in display units; greys where there is none."""
    from matplotlib import colormaps

    shares = np.asarray(scale.norm(np.nan_to_num(values, nan=scale.low, posinf=scale.high)))
    table = colormaps[style.MAP_COLOURS](np.linspace(0.0, 1.0, 256), bytes=True)[:, :3]
    steps = np.nan_to_num(np.clip(shares, 0.0, 1.0)) * 255.0
    colours = np.asarray(table[steps.astype(np.intp)], dtype=np.uint8)
    for kind, colour in NO_ANSWER.items():
        colours[status == kind] = colour
    return colours


def css(colour: Colour) -> str:
    """Return a colour as style sheets write it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
