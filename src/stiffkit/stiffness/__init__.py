"""The stiffness of a posture: simplified and refined model, and the general assembly."""

from stiffkit.network import FreeMotion, Model
from stiffkit.stiffness.assembly import AssembledCompliance, Assembly
from stiffkit.stiffness.composition import Composition
from stiffkit.stiffness.freedom import describe_free_motion
from stiffkit.stiffness.indices import (
    PrincipalAxes,
    deflection,
    entry,
    full_matrices,
    lower_triangles,
    principal_axes,
)
from stiffkit.stiffness.model import Compliances, Stiffness
from stiffkit.stiffness.readings import DEFLECTIONS, STIFFNESSES, Reading, readings
from stiffkit.stiffness.simplified import SimplifiedModel

__all__ = [
    "DEFLECTIONS",
    "STIFFNESSES",
    "AssembledCompliance",
    "Assembly",
    "Compliances",
    "Composition",
    "FreeMotion",
    "Model",
    "PrincipalAxes",
    "Reading",
    "SimplifiedModel",
    "Stiffness",
    "deflection",
    "describe_free_motion",
    "entry",
    "full_matrices",
    "lower_triangles",
    "principal_axes",
    "readings",
]
