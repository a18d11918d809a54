"""What a robot is for: its tool, home posture, workspace and load cases."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffkit.files.entry import Entry
from stiffkit.files.frames import read_frame
from stiffkit.files.names import suggest
from stiffkit.robot.model import BASE, DIRECTIONS, Array, Home, Joint, Link, Load, Tool, Workspace
from stiffkit.robot.ports import read_port
from stiffkit.units import FORCE, LENGTH, MASS, MOMENT, NUMBER

_MOST_GRID_POINTS = 100_000


def read_tool(entry: Entry, links: Mapping[str, Link]) -> Tool:
    """Return the tool. Raises FileError where no link carries it."""
    port = read_port(entry["at"], links)
    if port.body == BASE:
        raise entry["at"].error("the tool is on the base, which stands still", "name a link")
    mass = entry["mass"].not_negative(MASS) if "mass" in entry else None
    T_body_tool = port.T_body_port @ read_frame(entry, at="offset")
    return Tool(port.body, T_body_tool, mass, port.name)


def read_home(entry: Entry | None, joints: Mapping[str, Joint]) -> Home:
    """Return the home posture. Raises FileError at unknown joints and wrong coordinates."""
    tool: dict[str, float] = {}
    joint_coordinates: dict[str, tuple[float, ...]] = {}
    for name, given in [] if entry is None else entry.items():
        if name in DIRECTIONS:
            if isinstance(given.node.value, list):
                raise given.error("one value is expected, not a list")
            tool[name] = given.coordinate(name)
        elif name in joints:
            joint_coordinates[name] = _joint_coordinates(given, joints[name])
        else:
            raise given.error(
                f"'{name}' is neither a joint nor a tool coordinate",
                suggest(name, [*joints, *DIRECTIONS]),
            )
    return Home(tool, joint_coordinates)


def _joint_coordinates(entry: Entry, joint: Joint) -> tuple[float, ...]:
    given = entry.elements() if isinstance(entry.node.value, list) else [entry]
    if len(given) != len(joint.motions):
        listed = ", ".join(joint.motions)
        raise entry.error(
            f"joint '{joint.name}' has {len(joint.motions)} coordinates"
            f"{f' ({listed})' if listed else ''}, {len(given)} are given",
            "give one value for each, in this order" if listed else "remove it",
        )
    return tuple(
        one.coordinate(direction) for one, direction in zip(given, joint.motions, strict=True)
    )


def read_workspace(entry: Entry | None) -> Workspace:
    """Return the workspace. Raises FileError where it is empty."""
    if entry is None:
        return Workspace()
    ranges: dict[str, tuple[float, float]] = {}
    counts: dict[str, int] = {}
    for direction in DIRECTIONS:
        if (given := entry.get(direction)) is not None:
            ranges[direction] = _range(given, direction)
            if len(given.elements()) == 3:
                counts[direction] = _count(given[2])
    polygon, points = entry.get("polygon"), entry.get("points")
    if points is not None:
        if ranges or polygon is not None:
            raise points.error(
                "'points' cannot stand beside ranges or a polygon", "keep one of them"
            )
        return _points(points)
    if polygon is None:
        return Workspace(ranges, counts)
    outline = _outline(polygon)
    # The outline bounds x and y itself, unless the file bounds them more narrowly.
    for i, axis in enumerate("xy"):
        ranges.setdefault(axis, (float(outline[:, i].min()), float(outline[:, i].max())))
    ordered = {direction: ranges[direction] for direction in DIRECTIONS if direction in ranges}
    return Workspace(ordered, counts, polygon=outline)


def _range(entry: Entry, direction: str) -> tuple[float, float]:
    low, high = (entry[i].coordinate(direction) for i in range(2))
    if low > high:
        raise entry.error(
            f"the workspace is empty: {entry[0].value()} is more than {entry[1].value()}"
            f" (in SI, {low:.6g} and {high:.6g})",
            "write the lower value first",
        )
    return low, high


def _count(entry: Entry) -> int:
    number = entry.quantity(NUMBER)
    if not (number.is_integer() and 1 <= number <= _MOST_GRID_POINTS):
        raise entry.error(
            f"'{entry.value()}' is no number of points", f"an integer, 1 to {_MOST_GRID_POINTS}"
        )
    return int(number)


def _outline(entry: Entry) -> Array:
    """Return the corners (n, 2) of a polygon that has an area."""
    corners = entry.matrix(LENGTH)
    x, y = corners.T
    area = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    extent = float(np.ptp(x) * np.ptp(y))
    if area <= 1e-9 * extent or extent == 0.0:
        raise entry.error(
            "the workspace is empty: the polygon has no area", "give its corners in turn"
        )
    return corners


def _points(entry: Entry) -> Workspace:
    columns = {
        direction: [one.coordinate(direction) for one in entry[direction].elements()]
        for direction in DIRECTIONS
        if direction in entry
    }
    lengths = {direction: len(values) for direction, values in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{direction} {length}" for direction, length in lengths.items())
        raise entry.error(
            f"the lists of points differ in length: {listed}",
            "give one value of each coordinate for each point",
        )
    return Workspace(points=np.array(list(columns.values())).T, point_axes=tuple(columns))


def read_loads(entry: Entry | None) -> dict[str, Load]:
    """Return the load cases by name. Raises FileError at wrong quantities."""
    loads = {}
    for name, given in [] if entry is None else entry.items():
        force = given["force"].vector(FORCE) if "force" in given else np.zeros(3)
        moment = given["moment"].vector(MOMENT) if "moment" in given else np.zeros(3)
        loads[name] = Load(name, np.concatenate([force, moment]))
    return loads
