"""What measures are called, and in which units they are."""

from __future__ import annotations

from stiffkit.design.spec import Constraint, Measure, Objective
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep import describe
from stiffkit.units import ANGLE, LENGTH, MASS, NUMBER, Dimension

_UNITS = {LENGTH: "m", ANGLE: "rad", MASS: "kg", NUMBER: "1"}


def dimension_of(measure: Measure) -> Dimension:
    """Return the dimension of a measure."""
    if measure.column is not None:
        share = measure.column.statistic.startswith("share")
        return NUMBER if share else QUANTITIES[measure.column.quantity].dimension
    match measure.kind:
        case "mass":
            return MASS
        case "size":
            return LENGTH
        case "reached":
            return NUMBER
    return ANGLE if measure.joint.rpartition(".")[2].startswith("r") else LENGTH


def units_of(measure: Measure) -> str:
    """Return the SI unit of a measure, as datasets have it; "1" for a pure number."""
    if measure.column is not None and not measure.column.statistic.startswith("share"):
        return QUANTITIES[measure.column.quantity].units
    return _UNITS[dimension_of(measure)]


def in_words(measure: Measure) -> str:
    """Return in words what a measure is."""
    if measure.column is not None:
        return describe(measure.column)
    match measure.kind:
        case "mass":
            return "mass of all links and the tool"
        case "size":
            return "largest dimension of the box round all joints and the tool at home"
        case "reached":
            return "share of the workspace that is reached"
        case "stroke":
            return f"stroke of {measure.joint} over the workspace"
    return f"{measure.kind} coordinate {measure.joint} over the workspace"


def goal_in_words(goal: Objective | Constraint, bound: float | None = None) -> str:
    """Return an objective, or a constraint with its bound (SI), in words."""
    measure = goal.measure
    if isinstance(goal, Objective):
        return f"{in_words(measure)}, as {'large' if goal.maximise else 'small'} as can be"
    units = units_of(measure)
    unit = "" if units == "1" else f" {units}"
    value = f"{bound:.6g}{unit}" if bound is not None else "that of the start"
    return f"{in_words(measure)} {'above' if goal.above else 'below'} {value}"
