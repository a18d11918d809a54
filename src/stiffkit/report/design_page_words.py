"""What a design study asked and what came out of it, in sentences."""

from __future__ import annotations

import numpy as np

from stiffkit.plots.designs import (
    START,
    Designs,
    Parameter,
    Result,
    change_text,
    design_name,
)
from stiffkit.plots.units import format_value
from stiffkit.report.words import grouped


def varied_in_words(designs: Designs) -> list[str]:
    """Return what is free, and in which range."""
    return [_range_of(parameter) for parameter in designs.parameters] + [
        f"{one.name}, which follows from the others" for one in designs.derived
    ]


def asked_in_words(designs: Designs) -> list[str]:
    """Return objectives and constraints."""
    return [
        f"{result.title}: {result.goal}"
        + ("" if result.long_name == result.title else f" ({result.long_name})")
        for result in designs.results
    ]


def tried_in_words(designs: Designs) -> str:
    """Return how many designs there are, and how many keep all bounds."""
    tried = f"{grouped(designs.count)} designs were tried, the start among them"
    if not designs.constraints:
        return f"{tried}."
    counts = {model: int(designs.feasible[model].sum()) for model in designs.models}
    kept = [f"{grouped(n) if n else 'none'} by the {model} model" for model, n in counts.items()]
    return f"{tried}; of these keep all bounds: {', '.join(kept)}."


def outcome_in_words(designs: Designs, model: str) -> list[str]:
    """Return what the chosen design of a model is, against the start, by that model."""
    if model not in designs.chosen:
        return [f"No design keeps all bounds by the {model} model, so none is chosen."]
    design = designs.chosen[model]
    if design == START:
        return ["None of the designs is better than the start.", *_edges(designs, model, design)]
    origin = designs.origin[design]
    best = f", {_why(designs, model)}" if _why(designs, model) else ""
    sentences = [f"{_first_up(design_name(design))}, found by {_method(origin)}{best}."]
    for result in designs.objectives:
        values = result.values[model]
        sentences.append(
            f"{_first_up(result.title)}: {result.unit.text(values[design])} instead of "
            f"{result.unit.text(values[START])} ({change_text(values[design], values[START])})."
        )
    sentences += _edges(designs, model, design)
    broken = broken_bounds(designs, model, START)
    if broken:
        sentences.append(f"The start breaks a bound: {', '.join(broken)}.")
    return sentences


def comparison_in_words(designs: Designs) -> list[str]:
    """Return what the first model says of the design that the second takes for the best.

    Nothing if there is only one model, or one of them has chosen no design.
    """
    if len(designs.chosen) < 2:
        return []
    judge, other = list(designs.chosen)[:2]
    own, foreign = designs.chosen[judge], designs.chosen[other]
    if own == foreign:
        return [f"Both models choose the same design, {design_name(own)}."]
    sentences = [
        f"The {other} model chooses {design_name(foreign)}, the {judge} model {design_name(own)}:"
        f" {_differences(designs, foreign, own)}."
    ]
    for result in designs.objectives:
        value, best = result.values[judge][foreign], result.values[judge][own]
        found, promised = result.unit.text(value), result.unit.text(result.values[other][foreign])
        if found == promised:
            told = found
        else:
            told = f"the {other} model promises {promised}, the {judge} model finds {found}"
        excess = excess_text(result, value, best)
        if excess.endswith(("worse", "better")):
            told += f", {excess} than the {result.unit.text(best)} of {design_name(own)}"
        sentences.append(f"{_first_up(result.title)} of {design_name(foreign)}: {told}.")
    broken = broken_bounds(designs, judge, foreign)
    if broken:
        sentences.append(f"By the {judge} model it breaks a bound: {', '.join(broken)}.")
    elif designs.constraints:
        sentences.append(f"By the {judge} model it keeps all bounds.")
    return sentences


def excess_text(result: Result, value: float, best: float) -> str:
    """Return how much worse, or better, a value is than that of another design."""
    if not np.isfinite(value) or not np.isfinite(best) or best == 0.0:
        return "–"
    percent = 100.0 * result.sign * (value - best) / abs(best)
    if abs(percent) < 0.05:
        return "the same"
    size = format_value(float(f"{abs(percent):.2g}"))
    return f"{size} % {'worse' if percent > 0.0 else 'better'}"


def broken_bounds(designs: Designs, model: str, design: int) -> list[str]:
    """Return the constraints that a design breaks, and what it has instead."""
    return [
        f"{one.title} {_value(one, model, design)}, {one.sense} "
        f"{one.unit.text(one.bounds[model])} was asked"
        for one in designs.constraints
        if one.is_broken(model, design)
    ]


def _edges(designs: Designs, model: str, design: int) -> list[str]:
    """Return which bounds and which ends of ranges hold a design back."""
    active = [
        f"{one.title} {one.sense} {one.unit.text(one.bounds[model])}"
        for one in designs.constraints
        if one.is_active(model, design)
    ]
    ends = [
        f"{one.name} ({end}, {one.unit.text(one.values[design])})"
        for one in designs.parameters
        if (end := one.end(design))
    ]
    sentences = [f"At its bound: {', '.join(active)}."] if active else []
    if not active and designs.constraints:
        sentences.append("No constraint is at its bound.")
    if ends:
        sentences.append(f"At an end of its range: {', '.join(ends)}.")
    return sentences


def _differences(designs: Designs, design: int, other: int) -> str:
    """Return in which free parameters one design differs from another."""
    different = [
        f"{one.name} {here} instead of {there}"
        for one in designs.parameters
        if (here := one.unit.text(one.values[design]))
        != (there := one.unit.text(one.values[other]))
    ]
    return ", ".join(different) or "their parameters are the same to four digits"


def _why(designs: Designs, model: str) -> str:
    """Return in which objective a chosen design is the best one, if it is in any."""
    if len(designs.objectives) == 1:
        return "the best one"
    design = designs.chosen[model]
    feasible = designs.feasible[model]
    best = []
    for one in designs.objectives:
        values = one.sign * one.values[model]
        if values[design] <= np.min(values, initial=np.inf, where=feasible & np.isfinite(values)):
            best.append(one.title)
    return f"the best in {' and '.join(best)}" if best else ""


def _range_of(parameter: Parameter) -> str:
    low, high = parameter.unit.text(parameter.low), parameter.unit.text(parameter.high)
    how = {"integer": ", whole numbers", "choice": ", by choice"}.get(parameter.kind, "")
    about = "" if parameter.long_name in ("", parameter.name) else f", {parameter.long_name}"
    if about == f", parameter {parameter.name}":
        about = ""
    return f"{parameter.name}{about}: from {low} to {high}{how}"


def _value(result: Result, model: str, design: int) -> str:
    return result.unit.text(result.values[model][design])


def _method(origin: str) -> str:
    return {"global": "global search", "gradient": "gradients", "grid": "the grid"}.get(
        origin, origin
    )


def _first_up(text: str) -> str:
    return text[:1].upper() + text[1:]
