"""What a study of uncertainty gives: quantities with bands, sources, parts."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.design.uncertainty.first_order import Bands, FirstOrder
from stiffkit.design.uncertainty.ranking import Part, ranking
from stiffkit.design.uncertainty.spec import Asked, UncertaintySpec
from stiffkit.kinematics import Status
from stiffkit.study.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


def dataset_of(spec: UncertaintySpec, first_order: FirstOrder) -> xr.Dataset:
    """Return everything that the first order tells of the postures of the workspace."""
    import xarray as xr  # slow to import

    grid = first_order.family.grid
    dims = ("model", *grid.dims)
    shape = (len(spec.models), *grid.shape)
    status = np.stack([first_order.status(model) for model in spec.models]).reshape(shape)
    data: dict[str, Any] = {"status": (dims, status, _about_status())}
    for asked in spec.asked:
        bands = [first_order.bands(asked, model) for model in spec.models]
        values = np.stack([b.values for b in bands]).reshape(shape)
        sigma = np.stack([b.sigma for b in bands]).reshape(shape)
        half = spec.standard_deviations * sigma
        causes = np.stack([_causes(b) for b in bands]).reshape(shape[0], -1, *grid.shape)
        band = f"of the {100.0 * spec.confidence:g} % band of"
        name, about = asked.name, _about(asked)
        data[name] = (dims, values, about | _identity(asked))
        data[f"{name}_sigma"] = (dims, sigma, _about(asked, "standard deviation of"))
        data[f"{name}_low"] = (dims, values - half, _about(asked, f"lower end {band}"))
        data[f"{name}_high"] = (dims, values + half, _about(asked, f"upper end {band}"))
        data[f"{name}_cause"] = (
            ("model", "source", *grid.dims),
            causes,
            _about(asked, "share of sources in the variance of", "1"),
        )
    coordinates: dict[str, Any] = {"model": list(spec.models), "source": list(spec.sources)}
    for axis, places in grid.axes.items():
        unit = "rad" if axis.startswith("r") else "m"
        about = {"units": unit, "long_name": f"tool coordinate {axis}"}
        coordinates[axis] = (("point",) if grid.listed else (axis,), places, about)
    dataset = xr.Dataset(data, coordinates, _attributes(spec, first_order))
    if "refined" in spec.models:
        _add_ranking(dataset, spec, first_order)
    return dataset


def _causes(bands: Bands) -> Array:
    """Return the share (S, P) of each source in the variance."""
    total = bands.variances.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(total > 0.0, bands.variances / total, 0.0 * total))


def _identity(asked: Asked) -> dict[str, str]:
    """Return what tells a variable that was asked for, and which quantity of which load it is."""
    own = {"quantity": asked.quantity}
    return own if asked.load is None else own | {"load": asked.load}


def _about(asked: Asked, what: str = "", units: str = "") -> dict[str, str]:
    under = f" under {asked.load}" if asked.load else ""
    name = f"{QUANTITIES[asked.quantity].long_name}{under}"
    return {
        "units": units or asked.units,
        "long_name": f"{what} the {name}" if what else name,
    }


def _about_status() -> dict[str, Any]:
    return {
        "units": "1",
        "long_name": "status of the posture",
        "flag_values": np.array([status.value for status in Status], dtype=np.int8),
        "flag_meanings": " ".join(status.word for status in Status),
    }


def _attributes(spec: UncertaintySpec, first_order: FirstOrder) -> dict[str, Any]:
    robot = first_order.family.robot
    return {
        "title": spec.title,
        "robot": spec.robot,
        "robot_title": robot.title,
        "robot_hash": robot.content_hash,
        "stiffkit_version": __version__,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "confidence": spec.confidence,
        "options": json.dumps(spec.plain()),
    }


def _add_ranking(dataset: xr.Dataset, spec: UncertaintySpec, first_order: FirstOrder) -> None:
    """Add the share of each part in each quantity, parts in the order of the first one's."""
    ranked = {
        asked.name: {(p.kind, p.name): p for p in ranking(first_order, asked)}
        for asked in spec.asked
    }
    parts = {key: part for found in ranked.values() for key, part in found.items()}
    if not parts:
        return
    dataset.coords["part"] = [part.name for part in parts.values()]
    dataset["part_kind"] = ("part", [part.kind for part in parts.values()])
    dataset["part_mass"] = (
        "part",
        [part.mass for part in parts.values()],
        {"units": "kg", "long_name": "mass"},
    )
    for asked in spec.asked:
        own = ranked[asked.name]
        for key, what in (
            ("share", "share of parts, mean over the workspace, in"),
            ("share_at_worst", "share of parts, where it is the worst, in"),
            ("gain_per_kg", "relative gain for each kilogram added to parts, in"),
        ):
            dataset[f"{asked.name}_{key}"] = (
                "part",
                [_value(own.get(part), key) for part in parts],
                _about(asked, what, "1/kg" if key == "gain_per_kg" else "1"),
            )


def _value(part: Part | None, key: str) -> float:
    return float("nan") if part is None else float(getattr(part, key))
