"""What a design study found, as plain arrays in the units of a reader."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stiffkit.errors import OutputError
from stiffkit.plots.units import DisplayUnit, Kind, display_unit, format_value

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

START = 0
"""The design that is the robot file's own."""

AT_THE_BOUND = 5e-3
"""A constraint nearer to its bound than this, relative to the bound, is active."""

ROUNDING = 1e-6
"""A constraint broken by less than this, relative to its bound, is kept."""

DERIVED = "derived"
_PARAMETERS = ("continuous", "integer", "choice", DERIVED)

_PARAMETER_KINDS = {"m": Kind.POSITION, "rad": Kind.ANGLE}
_RESULT_KINDS = {"m": Kind.DEFLECTION, "rad": Kind.ROTATION}
_KINDS = {
    "N/m": Kind.STIFFNESS,
    "N m/rad": Kind.ROTATIONAL_STIFFNESS,
    "Hz": Kind.FREQUENCY,
}
_UNITS = {
    "": DisplayUnit("", 1.0),
    "1": DisplayUnit("", 1.0),
    "m^2": DisplayUnit("mm²", 1e-6),
    "m^4": DisplayUnit("mm⁴", 1e-12),
    "Pa": DisplayUnit("GPa", 1e9),
    "kg m^2": DisplayUnit("kg m²", 1.0),
    "kg/m^3": DisplayUnit("kg/m³", 1.0),
}


@dataclass(frozen=True, eq=False)
class Parameter:
    """A parameter that differs from design to design."""

    name: str
    long_name: str
    kind: str
    """continuous, integer, choice, or derived from the others."""
    unit: DisplayUnit
    low: float
    high: float
    """Ends of its range, SI."""
    values: Array
    """(n_designs,), SI."""

    @property
    def label(self) -> str:
        """Name and unit for an axis."""
        return self.unit.label(self.name)

    def end(self, design: int) -> Literal["", "lowest", "highest"]:
        """Tell at which end of its range the parameter is in a design."""
        near = 1e-3 * (self.high - self.low)
        if self.values[design] <= self.low + near:
            return "lowest"
        return "highest" if self.values[design] >= self.high - near else ""


@dataclass(frozen=True, eq=False)
class Result:
    """An objective or a constraint."""

    name: str
    long_name: str
    role: Literal["objective", "constraint"]
    sense: str
    """min or max of an objective; above or below of a constraint."""
    bounds: Mapping[str, float]
    """By model, SI; NaN of an objective."""
    unit: DisplayUnit
    values: Mapping[str, Array]
    """By model (n_designs,), SI; NaN where there is no answer."""

    @property
    def title(self) -> str:
        """Its name in words."""
        return self.name.replace("_", " ")

    @property
    def label(self) -> str:
        """Name and unit for an axis."""
        return self.unit.label(self.title)

    @property
    def goal(self) -> str:
        """What was asked of it, in words."""
        if self.role == "objective":
            return "as small as can be" if self.sense == "min" else "as large as can be"
        different = dict.fromkeys(self.unit.text(bound) for bound in self.bounds.values())
        return f"{self.sense} {' or '.join(different)}"

    @property
    def sign(self) -> float:
        """1 where small values are good, -1 where large ones are."""
        return 1.0 if self.sense in ("min", "below") else -1.0

    def is_broken(self, model: str, design: int) -> bool:
        """Tell whether a design breaks this constraint by more than rounding."""
        excess = self.sign * (self.values[model][design] - self.bounds[model])
        return bool(not excess <= ROUNDING * self._size(model))

    def is_active(self, model: str, design: int) -> bool:
        """Tell whether a design lies at the bound of this constraint."""
        distance = abs(self.values[model][design] - self.bounds[model])
        return bool(distance <= AT_THE_BOUND * self._size(model))

    def is_telling(self, designs: Mapping[str, Sequence[int]] | None = None) -> bool:
        """Tell whether this is an objective, or designs differ in it: all of them, or some."""
        if self.role == "objective":
            return True
        for model, values in self.values.items():
            some = values if designs is None else values[[*designs[model]]]
            known = some[np.isfinite(some)]
            if known.size and np.ptp(known) > ROUNDING * np.abs(known).max():
                return True
        return False

    def _size(self, model: str) -> float:
        known = self.values[model][np.isfinite(self.values[model])]
        return abs(self.bounds[model]) or (float(np.ptp(known)) if known.size else 0.0) or 1.0


@dataclass(frozen=True, eq=False)
class Designs:
    """All designs of a study."""

    title: str
    models: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    """Those that are free."""
    derived: tuple[Parameter, ...]
    """Those that follow from them."""
    options: Mapping[str, tuple[str, ...]]
    """Of each choice that has names, the name of what each design has."""
    objectives: tuple[Result, ...]
    constraints: tuple[Result, ...]
    feasible: Mapping[str, Flags]
    front: Mapping[str, Flags]
    origin: tuple[str, ...]
    """By which method each design was tried."""
    chosen: Mapping[str, int]
    """The best design by model; a model without one is left out."""

    @property
    def count(self) -> int:
        """Number of designs, the start included."""
        return len(self.origin)

    @property
    def results(self) -> tuple[Result, ...]:
        """Objectives, then constraints."""
        return (*self.objectives, *self.constraints)

    def front_of(self, model: str) -> NDArray[np.intp]:
        """Return the designs of a model's front, best in the first objective first."""
        members = np.flatnonzero(self.front[model])
        first = self.objectives[0]
        return members[np.argsort(first.sign * first.values[model][members], kind="stable")]


def designs_of(dataset: xr.Dataset) -> Designs:
    """Return what a dataset of designs holds.

    Raises:
        OutputError: if it is none: without designs, a varied parameter or an objective.
    """
    variables = [*dataset.data_vars.values()] if dataset.sizes.get("design") else []
    parameters = [_parameter(v) for v in variables if v.attrs.get("kind") in _PARAMETERS]
    results = [_result(v) for v in variables if v.attrs.get("role") in ("objective", "constraint")]
    free = tuple(one for one in parameters if one.kind != DERIVED)
    objectives = tuple(one for one in results if one.role == "objective")
    if not free or not objectives:
        raise OutputError(
            "the dataset holds no designs: they have varied parameters and objectives",
            mend="give the dataset that a design study writes",
        )
    models = tuple(str(name) for name in np.atleast_1d(dataset["model"].values))
    chosen = json.loads(dataset.attrs.get("chosen") or "{}")
    return Designs(
        title=str(dataset.attrs.get("title", "")),
        models=models,
        parameters=free,
        derived=tuple(one for one in parameters if one.kind == DERIVED),
        options={
            str(v.name): tuple(str(word) for word in v.values)
            for v in variables
            if v.dims == ("design",) and v.dtype.kind in "OUT" and v.name != "origin"
        },
        objectives=objectives,
        constraints=tuple(one for one in results if one.role == "constraint"),
        feasible=_flags(dataset["feasible"], models),
        front=_flags(dataset["front"], models),
        origin=tuple(str(name) for name in dataset["origin"].values),
        chosen={model: int(chosen[model]) for model in models if chosen.get(model) is not None},
    )


def unit_for(units: str, values: Array, *, is_parameter: bool) -> DisplayUnit:
    """Return the unit in which SI ``values`` with SI ``units`` read best."""
    kind = (_PARAMETER_KINDS if is_parameter else _RESULT_KINDS).get(units) or _KINDS.get(units)
    if kind is not None:
        return display_unit(kind, values)
    return _UNITS.get(units) or DisplayUnit(units, 1.0)


def design_name(number: int) -> str:
    """Return what a design is called: "start" or "design 12"."""
    return "start" if number == START else f"design {number}"


def change_text(value: float, start: float) -> str:
    """Return how much a value differs from that of the start, such as "−12 %"."""
    if not np.isfinite(value) or not np.isfinite(start) or start == 0.0:
        return "–"
    percent = 100.0 * (value / start - 1.0)
    rounded = float(f"{percent:.2g}") if abs(percent) < 100.0 else round(percent)
    if abs(percent) < 0.05:
        return "0 %"
    return f"{'+' if percent > 0 else ''}{format_value(rounded)} %"


def _parameter(variable: xr.DataArray) -> Parameter:
    values = np.asarray(variable.values, dtype=np.float64)
    attrs = variable.attrs
    low, high = float(attrs.get("low", values.min())), float(attrs.get("high", values.max()))
    return Parameter(
        name=str(variable.name),
        long_name=str(attrs.get("long_name") or variable.name),
        kind=str(attrs["kind"]),
        unit=unit_for(str(attrs.get("units", "")), np.array([low, high]), is_parameter=True),
        low=low,
        high=high,
        values=values,
    )


def _result(variable: xr.DataArray) -> Result:
    attrs = variable.attrs
    models = [str(model) for model in np.atleast_1d(variable["model"].values)]
    values = np.asarray(variable.transpose("model", "design").values, dtype=np.float64)
    given = attrs.get("bound_by_model", attrs.get("bound", np.nan))
    bounds = np.broadcast_to(np.asarray(given, dtype=np.float64).ravel(), len(models))
    known = np.append(values.ravel(), bounds)
    return Result(
        name=str(variable.name),
        long_name=str(attrs.get("long_name") or variable.name),
        role=attrs["role"],
        sense=str(attrs["sense"]),
        bounds={model: float(bound) for model, bound in zip(models, bounds, strict=True)},
        unit=unit_for(str(attrs.get("units", "")), known, is_parameter=False),
        values=dict(zip(models, values, strict=True)),
    )


def _flags(variable: xr.DataArray, models: tuple[str, ...]) -> dict[str, Flags]:
    return {model: np.asarray(variable.sel(model=model).values) == 1 for model in models}
