"""Stiffness maps: every posture of the workspace, by both models."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.errors import PoseError
from stiffkit.kinematics import Postures, Status
from stiffkit.robot import DIRECTIONS, Load, Robot, with_place
from stiffkit.stiffness import (
    Compliances,
    Model,
    deflection,
    entry,
    lower_triangles,
    rotational_stiffness,
    translational_stiffness,
)
from stiffkit.study.analysis import Analysis
from stiffkit.study.frequencies import MOST_POSTURES, N_MODES, has_mass, map_frequencies
from stiffkit.study.grid import PoseGrid, pose_grid

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
"""Called with what is being done and the share that is done, 0 to 1."""

MODELS: tuple[Model, ...] = ("refined", "simplified")

_BLOCK = 1 << 13
"""Postures at a time: what is computed of them then stays in the cache."""
_SLOW_BLOCK = 1 << 8
"""Postures at a time where each takes a millisecond, so that progress shows."""


def map_workspace(
    robot: Robot | Analysis,
    *,
    points: int | None = None,
    models: Sequence[Model] = MODELS,
    frequencies: bool | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the stiffness map of a robot's workspace.

    The sweep dimensions are the workspace's tool coordinates, or "point" for a list of points; all
    values are SI, each variable has the attributes ``units`` and ``long_name``. Natural
    ``frequencies`` are among them if the robot has mass and the map is not too large for it (see
    `stiffkit.study.frequencies.MOST_POSTURES`), unless asked for or refused. Raises PoseError
    if the workspace is over coordinates in which the tool cannot move independently.
    """
    report = progress or (lambda _what, _share: None)
    analysis = robot if isinstance(robot, Analysis) else Analysis(robot)
    grid = pose_grid(analysis.robot, points)
    report("closing loops", 0.0)
    postures = postures_of(analysis, grid)
    loads = list(analysis.robot.loads.values())
    quantities = _Quantities.empty(len(models), len(loads), len(postures))
    for m, name in enumerate(models):
        stiffness = analysis.model(name)
        size = _SLOW_BLOCK if stiffness.method == "assembly" else _BLOCK
        for start in range(0, len(postures), size):
            report(f"{name} model", (m + start / len(postures)) / len(models))
            block = slice(start, start + size)
            found = stiffness.at(postures.part(block))
            quantities.fill(m, block, found, loads)
    quantities.status[:, ~grid.inside] = Status.OUTSIDE
    dataset = _dataset(analysis, grid, postures, quantities, models)
    wanted = len(postures) <= MOST_POSTURES if frequencies is None else frequencies
    if wanted and has_mass(analysis):
        report("natural frequencies", 0.9)
        _add_frequencies(dataset, analysis, grid, postures, quantities, models)
    report("done", 1.0)
    return dataset


def postures_of(analysis: Analysis, grid: PoseGrid) -> Postures:
    """Return the postures at the poses of a grid.

    Raises PoseError if it is over coordinates in which the tool cannot move independently.
    """
    kinematics = analysis.kinematics
    values = grid.values()
    for name in values:
        if name not in kinematics.asked:
            independent = ", ".join(kinematics.asked) or "none"
            error = PoseError(
                f"the workspace is over '{name}', but the tool of {analysis.robot.name} cannot be"
                f" moved along it independently",
                mend=f"its independent tool coordinates are: {independent}",
            )
            raise with_place(error, analysis.robot, f"workspace.{name}")
    home = kinematics.home.tool[:, 0]
    n = grid.inside.size
    asked = np.stack(
        [values.get(d, np.full(n, home[DIRECTIONS.index(d)])) for d in kinematics.asked]
    )
    return kinematics.solve(asked, wanted=grid.inside)


_QUANTITIES = {
    "deflection_translation": ("m", "deflection of the tool point"),
    "deflection_xy": ("m", "deflection of the tool point in the x-y plane"),
    "deflection_z": ("m", "deflection of the tool point along z"),
    "deflection_rotation": ("rad", "rotation of the tool"),
    "stiffness_translation_min": ("N/m", "translational stiffness, weakest direction"),
    "stiffness_translation_max": ("N/m", "translational stiffness, strongest direction"),
    "stiffness_rotation_min": ("N m/rad", "rotational stiffness, weakest direction"),
    "stiffness_rotation_max": ("N m/rad", "rotational stiffness, strongest direction"),
}


@dataclass(frozen=True, eq=False)
class _Quantities:
    """The arrays of a map, filled block by block; NaN where the status is not OK."""

    status: NDArray[np.int8]
    compliance: Array
    deflection: Array
    scalars: dict[str, Array]
    """The quantities of `_QUANTITIES`."""

    @staticmethod
    def empty(n_models: int, n_loads: int, n: int) -> _Quantities:
        def shape(name: str) -> tuple[int, ...]:
            return (n_models, n_loads, n) if name.startswith("deflection") else (n_models, n)

        return _Quantities(
            np.zeros((n_models, n), dtype=np.int8),
            np.empty((n_models, 6, 6, n)),
            np.empty((n_models, n_loads, 6, n)),
            {name: np.empty(shape(name)) for name in _QUANTITIES},
        )

    def fill(self, m: int, block: slice, found: Compliances, loads: Sequence[Load]) -> None:
        self.status[m, block] = found.status
        for i in range(6):
            for j in range(6):
                self.compliance[m, i, j, block] = entry(found.lower, i, j)
        for i, load in enumerate(loads):
            d = deflection(found.lower, load.wrench)
            self.deflection[m, i, :, block] = d
            in_plane = d[0] * d[0] + d[1] * d[1]
            turned = d[3] * d[3] + d[4] * d[4] + d[5] * d[5]
            self.scalars["deflection_translation"][m, i, block] = np.sqrt(in_plane + d[2] * d[2])
            self.scalars["deflection_xy"][m, i, block] = np.sqrt(in_plane)
            self.scalars["deflection_z"][m, i, block] = np.abs(d[2])
            self.scalars["deflection_rotation"][m, i, block] = np.sqrt(turned)
        for kind, extremes in (
            ("translation", translational_stiffness(found.lower)),
            ("rotation", rotational_stiffness(found.lower)),
        ):
            self.scalars[f"stiffness_{kind}_min"][m, block] = extremes.weakest
            self.scalars[f"stiffness_{kind}_max"][m, block] = extremes.strongest


def _dataset(
    analysis: Analysis,
    grid: PoseGrid,
    postures: Postures,
    quantities: _Quantities,
    models: Sequence[Model],
) -> xr.Dataset:
    import xarray as xr  # slow to import, and not needed for a single pose

    robot, sweep = analysis.robot, grid.dims

    def variable(
        dims: tuple[str, ...], values: NDArray[Any], units: str, long_name: str, **more: Any
    ) -> xr.Variable:
        shaped = values.reshape(*values.shape[:-1], *grid.shape)
        return xr.Variable((*dims, *sweep), shaped, {"units": units, "long_name": long_name} | more)

    flags = {
        "flag_values": np.array([int(s) for s in Status], dtype=np.int8),
        "flag_meanings": " ".join(s.word for s in Status),
    }
    data = {
        "status": variable(("model",), quantities.status, "1", "status of the posture", **flags),
        "tool": variable(("direction",), postures.tool, "m, rad", "tool pose"),
        "joint": variable(("joint_coordinate",), postures.joints, "m, rad", "joint coordinate"),
        "compliance": variable(
            ("model", "direction", "direction_load"),
            quantities.compliance,
            "m/N, 1/N, rad/(N m)",
            "compliance at the tool point, world axes",
        ),
        "deflection": variable(
            ("model", "load", "direction"), quantities.deflection, "m, rad", "deflection"
        ),
    }
    for name, values in quantities.scalars.items():
        dims = ("model", "load") if name.startswith("deflection") else ("model",)
        data[name] = variable(dims, values, *_QUANTITIES[name])
    coordinates: dict[str, Any] = {
        "model": list(models),
        "load": list(robot.loads),
        "direction": list(DIRECTIONS),
        "direction_load": list(DIRECTIONS),
        "joint_coordinate": analysis.kinematics.joint_names,
    }
    for name, values in grid.axes.items():
        unit = "rad" if name.startswith("r") else "m"
        dims = ("point",) if grid.listed else (name,)
        coordinates[name] = (dims, values, {"units": unit, "long_name": f"tool coordinate {name}"})
    return xr.Dataset(data, coordinates, _attributes(analysis, models))


def _add_frequencies(
    dataset: xr.Dataset,
    analysis: Analysis,
    grid: PoseGrid,
    postures: Postures,
    quantities: _Quantities,
    models: Sequence[Model],
) -> None:
    simplified = [m for m, name in enumerate(models) if name == "simplified"]
    lower = lower_triangles(quantities.compliance[simplified[0]]) if simplified else np.empty(0)
    found = map_frequencies(analysis, grid, postures, quantities.status, lower, models)

    def shaped(values: Array) -> Array:
        return values.reshape(*values.shape[:-1], *grid.shape)

    about = {"units": "Hz", "method": found.method}
    dataset.coords["mode"] = np.arange(1, N_MODES + 1)
    dataset["frequency"] = (
        ("model", "mode", *grid.dims),
        shaped(found.values),
        about | {"long_name": "natural frequency"},
    )
    dataset["frequency_first"] = (
        ("model", *grid.dims),
        shaped(found.values[:, 0]),
        about | {"long_name": "lowest natural frequency"},
    )
    dataset.coords["branch"] = np.arange(1, N_MODES + 1)
    followed, no_answer = found.followed, np.full(found.values.shape[1:], np.nan)
    everywhere = [followed[m].everywhere if m in followed else no_answer for m in models]
    dataset["frequency_of_branch"] = (
        ("model", "branch", *grid.dims),
        shaped(np.stack(everywhere)),
        _about_branches({m: f.facts for m, f in followed.items()}, ""),
    )
    for axis in () if grid.listed else grid.axes:
        no_answer = np.full((N_MODES, grid.axes[axis].size), np.nan)
        along = [followed[m].along[axis] if m in followed else no_answer for m in models]
        dataset[f"frequency_along_{axis}"] = (
            ("model", "branch", axis),
            np.stack(along),
            _about_branches({m: f.facts_along[axis] for m, f in followed.items()}, axis),
        )


def _about_branches(facts: dict[Model, dict[str, Any]], axis: str) -> dict[str, str]:
    """Return the attributes of frequencies of branches: everywhere, or along an axis."""
    place = f" along {axis} through the middle of the workspace" if axis else ""
    return {
        "units": "Hz",
        "long_name": f"natural frequency of a mode followed by its shape{place}",
        "method": "the modes of neighbouring postures whose shapes overlap most are one branch;"
        " branches are numbered by frequency at a start near the middle of the workspace",
        "tracking": json.dumps(facts),
    }


def _attributes(analysis: Analysis, models: Sequence[Model]) -> dict[str, Any]:
    robot = analysis.robot
    home = analysis.kinematics.home.tool[:, 0]
    free = analysis.refined.at_home.free_motions if analysis.refined.uncontrolled else ()
    return {
        "title": robot.title,
        "robot": robot.name,
        "robot_hash": robot.content_hash,
        "stiffkit_version": __version__,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "options": json.dumps(
            {
                "models": list(models),
                "parameters": {name: p.value for name, p in robot.parameters.items()},
                "methods": {name: analysis.model(name).method for name in models},
            }
        ),
        "loads": json.dumps({name: load.wrench.tolist() for name, load in robot.loads.items()}),
        "free_motions": [analysis.words(motion, home) for motion in free],
        "notes": list(robot.notes),
    }
