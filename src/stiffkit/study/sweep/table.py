"""The table of a study: a row for each geometry, as a dataset."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import OutputError
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.directory import StudyDirectory
from stiffkit.study.sweep.engine import GeometryStatus, Rows
from stiffkit.study.sweep.files import write_whole
from stiffkit.study.sweep.spec import Column, StudySpec, slope_name
from stiffkit.units import si_unit_of

if TYPE_CHECKING:
    import xarray as xr


def write_table(directory: StudyDirectory) -> xr.Dataset:
    """Make the table of a study whose chunks are all finished, and write it as NetCDF.

    Raises OutputError where a chunk is missing, or the table cannot be written.
    """
    table = make_table(directory)
    # In memory first: where a disk is full, HDF5 brings the whole process down.
    write_whole(directory.table, bytes(table.to_netcdf(engine="h5netcdf")))
    return table


def make_table(directory: StudyDirectory) -> xr.Dataset:
    """Return the table of a study. Raises OutputError where a chunk is missing."""
    import xarray as xr  # slow to import

    chunks: list[Rows] = []
    for i in range(directory.n_chunks):
        rows = directory.read_chunk(i)
        if rows is None:
            raise OutputError(
                f"{directory.chunk_path(i)} is missing or damaged",
                mend=f"run 'stiffkit study resume {directory.path}'",
            )
        rows["reason"] = rows["reason"].astype(object)
        chunks.append(rows)
    arrays = {name: np.concatenate([rows[name] for rows in chunks], axis=-1) for name in chunks[0]}
    spec = directory.spec
    values = np.concatenate([directory.values(i) for i in range(directory.n_chunks)], axis=1)
    coordinates: dict[str, Any] = {"model": list(spec.models), "coordinate": list(directory.swept)}
    for varied, own in zip(spec.varied, values, strict=True):
        about = {"units": si_unit_of(varied.unit) or "1", "long_name": f"parameter {varied.name}"}
        coordinates[varied.name] = ("geometry", own, about)
    columns = {column.name: column for column in spec.columns}
    slopes = _slopes(spec)
    data = {name: _variable(name, array, columns, slopes) for name, array in arrays.items()}
    return xr.Dataset(data, coordinates, _attributes(directory))


_COUNTS = {
    "postures_ok": "postures with an answer",
    "postures_unreachable": "postures that the assembly mode does not reach",
    "postures_singular": "postures at which the tool can move freely",
}


def _slopes(spec: StudySpec) -> dict[str, dict[str, Any]]:
    """Return what is said of each column of derivatives."""
    return {
        slope_name(column, varied.name): {
            "units": _over(QUANTITIES[column.quantity].units, si_unit_of(varied.unit)),
            "long_name": f"derivative of the {describe(column)} by {varied.name}",
        }
        for column in spec.columns
        for varied in spec.varied
    }


def _over(unit: str, other: str) -> str:
    """Return the unit of a derivative."""
    return f"{unit}/({other})" if other else unit


def _variable(
    name: str,
    values: NDArray[np.generic],
    columns: dict[str, Column],
    slopes: dict[str, dict[str, Any]],
) -> tuple[tuple[str, ...], NDArray[np.generic], dict[str, Any]]:
    if name == "geometry_status":
        flags = {
            "flag_values": np.array([int(s) for s in GeometryStatus], dtype=np.int8),
            "flag_meanings": " ".join(s.word for s in GeometryStatus),
        }
        return ("geometry",), values, {"long_name": "status of the geometry", "units": "1"} | flags
    if name == "reason":
        return ("geometry",), values, {"long_name": "why a geometry has no results"}
    if name == "frequency_first":
        lowest = QUANTITIES[name]
        about = {"units": lowest.units, "long_name": f"{lowest.long_name}, refined model"}
        return ("frequency_posture", "geometry"), values, about
    if name == "frequency_error":
        about = {
            "units": "1",
            "long_name": "largest estimated relative error of a frequency; 0: full model",
        }
        return ("geometry",), values, about
    if name in _COUNTS:
        return ("model", "geometry"), values, {"units": "1", "long_name": _COUNTS[name]}
    if name in columns:
        column = columns[name]
        return ("model", "geometry"), values, _about(column)
    if name in slopes:
        return ("model", "geometry"), values, slopes[name]
    column = columns[name.removesuffix("_at")]
    about = {"units": "m, rad", "long_name": f"tool pose of the {describe(column)}"}
    return ("model", "coordinate", "geometry"), values, about


def _about(column: Column) -> dict[str, Any]:
    share = column.statistic.startswith("share")
    about: dict[str, Any] = {
        "units": "1" if share else QUANTITIES[column.quantity].units,
        "long_name": describe(column),
        "quantity": column.quantity,
        "statistic": column.statistic,
    }
    if column.load is not None:
        about["load"] = column.load
    if column.value is not None:
        about["value"] = column.value
    return about


def describe(column: Column) -> str:
    """Return in words what a column holds."""
    quantity = QUANTITIES[column.quantity]
    words = quantity.long_name
    if column.load is not None:
        words += f" under {column.load}"
    match column.statistic:
        case "min":
            return f"smallest {words}"
        case "max":
            return f"largest {words}"
        case "mean":
            return f"mean {words}"
        case "percentile":
            return f"{column.value:g} % percentile of the {words}"
    sense = "above" if column.statistic == "share above" else "below"
    return f"share of postures with the {words} {sense} {column.value:g} {quantity.units}"


def _attributes(directory: StudyDirectory) -> dict[str, Any]:
    job = directory.job
    return {
        "title": directory.spec.title,
        "robot": directory.spec.robot,
        "robot_hash": job.robot_hash,
        "stiffkit_version": job.version,
        "backend": job.backend,
        "created": directory.created,
        "postures": " x ".join(str(n) for n in directory.shape),
        "study": json.dumps(job.spec),
    }
