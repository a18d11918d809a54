"""What study files and design files write alike: robots, parameters, statistics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import cast

from stiffkit.errors import UnitError
from stiffkit.files import Entry, Scope, check_shape, read_source, read_tree, suggest
from stiffkit.files.parameters import check_same_dimension
from stiffkit.robot import Robot, list_robots, load_robot
from stiffkit.stiffness import Model
from stiffkit.study.frequencies import has_mass
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.spec import STATISTICS, Column, StatisticName
from stiffkit.units import Value, parse_quantity


def open_about_robot(path: Path, begin: str, schema: Path) -> tuple[Entry, str, Robot]:
    """Return a file about a robot, and the robot that it names by name, read.

    Expressions in it know the robot's parameters. ``begin`` is what an empty file is to begin with,
    ``schema`` what its shape is checked against. Raises FileError where anything is wrong with it
    or with the robot file.
    """
    root = read_tree(read_source(path), begin)
    check_shape(root, path, schema)
    entry = Entry(path, (), root)
    name = read_robot_name(entry["robot"])
    robot = load_robot(name)
    return replace(entry, scope=Scope(values_of_parameters(robot))), name, robot


def read_robot_name(entry: Entry) -> str:
    """Return a robot of the catalogue, or the absolute path of a file relative to this one.

    Raises FileError where there is neither.
    """
    name = entry.text()
    if name in list_robots():
        return name
    path = entry.path.parent / name
    if not path.is_file():
        raise entry.error(
            f"there is no file '{path}', and no robot '{name}' in the catalogue",
            "give a file relative to this one; of the catalogue: " + suggest(name, list_robots()),
        )
    return str(path.resolve())


def values_of_parameters(robot: Robot) -> Mapping[str, Value]:
    """Return the parameters of a robot, for expressions in files about it."""
    return {name: _as_written(p.value, p.unit) for name, p in robot.parameters.items()}


def _as_written(si: float, unit: str) -> Value:
    """Return an SI value with the dimension of a unit, "" for one that fits any."""
    if not unit:
        return Value(si)
    return Value(si, parse_quantity(f"1 {unit}").dims, unit=unit)


def check_parameter(name: str, entry: Entry, robot: Robot) -> None:
    """Raise FileError where a robot has no parameter of a name."""
    if name not in robot.parameters:
        raise entry.error(
            f"{robot.name} has no parameter '{name}'",
            suggest(name, robot.parameters) or "its file has no parameters",
        )


def read_parameter(name: str, entry: Entry, parameters: Mapping[str, Value]) -> float:
    """Return a value of a parameter, SI. Raises FileError where it has another dimension."""
    value = entry.value()
    try:
        check_same_dimension(name, parameters[name], value)
    except UnitError as error:
        raise entry.error(error.what, error.mend) from None
    return value.si


def read_models(entry: Entry | None, default: tuple[Model, ...]) -> tuple[Model, ...]:
    """Return the models that a list names."""
    if entry is None:
        return default
    return tuple(cast(Model, one.text()) for one in entry.elements())


def read_count(entry: Entry) -> int:
    """Return a whole number. Raises FileError where it is none."""
    value = entry.node.value
    if not isinstance(value, int | float) or value != int(value):
        raise entry.error(f"'{entry.text()}' is no whole number", "write one, such as 1000")
    return int(value)


def check_masses(entry: Entry, robot: Robot) -> None:
    """Raise FileError where frequencies of a robot without any mass are asked for."""
    if not has_mass(robot):
        raise entry.error(
            f"{robot.name} has no mass anywhere, so nothing can vibrate",
            "give links a mass or a material in the robot file, or leave this out",
        )


def read_statistic(name: str, entry: Entry, robot: Robot, frequency_postures: int) -> Column:
    """Return the statistic that a mapping asks for, of a quantity over the workspace.

    Other keys in it are left to others. Raises FileError where it asks for what there is not.
    """
    given = [statistic for statistic in STATISTICS if statistic in entry]
    if len(given) != 1:
        raise entry.error(
            f"{' and '.join(given) or 'no statistic'} stands here, one is needed",
            f"give one of {', '.join(STATISTICS)}",
        )
    statistic: StatisticName = given[0]
    simple = statistic in ("min", "max", "mean")
    if simple and "of" in entry:
        raise entry["of"].error(
            f"'{statistic}' names its quantity itself", f"write '{statistic}: QUANTITY'"
        )
    if not simple and "of" not in entry:
        raise entry.error(f"'of' is missing: {statistic} of what?", _known())
    place = entry[statistic] if simple else entry["of"]
    quantity = place.text()
    if quantity not in QUANTITIES:
        raise place.error(f"'{quantity}' is no quantity", suggest(quantity, QUANTITIES))
    if quantity == "frequency_first" and not frequency_postures:
        raise place.error("the study computes no frequencies", "add 'frequencies: {postures: 10}'")
    value = None
    if statistic == "percentile":
        value = float(cast(float, entry[statistic].node.value))
    elif not simple:
        value = entry[statistic].quantity(QUANTITIES[quantity].dimension)
    return Column(name, statistic, quantity, _load(entry, quantity, robot), value)


def _load(entry: Entry, quantity: str, robot: Robot) -> str | None:
    given, loads = entry.get("load"), list(robot.loads)
    if not QUANTITIES[quantity].per_load:
        if given is not None:
            raise given.error(f"{quantity} is the same for all loads", "remove 'load'")
        return None
    if given is None:
        if len(loads) == 1:
            return loads[0]
        raise entry.error(
            f"under which load? {quantity} is that of a load case",
            f"add 'load: NAME'; known: {', '.join(loads)}"
            if loads
            else "the robot file has no loads; add some",
        )
    if given.text() not in loads:
        raise given.error(
            f"{robot.name} has no load case '{given.text()}'", suggest(given.text(), loads)
        )
    return given.text()


def _known() -> str:
    return "add 'of: QUANTITY'; the quantities are " + ", ".join(QUANTITIES)
