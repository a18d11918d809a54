"""Parts and meshes that several tests share, each made once."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from stiffkit.fea import (
    MeshSettings,
    Part,
    PartMesh,
    Port,
    build_part,
    mesh_part,
    named_ports,
)
from stiffkit.link import Material

SHAPES = Path(__file__).with_name("fea_shapes.py")

STEEL = Material("steel of the paper", E=2e11, nu=0.266, density=7800.0)


@cache
def part(function: str, **arguments: float) -> Part:
    return build_part(SHAPES, function, arguments)


@cache
def mesh(function: str, size: float, **arguments: float) -> PartMesh:
    return mesh_part(part(function, **arguments), MeshSettings(size))


def ends(of: Part, base: str = "clamped", tip: str = "average") -> tuple[Port, ...]:
    """The two ends of a beam."""
    return named_ports(of, {"base": base, "tip": tip})
