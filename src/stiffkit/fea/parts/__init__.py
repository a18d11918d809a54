"""Parametric parts: shapes built by functions of this package, named in files with numbers only."""

from __future__ import annotations

from stiffkit.errors import CadError
from stiffkit.fea.parts.axle import ORTHOGLIDE_AXLE
from stiffkit.fea.parts.end_effector import ORTHOGLIDE_END_EFFECTOR
from stiffkit.fea.parts.foot import ORTHOGLIDE_FOOT
from stiffkit.fea.parts.parametric import ParametricPart, PartDimension
from stiffkit.fea.parts.struts import BIGLIDE_LEG_1, BIGLIDE_LEG_2, ORTHOGLIDE_BAR
from stiffkit.files.names import suggest

PARTS = {
    part.name: part
    for part in (
        BIGLIDE_LEG_1,
        BIGLIDE_LEG_2,
        ORTHOGLIDE_AXLE,
        ORTHOGLIDE_BAR,
        ORTHOGLIDE_END_EFFECTOR,
        ORTHOGLIDE_FOOT,
    )
}
"""The registered parts by name."""

__all__ = ["PARTS", "ParametricPart", "PartDimension", "find_part"]


def find_part(name: str) -> ParametricPart:
    """Return the part of a name. Raises `CadError` if there is none."""
    if name not in PARTS:
        raise CadError(f"there is no parametric part '{name}'", mend=suggest(name, PARTS))
    return PARTS[name]
