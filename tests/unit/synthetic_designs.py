"""Designs of a robot made from formulas, for the tests of their figures and their report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

MODELS = ("refined", "simplified")


def two_objectives(count: int = 300) -> xr.Dataset:
    """Return designs by deflection and mass, with bounds of a frequency and of the reach."""
    scale, wall = _spread(count, 2)
    teeth = np.round(3.0 + 3.0 * _spread(count, 3)[2])
    scale, wall = 0.7 + 0.6 * scale, 2e-3 + 6e-3 * wall
    scale[0], wall[0], teeth[0] = 1.0, 4e-3, 4.0
    bending = 9e-6 * scale**3 / (wall / 4e-3)
    drives = 6e-6 * (0.6 + 0.4 / scale**2) * 4.0 / teeth
    mass = 62.0 * (0.4 + 0.6 * scale * wall / 4e-3) + teeth
    first = 48.0 / scale**1.5 * (wall / 4e-3) ** 0.3
    return _dataset(
        {
            "scale": (scale, "", "length of the legs over that of the machine's", "continuous"),
            "wall": (wall, "m", "wall of the legs", "continuous"),
            "gear": (teeth, "", "size of the gear", "integer"),
        },
        {
            "largest_deflection": ([bending + drives, drives], "m", "min", None),
            "moving_mass": ([mass, mass], "kg", "min", None),
            "lowest_frequency": ([first, 30.0 + 45.0 * scale], "Hz", "above", 40.0),
            "reach": ([np.clip(0.8 + 0.4 * (scale - 0.7), 0, 1)] * 2, "", "above", 0.85),
        },
    )


def one_parameter(count: int = 41) -> xr.Dataset:
    """Return designs that differ in the length of the legs only, as in Briot 2009."""
    alpha = np.append(1.0, np.linspace(0.6, 1.6, count - 1))
    return _dataset(
        {"alpha": (alpha, "", "length of the legs over that of the machine's", "continuous")},
        {
            "deflection_z": ([3e-5 * alpha**3, 0.0 * alpha], "m", "min", None),
            "deflection_xy": ([8e-6 / alpha**2 + 4e-6 * alpha, 8e-6 / alpha**2], "m", "min", None),
            "first_frequency": ([75.0 / alpha, 62.0 * alpha**0.5], "Hz", "max", None),
            "mass": ([55.0 + 119.0 * alpha] * 2, "kg", "below", 190.0),
        },
    )


def many_objectives(count: int = 250) -> xr.Dataset:
    """Return designs by four objectives."""
    a, b, c, d = _spread(count, 4)
    a[0] = b[0] = c[0] = d[0] = 0.5
    return _dataset(
        {
            "base": (0.2 + 0.4 * a, "m", "width of the base", "continuous"),
            "arm": (0.1 + 0.3 * b, "m", "arm", "continuous"),
            "tilt": (np.deg2rad(10 + 50 * c), "rad", "tilt of the guides", "continuous"),
            "drive": (1e7 * (1 + 9 * d), "N/m", "drive stiffness", "continuous"),
        },
        {
            "deflection": ([1e-5 * (1 + a + b**2 - d / 2), 4e-6 * (2 - d)], "m", "min", None),
            "mass": ([20 + 30 * b + 20 * (1 - a)] * 2, "kg", "min", None),
            "frequency": ([90 - 40 * b + 20 * d, 100 + 30 * d - 20 * c], "Hz", "max", None),
            "size": ([0.5 + a + 0.3 * c + 0.4 * (1 - b)] * 2, "m", "min", None),
        },
    )


def one_objective(count: int = 120) -> xr.Dataset:
    """Return designs of one objective, found by several methods."""
    a, b = _spread(count, 2)
    a[0] = b[0] = 0.9
    shrink = np.linspace(1.0, 0.0, count // 2)
    half = count - count // 2
    a[half:], b[half:] = 0.25 + 0.6 * shrink**3, 0.4 + 0.5 * shrink**2
    origin = ["start"] + ["evolution"] * (half - 1) + ["gradient"] * (count // 2)
    return _dataset(
        {
            "L1": (0.5 + 0.5 * a, "m", "first leg", "continuous"),
            "L2": (0.5 + 0.5 * b, "m", "second leg", "continuous"),
        },
        {
            "worst_deflection": (
                [
                    1e-5 * (1 + (a - 0.2) ** 2 + (b - 0.4) ** 2),
                    5e-6 * (1 + (a - 0.8) ** 2 + (b - 0.9) ** 2),
                ],
                "m",
                "min",
                None,
            ),
            "mass": ([40 + 20 * a + 10 * b] * 2, "kg", "below", 62.0),
        },
        origin=origin,
    )


def infeasible() -> xr.Dataset:
    """Return designs none of which keeps all bounds."""
    dataset = two_objectives(60)
    for name in ("feasible", "front"):
        dataset[name][:] = 0
    dataset["lowest_frequency"].attrs["bound"] = 400.0
    dataset["violation"][:] = 1.0
    dataset.attrs["chosen"] = json.dumps({})
    dataset.attrs["message"] = (
        "no design keeps all bounds: lowest_frequency above 400 Hz clashes with reach above 0.85"
    )
    return dataset


Given = tuple[Any, str, str, Any]


def _dataset(
    parameters: Mapping[str, Given],
    results: Mapping[str, Given],
    origin: Sequence[str] | None = None,
) -> xr.Dataset:
    count = len(next(iter(parameters.values()))[0])
    data: dict[str, Any] = {}
    for name, (values, units, long_name, kind) in parameters.items():
        attrs = {"units": units, "long_name": long_name, "kind": kind}
        attrs |= {"low": float(values.min()), "high": float(values.max())}
        data[name] = ("design", values, attrs)
    broken = np.zeros((2, count))
    goals = []
    for name, (values, units, sense, bound) in results.items():
        both = np.stack(values)
        role = "objective" if sense in ("min", "max") else "constraint"
        attrs = {"units": units, "long_name": name.replace("_", " "), "role": role, "sense": sense}
        sign = 1.0 if sense in ("min", "below") else -1.0
        if bound is None:
            goals.append(sign * both)
        else:
            attrs["bound"] = bound
            broken = np.maximum(broken, sign * (both - bound) / bound)
        data[name] = (("model", "design"), both, attrs)
    feasible = broken <= 0.0
    front = np.stack([_front(np.stack([g[m] for g in goals]), feasible[m]) for m in range(2)])
    chosen = {model: _chosen([g[m] for g in goals], front[m]) for m, model in enumerate(MODELS)}
    data["violation"] = (("model", "design"), broken)
    data["feasible"] = (("model", "design"), feasible.astype(np.int8))
    data["front"] = (("model", "design"), front.astype(np.int8))
    data["origin"] = ("design", list(origin or ["start"] + ["grid"] * (count - 1)))
    return xr.Dataset(
        data,
        coords={"model": list(MODELS), "design": np.arange(count)},
        attrs={
            "title": "Legs of the synthetic machine",
            "robot": "biglide-scaled",
            "robot_hash": "0123456789abcdef" * 4,
            "stiffkit_version": "0.1.0",
            "created": "2025-01-31T12:00:00+00:00",
            "options": json.dumps({"postures": 400}),
            "evaluations": json.dumps(
                {
                    "grid": {"geometries": 240, "seconds": 2.1},
                    "gradient": {"geometries": 60, "seconds": 3.75},
                }
            ),
            "chosen": json.dumps(chosen),
            "message": "",
        },
    )


def _spread(count: int, dimensions: int) -> Array:
    """Return numbers from 0 to 1 that fill their cube evenly, (dimensions, count)."""
    steps = np.sqrt([2.0, 3.0, 5.0, 7.0])[:dimensions, None]
    return np.asarray((0.5 + steps * np.arange(count)) % 1.0)


def _front(goals: Array, feasible: NDArray[np.bool_]) -> NDArray[np.bool_]:
    better = np.all(goals[:, :, None] <= goals[:, None, :], axis=0)
    better &= np.any(goals[:, :, None] < goals[:, None, :], axis=0)
    return np.asarray(feasible & ~np.any(better & feasible[:, None], axis=0))


def _chosen(goals: Sequence[Array], front: NDArray[np.bool_]) -> int:
    members = np.flatnonzero(front)
    scaled = [(g[members] - g[members].min()) / (np.ptp(g[members]) or 1.0) for g in goals]
    return int(members[np.argmin(np.sum(np.square(scaled), axis=0))])
