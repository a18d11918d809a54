"""Elastic links: beams, given compliances, superelements, link files, and checks of all these."""

from stiffkit.link.beam import beam_compliance, beam_inertia
from stiffkit.link.checks import (
    check_compliance,
    check_inertia,
    doubts_compliance,
    doubts_inertia,
    symmetrize,
)
from stiffkit.link.line import Line, beam_line, equivalent_line
from stiffkit.link.materials import MATERIALS, Material
from stiffkit.link.outline import Outline, equivalent_outline
from stiffkit.link.sections import (
    CowperCoefficient,
    Section,
    box,
    rectangle,
    round_bar,
    tube,
)
from stiffkit.link.superelement import Superelement

__all__ = [
    "MATERIALS",
    "CowperCoefficient",
    "Line",
    "Material",
    "Outline",
    "Section",
    "Superelement",
    "beam_compliance",
    "beam_inertia",
    "beam_line",
    "box",
    "check_compliance",
    "check_inertia",
    "doubts_compliance",
    "doubts_inertia",
    "equivalent_line",
    "equivalent_outline",
    "rectangle",
    "round_bar",
    "symmetrize",
    "tube",
]
