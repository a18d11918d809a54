"""A stiffness map made from formulas, with every status, for the tests of plots and report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIRECTIONS = ["x", "y", "z", "rx", "ry", "rz"]
LOADS = {"push": [0.0, 100.0, 0, 0, 0, 0], "lift": [0, 0, 100.0, 0, 0, 0]}
MIDDLE = {"x": 0.0, "y": 0.375, "z": 0.2, "rx": 0.0, "ry": 0.0, "rz": 0.0}
JOINTS = ["motor_left.rz", "motor_right.rz", "slide.z"]


def grid(**counts: int) -> dict[str, Array]:
    """Return coordinates that span 300 mm, or 60 degrees, about the middle."""
    return {
        axis: MIDDLE[axis] + np.linspace(-1, 1, count) * (0.5 if axis.startswith("r") else 0.15)
        for axis, count in counts.items()
    }


def synthetic_map(
    coordinates: Mapping[str, Array],
    *,
    points: bool = False,
    models: Sequence[str] = ("refined", "simplified"),
    title: str = "Synthetic five-bar",
    loads: Mapping[str, Sequence[float]] = LOADS,
) -> xr.Dataset:
    """Return a map over a grid of ``coordinates``, or over them as a list of points."""
    axes = list(coordinates)
    dims = ("point",) if points else tuple(axes)
    swept = (
        list(coordinates.values()) if points else np.meshgrid(*coordinates.values(), indexing="ij")
    )
    shape = swept[0].shape
    pose = {axis: np.full(shape, MIDDLE[axis]) for axis in DIRECTIONS}
    pose.update(zip(axes, swept, strict=True))
    status = _status(pose)
    full = np.stack([_compliance(pose, model) for model in models])
    full[:, ..., status != 0] = np.nan
    wrenches = np.array(list(loads.values()), dtype=np.float64)
    deflection = np.einsum("mij...,lj->mli...", full, wrenches)
    data = {
        "status": (("model", *dims), np.stack([status] * len(models)), ""),
        "tool": (("direction", *dims), np.stack([pose[axis] for axis in DIRECTIONS]), "m, rad"),
        "joint": (("joint_coordinate", *dims), _joints(pose, status), "m, rad"),
        "compliance": (("model", "direction", "direction_load", *dims), full, "SI"),
        "deflection": (("model", "load", "direction", *dims), deflection, "m, rad"),
    }
    for name, part in {
        "translation": slice(0, 3),
        "xy": slice(0, 2),
        "z": slice(2, 3),
        "rotation": slice(3, 6),
    }.items():
        norm = np.linalg.norm(deflection[:, :, part], axis=2)
        unit = "rad" if name == "rotation" else "m"
        data[f"deflection_{name}"] = (("model", "load", *dims), norm, unit)
    for name, part in {"translation": slice(0, 3), "rotation": slice(3, 6)}.items():
        least, most = _stiffness(full[:, part, part])
        unit = "N/m" if name == "translation" else "N m/rad"
        data[f"stiffness_{name}_min"] = (("model", *dims), least, unit)
        data[f"stiffness_{name}_max"] = (("model", *dims), most, unit)
    dataset = xr.Dataset(
        {
            name: (d, v, {"units": unit, "long_name": name.replace("_", " ")})
            for name, (d, v, unit) in data.items()
        },
        coords={
            "model": list(models),
            "load": list(loads),
            "direction": DIRECTIONS,
            "direction_load": DIRECTIONS,
            "joint_coordinate": JOINTS,
            **{axis: (dims if points else axis, v) for axis, v in coordinates.items()},
        },
        attrs={
            "title": title,
            "robot": "five_bar",
            "robot_hash": "0123456789abcdef" * 4,
            "stiffkit_version": "0.1.0",
            "options": json.dumps({"models": list(models), "grid": list(shape)}),
            "created": "2025-01-31T12:00:00+00:00",
            "loads": json.dumps({name: list(w) for name, w in loads.items()}),
            "free_motions": ["platform: rotation about z of left_rod"],
            "notes": ["links.rod: compliance was made symmetric, as the file asks"],
        },
    )
    dataset["status"].attrs.update(
        flag_values=[0, 1, 2, 3, 4],
        flag_meanings="ok unreachable singular uncontrolled outside",
    )
    return dataset


def add_branches(dataset: xr.Dataset) -> xr.Dataset:
    """Add the natural frequencies of four modes, the first two of which cross along x.

    The simplified model has none; the fourth mode is lost where x is large.
    """
    axes = [axis for axis in DIRECTIONS if axis in dataset.coords]
    x = dataset["x"].values - MIDDLE["x"]
    along = np.stack([90.0 + 200.0 * x, 100.0 - 200.0 * x, 130.0 + 0.0 * x, 180.0 + 9.0 * x])
    along[3, x > 0.1] = np.nan
    attributes = {"units": "Hz", "long_name": "natural frequency"}
    through = {axis: float(np.median(dataset[axis].values)) for axis in axes}
    dataset["branch"] = [1, 2, 3, 4]
    dataset["frequency_of_branch"] = _for_models(dataset, "refined", along, dataset["x"].dims)
    dataset["frequency_of_branch"].attrs.update(attributes)
    if "point" in dataset.sizes:
        return dataset
    for axis in axes:
        others = np.repeat(along[:, [x.size // 2]], dataset.sizes[axis], axis=1)
        values = along if axis == "x" else others
        name = f"frequency_along_{axis}"
        dataset[name] = _for_models(dataset, "refined", values, (axis,))
        dataset[name].attrs.update(
            attributes, tracking=json.dumps({"refined": {"through": through}})
        )
    return dataset


def _for_models(
    dataset: xr.Dataset, model: str, values: Array, dims: tuple[object, ...]
) -> xr.DataArray:
    names = [str(name) for name in dataset["model"].values]
    stacked = np.stack(
        [values if name == model else np.full_like(values, np.nan) for name in names]
    )
    return xr.DataArray(stacked, dims=("model", "branch", *map(str, dims)))


def _status(pose: Mapping[str, Array]) -> NDArray[np.int8]:
    x, y, z = (pose[axis] - MIDDLE[axis] for axis in "xyz")
    status = np.zeros(x.shape, dtype=np.int8)
    status[x**2 + (y + 0.15) ** 2 + z**2 < 0.05**2] = 3
    status[(x - 0.15) ** 2 + (y + 0.15) ** 2 + z**2 < 0.06**2] = 2
    status[x**2 + y**2 + z**2 > 0.19**2] = 1
    status[y - x > 0.24] = 4
    return status


def _compliance(pose: Mapping[str, Array], model: str) -> Array:
    x, y, z = (pose[axis] - MIDDLE[axis] for axis in "xyz")
    turn = 1.0 + pose["rz"] ** 2
    drives = np.zeros((6, 6, *x.shape))
    drives[0, 0] = 2e-8 * (1.0 + 20.0 * x**2) * turn
    drives[1, 1] = 3e-8 / (0.3 + np.abs(y + 0.2)) * turn
    drives[0, 1] = drives[1, 0] = 4e-8 * x
    if model == "simplified":
        return drives
    full = drives.copy()
    radius = (x + 0.02) ** 2 + (y + 0.05) ** 2 + 0.5 * z**2
    for i, size in enumerate((1.2e-7, 9e-8, 9e-7, 4e-6, 5e-6, 2e-6)):
        full[i, i] += size * (1.0 + 25.0 * radius)
    return full


def _joints(pose: Mapping[str, Array], status: NDArray[np.int8]) -> Array:
    joints = np.stack(
        [
            np.arctan2(pose["y"], pose["x"] + 0.15),
            np.arctan2(pose["y"], pose["x"] - 0.15) + pose["rz"],
            pose["z"],
        ]
    )
    joints[:, status != 0] = np.nan
    return joints


def _stiffness(block: Array) -> tuple[Array, Array]:
    matrices = np.moveaxis(block, (1, 2), (-2, -1))
    known = np.isfinite(matrices).all(axis=(-2, -1))
    values = np.full(matrices.shape[:-1], np.nan)
    values[known] = np.linalg.eigvalsh(matrices[known])
    with np.errstate(divide="ignore"):
        return 1.0 / values[..., -1], 1.0 / np.abs(values[..., 0])
