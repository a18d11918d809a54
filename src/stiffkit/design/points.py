"""Single designs of a finished study: their robots, robot files and maps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stiffkit.design.robot_file import write_robot_file
from stiffkit.errors import StiffkitError
from stiffkit.progress import Progress, no_progress
from stiffkit.robot import load_robot
from stiffkit.study import map_workspace
from stiffkit.study.map import MODELS
from stiffkit.units import Value, parse_unit

if TYPE_CHECKING:
    import xarray as xr

_KINDS = ("continuous", "integer", "choice", "derived")


def parameters_of(designs: xr.Dataset, number: int) -> dict[str, float]:
    """Return the parameters of the robot file, SI, that a design sets.

    Raises StiffkitError where there is no design of that number.
    """
    count = designs.sizes["design"]
    if not 0 <= number < count:
        raise StiffkitError(
            f"there is no design {number}", mend=f"give a number from 0 to {count - 1}"
        )
    own = designs.isel(design=number)
    return {str(n): float(v) for n, v in own.data_vars.items() if v.attrs.get("kind") in _KINDS}


def write_design_robot(designs: xr.Dataset, number: int, target: Path) -> None:
    """Write the robot file of a design: that of the study with its parameters.

    Raises FileError or OutputError where that is not possible; see `write_robot_file`.
    """
    write_robot_file(str(designs.attrs["robot"]), parameters_of(designs, number), target)


def map_design(
    designs: xr.Dataset, number: int, points: int, progress: Progress = no_progress
) -> xr.Dataset:
    """Return the stiffness map of a design, with about so many postures, by the study's models."""
    values = {
        name: _with_unit(designs, name, si) for name, si in parameters_of(designs, number).items()
    }
    robot = load_robot(str(designs.attrs["robot"]), values)
    models = [model for model in MODELS if model in designs["model"].values]
    return map_workspace(robot, points=points, models=models, frequencies=False, progress=progress)


def _with_unit(designs: xr.Dataset, name: str, si: float) -> Value:
    """Return a parameter with its dimension, which expressions of the robot file may ask for."""
    units = str(designs[name].attrs["units"])
    return Value(si, None if units == "1" else parse_unit(units).dims)
