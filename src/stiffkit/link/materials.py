"""Isotropic elastic materials."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from stiffkit.errors import LinkError


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material; `LinkError` if no such material can exist."""

    name: str
    E: float
    """Pa, Young's modulus."""
    nu: float
    """Poisson's ratio."""
    density: float
    """kg/m^3."""

    def __post_init__(self) -> None:
        """Check the values."""
        if not (self.E > 0.0 and math.isfinite(self.E)):
            raise LinkError(
                f"material {self.name}: Young's modulus is {self.E:g} Pa and must be positive"
            )
        if not -1.0 < self.nu < 0.5:
            raise LinkError(
                f"material {self.name}: Poisson's ratio is {self.nu:g} and must lie between "
                "-1 and 0.5",
                mend="metals have about 0.3",
            )
        if not (self.density > 0.0 and math.isfinite(self.density)):
            raise LinkError(
                f"material {self.name}: the density is {self.density:g} kg/m^3 and must be positive"
            )

    @property
    def G(self) -> float:
        """Shear modulus, Pa."""
        return self.E / (2.0 * (1.0 + self.nu))


def _table(*materials: Material) -> Mapping[str, Material]:
    return MappingProxyType({material.name: material for material in materials})


MATERIALS: Mapping[str, Material] = _table(
    Material("steel", E=210e9, nu=0.3, density=7850.0),
    Material("stainless_steel", E=200e9, nu=0.3, density=7900.0),
    Material("aluminium", E=70e9, nu=0.3, density=2700.0),
    Material("titanium", E=113.8e9, nu=0.342, density=4430.0),
    Material("magnesium", E=45e9, nu=0.35, density=1810.0),
    Material("cast_iron", E=110e9, nu=0.26, density=7200.0),
    Material("ductile_iron", E=169e9, nu=0.275, density=7100.0),
    Material("brass", E=97e9, nu=0.31, density=8490.0),
    Material("pom", E=2.8e9, nu=0.37, density=1410.0),
    Material("peek", E=3.7e9, nu=0.4, density=1300.0),
)
"""Common materials by name, at room temperature; alloys of one family differ by a few per cent.

steel: structural steel, EN 1993-1-1 section 3.2.6, density EN 1991-1-1 table A.4.
stainless_steel: austenitic 1.4301, EN 1993-1-4 section 2.1.3, density EN 10088-1.
aluminium: wrought alloys, EN 1999-1-1 section 3.2.5.
titanium: Ti-6Al-4V, magnesium: AZ91D, brass: C36000, ASM Metals Handbook, volume 2.
cast_iron: EN-GJL-250, EN 1561 annex (E between 103 and 118 GPa, it falls with the load).
ductile_iron: EN-GJS-400-15, EN 1563 annex.
pom, peek: typical values of makers' data sheets (ISO 527); plastics creep, so these hold for short
loads only.
"""
