"""What a stiffness map spans, and its numbers as plain arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stiffkit.errors import OutputError
from stiffkit.kinematics import Status
from stiffkit.plots.quantities import kind_of
from stiffkit.plots.units import DisplayUnit, Kind, display_unit
from stiffkit.robot import DIRECTIONS
from stiffkit.study import Quantity

Array = NDArray[np.float64]

POINT = "point"

OK, UNREACHABLE, SINGULAR, UNCONTROLLED, OUTSIDE = Status
"""The values of the map's status."""

ROUNDING = 1e-9
"""A deflection below this part of the map's largest is rounding error, and reads 0."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """The tool coordinates that a map goes over."""

    axes: tuple[str, ...]
    """Swept tool coordinates, of `DIRECTIONS`; of a list of points those that vary."""
    coordinates: Mapping[str, Array]
    """Their values, m and rad: one array (n_axis,) for each axis of a grid, (n,) for points."""
    shape: tuple[int, ...]
    """Shape of one quantity."""
    is_grid: bool

    @property
    def count(self) -> int:
        """Number of postures."""
        return int(np.prod(self.shape))


def sweep_of(dataset: xr.Dataset) -> Sweep:
    """Return what ``dataset`` sweeps over.

    Raises:
        OutputError: if it has neither a swept tool coordinate nor a list of points.
    """
    if POINT in dataset.sizes:
        values = {
            axis: np.asarray(dataset[axis].values, dtype=np.float64)
            for axis in DIRECTIONS
            if axis in dataset.coords and dataset[axis].dims == (POINT,)
        }
        varying = {axis: v for axis, v in values.items() if np.ptp(v) > 0.0} or values
        return Sweep(tuple(varying), varying, (dataset.sizes[POINT],), is_grid=False)
    axes = tuple(axis for axis in DIRECTIONS if axis in dataset.sizes)
    if not axes:
        raise OutputError(
            "the map sweeps over no tool coordinate",
            mend="give the robot a workspace with a range of at least one tool coordinate",
        )
    coordinates = {axis: np.asarray(dataset[axis].values, dtype=np.float64) for axis in axes}
    return Sweep(axes, coordinates, tuple(dataset.sizes[axis] for axis in axes), is_grid=True)


def models_of(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the models, "refined" first if it is there."""
    return tuple(str(name) for name in np.atleast_1d(dataset["model"].values))


def loads_of(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the load cases."""
    if "load" not in dataset.coords:
        return ()
    return tuple(str(name) for name in np.atleast_1d(dataset["load"].values))


def cases_of(dataset: xr.Dataset, quantity: Quantity) -> tuple[str | None, ...]:
    """Return the loads to draw ``quantity`` for: all load cases, or None once."""
    return loads_of(dataset) if quantity.per_load else (None,)


def is_planar(dataset: xr.Dataset) -> bool:
    """Whether the tool stays in a plane z = constant and turns about z only."""
    tool = dataset["tool"]
    for axis in ("z", "rx", "ry"):
        values = tool.sel(direction=axis).values
        values = values[np.isfinite(values)]
        if values.size and np.ptp(values) > 1e-9:
            return False
    return True


def status_of(dataset: xr.Dataset, model: str) -> NDArray[np.int8]:
    """Return the status of each posture, in the sweep's shape."""
    return np.asarray(dataset["status"].sel(model=model).values, dtype=np.int8)


def values_of(dataset: xr.Dataset, quantity: Quantity, model: str, load: str | None) -> Array:
    """Return a quantity in the sweep's shape, SI.

    NaN where the posture has no answer. Rounding error is cleared: a deflection that is nothing
    beside the largest of the map is 0, a stiffness beside which the map's smallest is nothing
    is inf.

    Raises:
        OutputError: if the model or the load is not in the map.
    """
    _must_be_one_of("model", model, models_of(dataset))
    if quantity.per_load:
        _must_be_one_of("load", load, loads_of(dataset))
    values = _select(dataset[quantity.name], quantity, load, model=model).copy()
    values[status_of(dataset, model) != OK] = np.nan
    reference = quantity.scale if quantity.scale in dataset else quantity.name
    scale = np.abs(_select(dataset[reference], quantity, load))
    counts = np.isfinite(scale) & (scale > 0.0)
    if not counts.any():
        return values
    if quantity.worst_is_largest:
        values[np.abs(values) < ROUNDING * scale.max(where=counts, initial=0.0)] = 0.0
    else:
        values[values > scale.min(where=counts, initial=np.inf) / ROUNDING] = np.inf
    return values


@dataclass(frozen=True, eq=False)
class Columns:
    """A quantity by all models of a map, for one load case if it has any."""

    quantity: Quantity
    load: str | None
    values: Mapping[str, Array]
    """By model, as `values_of` gives them."""

    @cached_property
    def unit(self) -> DisplayUnit:
        """The unit for the quantity, the same one for all models."""
        everything = np.concatenate([v.ravel() for v in self.values.values()])
        return display_unit(kind_of(self.quantity), everything)

    @cached_property
    def ratio(self) -> Array | None:
        """Refined over simplified, NaN where that means nothing; None unless both are there."""
        if set(self.values) != {"refined", "simplified"}:
            return None
        refined, simplified = self.values["refined"], self.values["simplified"]
        ratio = np.full(refined.shape, np.nan)
        usable = np.isfinite(refined) & np.isfinite(simplified) & (simplified != 0.0)
        np.divide(refined, simplified, out=ratio, where=usable)
        return ratio


def columns_of(dataset: xr.Dataset, quantity: Quantity, load: str | None) -> Columns:
    """Return a quantity by all models; raises what `values_of` raises."""
    values = {m: values_of(dataset, quantity, m, load) for m in models_of(dataset)}
    return Columns(quantity, load, values)


def unit_of(dataset: xr.Dataset, quantity: Quantity, load: str | None) -> DisplayUnit:
    """Return the unit for a quantity, the same one for all models."""
    return columns_of(dataset, quantity, load).unit


def ratio_of(dataset: xr.Dataset, quantity: Quantity, load: str | None) -> Array:
    """Return refined over simplified in the sweep's shape; NaN where it means nothing.

    Raises:
        OutputError: if one of the two models is not in the map.
    """
    for model in ("refined", "simplified"):
        _must_be_one_of("model", model, models_of(dataset))
    ratio = columns_of(dataset, quantity, load).ratio
    return ratio if ratio is not None else np.full(sweep_of(dataset).shape, np.nan)


def axis_unit(axis: str) -> DisplayUnit:
    """Return the unit of a tool coordinate: mm or degrees."""
    return display_unit(Kind.ANGLE if axis.startswith("r") else Kind.POSITION, ())


def middle_posture(status: NDArray[np.int8]) -> tuple[int, ...]:
    """Return the index of the computed posture that lies nearest to the middle of the sweep."""
    middle = (np.array(status.shape) - 1) / 2.0
    computed = np.argwhere(status == OK)
    if len(computed) == 0:
        return tuple(round(float(m)) for m in middle)
    span = np.maximum(np.array(status.shape) - 1, 1)
    nearest = np.argmin((((computed - middle) / span) ** 2).sum(axis=1))
    return tuple(int(i) for i in computed[nearest])


def _select(
    variable: xr.DataArray, quantity: Quantity, load: str | None, **choice: str
) -> NDArray[np.float64]:
    if quantity.per_load:
        choice["load"] = str(load)
    return np.asarray(variable.sel(choice).values, dtype=np.float64)


def _must_be_one_of(what: str, name: str | None, known: tuple[str, ...]) -> None:
    if name not in known:
        raise OutputError(
            f"the map has no {what} {name!r}", mend=f"choose one of: {', '.join(known)}"
        )
