"""A 6x6 compliance as a table, with its units. What is in the cells is HTML."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stiffkit.link.checks import LOADS
from stiffkit.robot import DIRECTIONS
from stiffkit.spatial.rotation import Array

UNITS_SI = (("m/N", "1/N"), ("1/N", "1/(N m)"))
UNITS_MM = (("mm/N", "1/N"), ("1/N", "1/(N mm)"))
"""Of translations and rotations (rows) under forces and moments (columns)."""


def compliance_matrix(cell: Callable[[int, int], str], *, millimetres: bool) -> str:
    """Return the 36 elements, in m or mm; ``cell`` gives the td element of a row and a column."""
    units = UNITS_MM if millimetres else UNITS_SI
    head = "".join(f'<th scope="col">{load}</th>' for load in LOADS)
    rows = "".join(
        f'<tr><th scope="row">{name}</th>'
        + "".join(cell(i, j) for j in range(6))
        + f'<td class="unit">{", ".join(units[i // 3])}</td></tr>'
        for i, name in enumerate(DIRECTIONS)
    )
    return (
        '<table class="compliance"><thead><tr><td></td>'
        f'{head}<th scope="col">unit under<br>forces, moments</th></tr></thead>'
        f"<tbody>{rows}</tbody></table>"
    )


def scale_of(*, millimetres: bool) -> Array:
    """Return the factors (6, 6) from SI to the unit of length that is shown."""
    scale = np.ones((6, 6))
    if millimetres:
        scale[:3, :3], scale[3:, 3:] = 1e3, 1e-3
    return scale


def with_power(value: float, digits: int) -> str:
    """Return a number with a power of ten as HTML."""
    if value == 0.0:
        return "0"
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    return f"{mantissa}·10<sup>{int(exponent)}</sup>".replace("-", "−")
