"""The numbers of a map as JSON for the page: float32 in display units, decimated if need be."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stiffkit.plots import (
    BranchLine,
    Columns,
    DisplayUnit,
    Kind,
    Sweep,
    axis_unit,
    branch_lines,
    branch_model,
    cases_of,
    columns_of,
    display_unit,
    format_value,
    has_branches,
    is_planar,
    loads_of,
    main_quantities,
    middle_posture,
    models_of,
    position_text,
    quantities_of,
    status_of,
    sweep_of,
)
from stiffkit.report.decimate import (
    Blocks,
    block_sizes,
    centres_of_blocks,
    coordinates_of_blocks,
    status_of_blocks,
    worst_of_blocks,
)

Array = NDArray[np.float64]

PLOTTED_POSTURES = 12_000
"""A page shows at most this many postures, ..."""
PLOTTED_NUMBERS = 600_000
"""... and at most this many numbers in all, for maps with many loads or joints."""
FEWEST_POSTURES = 2_000

WORST = 10
"""Rows in the table of the worst postures."""

RATIO = "ratio"
"""Stands for refined over simplified where a model's name is expected."""


def payload_of(dataset: xr.Dataset) -> dict[str, Any]:
    """Return everything that the page's script draws from, ready for `json_text`.

    Values are base64 of little-endian float32 in display units, in C order of ``shape``.
    """
    sweep = sweep_of(dataset)
    blocks = block_sizes(sweep.shape, _posture_limit(dataset))
    models = models_of(dataset)
    planar = is_planar(dataset)
    shape = [-(-n // block) for n, block in zip(sweep.shape, blocks, strict=True)]
    status = {m: status_of_blocks(status_of(dataset, m), blocks) for m in models}
    return {
        "isGrid": sweep.is_grid,
        "shape": shape,
        "blocks": list(blocks),
        "axes": [_axis(sweep, axis, blocks) for axis in sweep.axes],
        "models": list(models),
        "loads": list(loads_of(dataset)),
        "middle": list(middle_posture(status[models[0]])),
        "first": main_quantities(dataset, planar=planar)[0].name,
        "status": {m: "".join(str(int(v)) for v in s.ravel()) for m, s in status.items()},
        "others": _other_coordinates(dataset, sweep, blocks),
        **_of_quantities(dataset, sweep, blocks),
        "branches": _branches(dataset) if has_branches(dataset) else None,
    }


def json_text(value: object) -> str:
    """Return JSON as browsers read it. Raises ValueError if a number is not finite."""
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


def worst_postures(values: Array, *, worst_is_largest: bool, count: int = WORST) -> list[int]:
    """Return flat indices of the ``count`` worst finite values, the worst first."""
    flat = values.ravel()
    badness = np.where(np.isfinite(flat), flat if worst_is_largest else -flat, -np.inf)
    count = min(count, int(np.isfinite(flat).sum()))
    if count == 0:
        return []
    candidates = np.argpartition(-badness, count - 1)[:count]
    return [int(i) for i in candidates[np.argsort(-badness[candidates], kind="stable")]]


def _posture_limit(dataset: xr.Dataset) -> int:
    models = len(models_of(dataset))
    arrays = dataset.sizes.get("joint_coordinate", 0) + models * sum(
        len(cases_of(dataset, quantity)) for quantity in quantities_of(dataset)
    )
    return int(np.clip(PLOTTED_NUMBERS // max(arrays, 1), FEWEST_POSTURES, PLOTTED_POSTURES))


def _axis(sweep: Sweep, axis: str, blocks: Blocks) -> dict[str, Any]:
    unit = axis_unit(axis)
    block = blocks[sweep.axes.index(axis)] if sweep.is_grid else blocks[0]
    shown = unit.of(coordinates_of_blocks(sweep.coordinates[axis], block))
    values = [_short(value) for value in shown]
    return {"name": axis, "unit": unit.symbol, "values": values, "isLength": axis[0] != "r"}


def _short(value: float) -> float:
    """Return a coordinate as it is shown and compared, without what rounding left of a zero."""
    return float(f"{np.round(value, 9) + 0.0:.7g}")


def _other_coordinates(dataset: xr.Dataset, sweep: Sweep, blocks: Blocks) -> list[dict[str, Any]]:
    """Return what the hover text tells besides the swept coordinates: tool, then joints."""
    others = []
    for axis in dataset["direction"].values:
        values = dataset["tool"].sel(direction=axis).values
        known = values[np.isfinite(values)]
        varies = known.size > 0 and np.ptp(known) > 1e-12
        if str(axis) not in sweep.axes and varies:
            others.append(_coordinate(str(axis), axis_unit(str(axis)), values, blocks))
    if "joint" in dataset:
        for name in dataset["joint_coordinate"].values:
            values = dataset["joint"].sel(joint_coordinate=name).values
            others.append(_coordinate(str(name), joint_unit(str(name)), values, blocks))
    return others


def joint_unit(name: str) -> DisplayUnit:
    """Return the unit of a joint coordinate such as "motor_left.rz"."""
    return axis_unit(name.rsplit(".", maxsplit=1)[-1])


def _coordinate(name: str, unit: DisplayUnit, values: Array, blocks: Blocks) -> dict[str, Any]:
    shown = unit.of(centres_of_blocks(values, blocks))
    return {"name": name, "unit": unit.symbol, "data": _encode(shown)}


def _of_quantities(dataset: xr.Dataset, sweep: Sweep, blocks: Blocks) -> dict[str, Any]:
    """Return what the page knows of each quantity: its values, and its worst postures."""
    quantities: list[dict[str, Any]] = []
    values: dict[str, str] = {}
    worst: dict[str, list[dict[str, Any]]] = {}
    for quantity in quantities_of(dataset):
        units: dict[str, str] = {}
        for load in cases_of(dataset, quantity):
            columns = columns_of(dataset, quantity, load)
            units[load or ""] = columns.unit.symbol
            values |= _values(columns, blocks)
            worst |= _worst(dataset, sweep, columns)
        quantities.append(
            {
                "name": quantity.name,
                "label": quantity.label,
                "perLoad": quantity.per_load,
                "worstIsLargest": quantity.worst_is_largest,
                "units": units,
            }
        )
    return {"quantities": quantities, "values": values, "worst": worst}


def _values(columns: Columns, blocks: Blocks) -> dict[str, str]:
    quantity, load = columns.quantity, columns.load
    values = {}
    for model, column in columns.values.items():
        worst = worst_of_blocks(column, blocks, worst_is_largest=quantity.worst_is_largest)
        values[key_of(quantity.name, model, load)] = _encode(columns.unit.of(worst))
    return values


def _worst(dataset: xr.Dataset, sweep: Sweep, columns: Columns) -> dict[str, list[dict[str, Any]]]:
    quantity, load = columns.quantity, columns.load
    shown = {model: columns.unit.of(values) for model, values in columns.values.items()}
    if columns.ratio is not None:
        shown[RATIO] = columns.ratio
    tables = {}
    for model, values in shown.items():
        indices = worst_postures(values, worst_is_largest=quantity.worst_is_largest)
        tables[key_of(quantity.name, model, load)] = [
            _posture(dataset, sweep, index, float(values.flat[index])) for index in indices
        ]
    return tables


def _branches(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the frequencies of followed modes along lines through the workspace."""
    model = branch_model(dataset)
    lines = branch_lines(dataset, model)
    unit = display_unit(Kind.FREQUENCY, np.concatenate([line.values.ravel() for line in lines]))
    return {
        "model": model,
        "unit": unit.symbol,
        "lines": [_branch_line(line, unit) for line in lines],
    }


def _branch_line(line: BranchLine, unit: DisplayUnit) -> dict[str, Any]:
    # Along a line that is not a list of points there are never that many.
    shown = slice(None, None, -(-line.x.size // PLOTTED_POSTURES))
    return {
        "axis": line.axis or "number of the point",
        "unit": axis_unit(line.axis).symbol if line.axis else "",
        "fixed": position_text(line.fixed.items()),
        "x": _encode(line.x[shown]),
        "values": [_encode(unit.of(values[shown])) for values in line.values],
        "status": "".join(str(int(value)) for value in line.status[shown]),
    }


def _posture(dataset: xr.Dataset, sweep: Sweep, index: int, value: float) -> dict[str, Any]:
    where = np.unravel_index(index, sweep.shape)
    cut = dict(zip(sweep.axes if sweep.is_grid else ("point",), where, strict=True))
    tool = np.asarray(dataset["tool"].isel(cut).values, dtype=np.float64)
    directions = [str(d) for d in dataset["direction"].values]
    at = [_short(float(axis_unit(axis).of(tool[directions.index(axis)]))) for axis in sweep.axes]
    pose = [
        [d, format_value(float(np.round(axis_unit(d).of(v), 9))), axis_unit(d).symbol]
        for d, v in zip(directions, tool, strict=True)
    ]
    joints = []
    if "joint" in dataset:
        for name, q in zip(
            dataset["joint_coordinate"].values, dataset["joint"].isel(cut).values, strict=True
        ):
            unit = joint_unit(str(name))
            joints.append([str(name), format_value(float(unit.of(q))), unit.symbol])
    return {"at": at, "pose": pose, "joints": joints, "value": format_value(value)}


def key_of(quantity: str, model: str, load: str | None) -> str:
    """Return the key under which the page looks up a column of numbers."""
    return json.dumps([quantity, model, load or ""], separators=(",", ":"))


def _encode(values: Array) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")
