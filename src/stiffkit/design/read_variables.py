"""What is free in a design: ranges, whole numbers, choices."""

from __future__ import annotations

from collections.abc import Mapping

from stiffkit.design.spec import Variable
from stiffkit.files import Entry
from stiffkit.robot import Robot
from stiffkit.study.sweep.written import check_parameter, read_count, read_parameter
from stiffkit.units import Value

_MOST_INTEGERS = 10_000


def read_variable(
    name: str, entry: Entry, robot: Robot, parameters: Mapping[str, Value]
) -> Variable:
    """Return what a mapping under a name says is free.

    Raises FileError where the robot has no such parameter, or the values cannot be.
    """
    given = [key for key in ("from", "integers", "choose") if key in entry]
    if len(given) != 1 or ("to" in entry) != (given == ["from"]):
        raise entry.error(
            "a range, whole numbers or a choice is expected here",
            "write '{from: 300 mm, to: 500 mm}', '{integers: [1, 5]}' or '{choose: [2 mm, 3 mm]}'",
        )
    if given == ["choose"] and isinstance(entry["choose"].node.value, dict):
        return _options(name, entry["choose"], robot, parameters)
    check_parameter(name, entry, robot)
    unit = robot.parameters[name].unit
    match given[0]:
        case "from":
            low, high = (read_parameter(name, entry[end], parameters) for end in ("from", "to"))
            if not low < high:
                raise entry.error(
                    f"'from' is not below 'to': {low:g} and {high:g} in SI", "exchange them"
                )
            return Variable(name, "continuous", (name,), ((low, high),), (unit,))
        case "integers":
            first, last = (read_count(one) for one in entry["integers"].elements())
            if not 0 < last - first < _MOST_INTEGERS:
                raise entry["integers"].error(
                    f"from {first} to {last} there are not 2 to {_MOST_INTEGERS} whole numbers",
                    "write the smallest and the largest, such as [10, 20]",
                )
            values = tuple(float(i) for i in range(first, last + 1))
            return Variable(name, "integer", (name,), (values,), (unit,))
    chosen = entry["choose"].elements()
    values = tuple(read_parameter(name, one, parameters) for one in chosen)
    return Variable(name, "choice", (name,), (values,), (unit,))


def _options(name: str, entry: Entry, robot: Robot, parameters: Mapping[str, Value]) -> Variable:
    """Return a choice of names, each of which sets the same parameters."""
    options = dict(entry.items())
    first = next(iter(options.values()))
    names = tuple(key for key, _ in first.items())
    rows: list[list[float]] = []
    for option in options.values():
        given = dict(option.items())
        for parameter, one in given.items():
            check_parameter(parameter, one, robot)
        if given.keys() != set(names):
            raise option.error(
                f"this option sets {', '.join(given)}, and the first one {', '.join(names)}",
                "let all options set the same parameters",
            )
        rows.append([read_parameter(one, given[one], parameters) for one in names])
    values = tuple(tuple(column) for column in zip(*rows, strict=True))
    units = tuple(robot.parameters[one].unit for one in names)
    return Variable(name, "choice", names, values, units, tuple(options))
