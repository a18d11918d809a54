"""The designs of a study as a dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.design.judge import Judge, front
from stiffkit.design.measures import in_words, units_of
from stiffkit.design.spec import Objective
from stiffkit.units import si_unit_of

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Designs:
    """All designs that were looked at, the start first."""

    parameters: Array
    """(p, n), SI."""
    derived: Mapping[str, tuple[str, Array]]
    """Unit and values (n,), SI, of the parameters that follow from others."""
    chosen: Mapping[str, Array]
    """Numbers (n,) of the option that each variable with named options has."""
    measures: Array
    """(models, measures, n), SI."""
    origin: tuple[str, ...]


@dataclass(frozen=True)
class About:
    """What a dataset says of the study it comes from."""

    robot_hash: str
    created: str
    evaluations: Mapping[str, Mapping[str, float]]
    """Geometries and seconds of each method."""
    message: str
    """What clashes where nothing is feasible."""


def make_dataset(designs: Designs, judge: Judge, about: About) -> xr.Dataset:
    """Return the designs as a dataset; all values are SI."""
    import xarray as xr  # slow to import

    spec = judge.spec
    feasible = judge.feasible(designs.measures)
    losses, violations = judge.losses(designs.measures), judge.violations(designs.measures)
    fronts = np.array([front(*both) for both in zip(losses, feasible, strict=True)])
    data: dict[str, Any] = {}
    for varied, kind, own in zip(spec.parameters, _kinds(judge), designs.parameters, strict=True):
        attributes = _of_parameter(varied.name, varied.unit) | {
            "kind": kind,
            "low": varied.values[0],
            "high": varied.values[1],
        }
        data[varied.name] = ("design", own, attributes)
    for name, (unit, own) in designs.derived.items():
        attributes = {"kind": "derived", "low": float(own.min()), "high": float(own.max())}
        data[name] = ("design", own, _of_parameter(name, unit) | attributes)
    for variable in spec.variables:
        if variable.name in designs.chosen:
            options = np.array(variable.options, dtype=object)
            words = np.where(
                designs.chosen[variable.name] < 0,
                "",
                options[designs.chosen[variable.name].astype(int)],
            )
            data[variable.name] = ("design", words.astype(object), {"long_name": "option"})
    for i, goal in enumerate(spec.goals):
        attributes = _of_goal(judge, i)
        data[goal.measure.name] = (("model", "design"), designs.measures[:, i], attributes)
    data |= {
        "violation": (
            ("model", "design"),
            violations.sum(axis=1),
            {"units": "1", "long_name": "sum of violations, each over its bound"},
        ),
        "feasible": (
            ("model", "design"),
            feasible.astype(np.int8),
            {"units": "1", "long_name": "whether a design fulfils all constraints"},
        ),
        "front": (
            ("model", "design"),
            fronts.astype(np.int8),
            {"units": "1", "long_name": "whether no feasible design is better in all objectives"},
        ),
        "origin": (
            "design",
            np.array(designs.origin, dtype=object),
            {"long_name": "method that found a design"},
        ),
    }
    chosen = {
        model: int(np.argmin(np.where(ok, loss[0], np.inf)))
        for model, ok, loss in zip(spec.models, feasible, losses, strict=True)
        if ok.any()
    }
    return xr.Dataset(
        data,
        {"design": np.arange(designs.parameters.shape[1]), "model": list(spec.models)},
        {
            "title": spec.title,
            "robot": spec.robot,
            "robot_hash": about.robot_hash,
            "stiffkit_version": __version__,
            "created": about.created,
            "options": json.dumps(spec.plain()),
            "evaluations": json.dumps(about.evaluations),
            "chosen": json.dumps(chosen),
            "message": about.message,
        },
    )


def _kinds(judge: Judge) -> list[str]:
    return [v.kind for v in judge.spec.variables for _ in v.parameters]


def _of_parameter(name: str, unit: str) -> dict[str, Any]:
    return {"units": si_unit_of(unit) or "1", "long_name": f"parameter {name}"}


def _of_goal(judge: Judge, i: int) -> dict[str, Any]:
    """Return the attributes of an objective or a constraint."""
    goal = judge.spec.goals[i]
    attributes = {"units": units_of(goal.measure), "long_name": in_words(goal.measure)}
    if isinstance(goal, Objective):
        return attributes | {"role": "objective", "sense": "max" if goal.maximise else "min"}
    bounds = judge.bounds[:, i - judge.n_objectives]
    return attributes | {
        "role": "constraint",
        "sense": "above" if goal.above else "below",
        "bound": float(bounds[0]),
        # Where the bound is what the start has, models differ.
        "bound_by_model": bounds,
    }
