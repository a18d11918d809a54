"""Stiffness maps: every posture of the workspace, by both models."""

from __future__ import annotations

import json
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.compiled import limited_threads
from stiffkit.errors import PoseError
from stiffkit.kinematics import Postures, Status
from stiffkit.progress import Progress, no_progress
from stiffkit.robot import DIRECTIONS, Robot, with_place
from stiffkit.stiffness import Model, lower_triangles
from stiffkit.study.analysis import Analysis
from stiffkit.study.frequencies import MOST_POSTURES, N_MODES, has_mass, map_frequencies
from stiffkit.study.grid import PoseGrid, pose_grid
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.values import MapValues, reader

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
MODELS: tuple[Model, ...] = ("refined", "simplified")


def map_workspace(
    robot: Robot | Analysis,
    *,
    points: int | None = None,
    models: Sequence[Model] = MODELS,
    frequencies: bool | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the stiffness map of a robot's workspace.

    The sweep dimensions are the workspace's tool coordinates, or "point" for a list of points; all
    values are SI, each variable has the attributes ``units`` and ``long_name``. Natural
    ``frequencies`` are among them if the robot has mass and the map is not too large for it (see
    `stiffkit.study.frequencies.MOST_POSTURES`), unless asked for or refused. The
    numbers do not depend on the number of ``threads``, which is `stiffkit.compiled.thread_count`
    if not given. Raises PoseError if the workspace is over coordinates in which the tool cannot
    move independently.
    """
    with limited_threads(threads):
        return _map(robot, points, models, frequencies, progress or no_progress)


def _map(
    robot: Robot | Analysis,
    points: int | None,
    models: Sequence[Model],
    frequencies: bool | None,
    report: Progress,
) -> xr.Dataset:
    analysis = robot if isinstance(robot, Analysis) else Analysis(robot)
    grid = pose_grid(analysis.robot, points)
    report("closing loops", 0.0)
    postures = postures_of(analysis, grid)
    values = _values(analysis, postures, models, report)
    values.status[:, ~grid.inside] = Status.OUTSIDE
    dataset = _dataset(analysis, grid, postures, values, models)
    wanted = len(postures) <= MOST_POSTURES if frequencies is None else frequencies
    if wanted and has_mass(analysis.robot):
        report("natural frequencies", 0.9)
        _add_frequencies(dataset, analysis, grid, postures, values, models)
    report("done", 1.0)
    return dataset


def postures_of(analysis: Analysis, grid: PoseGrid, *, detours: bool = True) -> Postures:
    """Return the postures at the poses of a grid; see `Kinematics.solve` for ``detours``.

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
    return kinematics.solve(asked, wanted=grid.inside, detours=detours)


def _values(
    analysis: Analysis, postures: Postures, models: Sequence[Model], report: Progress
) -> MapValues:
    n, loads = len(postures), list(analysis.robot.loads.values())
    values = MapValues.empty(len(models), len(loads), n)
    wrenches = np.array([load.wrench for load in loads]).reshape(-1, 6)
    read = reader(wrenches, n * len(models), analysis.kinematics.backend)
    for m, name in enumerate(models):

        def done(count: int, what: str = f"{name} model", before: int = m) -> None:
            report(what, (before + count / n) / len(models))

        values.fill(m, analysis.model(name), postures, read, done)
    return values


def _dataset(
    analysis: Analysis,
    grid: PoseGrid,
    postures: Postures,
    values: MapValues,
    models: Sequence[Model],
) -> xr.Dataset:
    import xarray as xr  # slow to import, and not needed for a single pose

    robot, sweep = analysis.robot, grid.dims

    def variable(
        dims: tuple[str, ...], array: NDArray[Any], units: str, long_name: str, **more: Any
    ) -> xr.Variable:
        shaped = array.reshape(*array.shape[:-1], *grid.shape)
        return xr.Variable((*dims, *sweep), shaped, {"units": units, "long_name": long_name} | more)

    flags = {
        "flag_values": np.array([int(s) for s in Status], dtype=np.int8),
        "flag_meanings": " ".join(s.word for s in Status),
    }
    data = {
        "status": variable(("model",), values.status, "1", "status of the posture", **flags),
        "tool": variable(("direction",), postures.tool, "m, rad", "tool pose"),
        "joint": variable(("joint_coordinate",), postures.joints, "m, rad", "joint coordinate"),
        "compliance": variable(
            ("model", "direction", "direction_load"),
            values.compliance,
            "m/N, 1/N, rad/(N m)",
            "compliance at the tool point, world axes",
        ),
        "deflection": variable(
            ("model", "load", "direction"), values.deflection, "m, rad", "deflection"
        ),
    }
    for name, array in values.deflections.items():
        data[name] = variable(("model", "load"), array, *_about(name))
    for name, array in values.stiffnesses.items():
        data[name] = variable(("model",), array, *_about(name))
    coordinates: dict[str, Any] = {
        "model": list(models),
        "load": list(robot.loads),
        "direction": list(DIRECTIONS),
        "direction_load": list(DIRECTIONS),
        "joint_coordinate": analysis.kinematics.joint_names,
    }
    for name, places in grid.axes.items():
        unit = "rad" if name.startswith("r") else "m"
        dims = ("point",) if grid.listed else (name,)
        coordinates[name] = (dims, places, {"units": unit, "long_name": f"tool coordinate {name}"})
    return xr.Dataset(data, coordinates, _attributes(analysis, models))


def _about(name: str) -> tuple[str, str]:
    """Return the units and the long name of a quantity."""
    quantity = QUANTITIES[name]
    return quantity.units, quantity.long_name


def _add_frequencies(
    dataset: xr.Dataset,
    analysis: Analysis,
    grid: PoseGrid,
    postures: Postures,
    values: MapValues,
    models: Sequence[Model],
) -> None:
    simplified = [m for m, name in enumerate(models) if name == "simplified"]
    lower = lower_triangles(values.compliance[simplified[0]]) if simplified else np.empty(0)
    found = map_frequencies(analysis, grid, postures, values.status, lower, models)

    def shaped(values: Array) -> Array:
        return values.reshape(*values.shape[:-1], *grid.shape)

    method = {"method": found.method}
    dataset.coords["mode"] = np.arange(1, N_MODES + 1)
    dataset["frequency"] = (
        ("model", "mode", *grid.dims),
        shaped(found.values),
        {"units": "Hz", "long_name": "natural frequency"} | method,
    )
    lowest = QUANTITIES["frequency_first"]
    dataset[lowest.name] = (
        ("model", *grid.dims),
        shaped(lowest.of(found.values.swapaxes(0, 1))),
        {"units": lowest.units, "long_name": lowest.long_name} | method,
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
