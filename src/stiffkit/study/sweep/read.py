"""Study files: YAML, read as robot files are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import cast

import numpy as np

from stiffkit.errors import UnitError
from stiffkit.files import Entry, Problems, Scope, check_shape, read_source, read_tree, suggest
from stiffkit.files.parameters import check_same_dimension
from stiffkit.robot import Robot, list_robots, load_robot
from stiffkit.stiffness import Model
from stiffkit.study.quantities import QUANTITIES, needs_load
from stiffkit.study.sweep.spec import STATISTICS, Column, StatisticName, StudySpec, Varied
from stiffkit.units import Value, parse_quantity

SCHEMA_FILE = Path(__file__).parents[1] / "schema.json"
"""The published schema of study files."""

POSTURES = 1000
"""Postures of each geometry if nothing is said."""

MOST_GEOMETRIES = 10_000_000

RESERVED = (
    "geometry",
    "model",
    "coordinate",
    "geometry_status",
    "reason",
    "postures_ok",
    "postures_unreachable",
    "postures_singular",
    "frequency_posture",
    "frequency_first",
    "frequency_error",
)
"""Names in the table that columns cannot have."""


def read_study(path: Path) -> StudySpec:
    """Return the study of a file.

    Raises FileError, with the place and how to mend it, where anything is wrong with it or with the
    robot file that it names.
    """
    root = read_tree(read_source(path), "study: TITLE")
    check_shape(root, path, SCHEMA_FILE)
    entry = Entry(path, (), root)
    name = _robot_name(entry["robot"])
    robot = load_robot(name)
    return _Reader(entry, robot).read(name)


def _robot_name(entry: Entry) -> str:
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


class _Reader:
    """Reads a study of a robot whose file has been read."""

    def __init__(self, entry: Entry, robot: Robot) -> None:
        self.robot = robot
        given = {name: _as_written(p.value, p.unit) for name, p in robot.parameters.items()}
        self.parameters: Mapping[str, Value] = given
        self.entry = Entry(entry.path, (), entry.node, Scope(given))

    def read(self, robot: str) -> StudySpec:
        problems = Problems()
        sample, seed = None, 0
        with problems.collect():
            sample, seed = self.sampling()
        varied: list[Varied] = []
        for name, entry in self.entry["vary"].items():
            with problems.collect():
                varied.append(self.varied(name, entry, in_grid=sample is None))
        models = self.models()
        frequency_postures = 0
        with problems.collect():
            frequency_postures = self.frequency_postures(models)
        columns: list[Column] = []
        for name, entry in self.results():
            with problems.collect():
                columns.append(self.column(name, entry, frequency_postures))
        problems.check()
        postures = self.entry.get("postures")
        spec = StudySpec(
            title=self.entry["study"].text(),
            robot=robot,
            varied=tuple(varied),
            sample=sample,
            seed=seed,
            postures=POSTURES if postures is None else _count(postures),
            models=models,
            frequency_postures=frequency_postures,
            columns=tuple(columns) or tuple(self.usual_columns(frequency_postures)),
        )
        if spec.n_geometries > MOST_GEOMETRIES:
            raise self.entry["vary"].error(
                f"these are {spec.n_geometries} geometries, more than {MOST_GEOMETRIES}",
                "give fewer values, or 'sampling: {latin hypercube: 100000}'",
            )
        return spec

    def sampling(self) -> tuple[int | None, int]:
        """Return the number of geometries of a random sample, None for a grid, and its seed."""
        entry = self.entry.get("sampling")
        if entry is None or entry.is_text("grid"):
            return None, 0
        if not isinstance(entry.node.value, dict):
            raise entry.error(
                f"'{entry.text()}' is no way to choose geometries",
                "write 'grid', or '{latin hypercube: 1000, seed: 1}'",
            )
        seed = entry.get("seed")
        return _count(entry["latin hypercube"]), 0 if seed is None else _count(seed)

    def varied(self, name: str, entry: Entry, *, in_grid: bool) -> Varied:
        if name not in self.parameters:
            raise entry.error(
                f"{self.robot.name} has no parameter '{name}'",
                suggest(name, self.parameters) or "its file has no parameters",
            )
        unit = self.robot.parameters[name].unit
        if isinstance(entry.node.value, list):
            if not in_grid:
                raise entry.error(
                    "a latin hypercube needs a range", "write '{from: 300 mm, to: 500 mm}'"
                )
            return Varied(name, tuple(self.value(name, one) for one in entry.elements()), unit)
        low, high = self.value(name, entry["from"]), self.value(name, entry["to"])
        count = entry.get("count")
        if not in_grid:
            if count is not None:
                raise count.error("a latin hypercube counts geometries itself", "remove 'count'")
            return Varied(name, (low, high), unit)
        if count is None:
            raise entry.error(
                "'count' is missing",
                "say how many values the grid has, or choose 'sampling: {latin hypercube: ...}'",
            )
        return Varied(name, tuple(np.linspace(low, high, _count(count)).tolist()), unit)

    def value(self, name: str, entry: Entry) -> float:
        value = entry.value()
        try:
            check_same_dimension(name, self.parameters[name], value)
        except UnitError as error:
            raise entry.error(error.what, error.mend) from None
        return value.si

    def models(self) -> tuple[Model, ...]:
        entry = self.entry.get("models")
        if entry is None:
            return ("refined",)
        return tuple(cast(Model, one.text()) for one in entry.elements())

    def frequency_postures(self, models: Sequence[Model]) -> int:
        entry = self.entry.get("frequencies")
        if entry is None:
            return 0
        if "refined" not in models:
            raise entry.error(
                "frequencies are those of the refined model", "add 'refined' to the models"
            )
        if not (self.robot.tool.mass or any(link.mass for link in self.robot.links.values())):
            raise entry.error(
                f"{self.robot.name} has no mass anywhere, so nothing can vibrate",
                "give links a mass or a material in the robot file, or leave this out",
            )
        return _count(entry["postures"])

    def results(self) -> Iterator[tuple[str, Entry]]:
        entry = self.entry.get("results")
        return iter(()) if entry is None else entry.items()

    def column(self, name: str, entry: Entry, frequency_postures: int) -> Column:
        if name in self.parameters:
            raise entry.error(f"'{name}' is the name of a parameter", "choose another name")
        if name in RESERVED or name.endswith("_at"):
            raise entry.error(f"the table has a column '{name}' of its own", "choose another name")
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
            raise place.error(
                "the study computes no frequencies", "add 'frequencies: {postures: 10}'"
            )
        value = None
        if statistic == "percentile":
            value = float(cast(float, entry[statistic].node.value))
        elif not simple:
            value = entry[statistic].quantity(QUANTITIES[quantity].dimension)
        return Column(name, statistic, quantity, self.load(entry, quantity), value)

    def load(self, entry: Entry, quantity: str) -> str | None:
        given, loads = entry.get("load"), list(self.robot.loads)
        if not needs_load(quantity):
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
                f"{self.robot.name} has no load case '{given.text()}'", suggest(given.text(), loads)
            )
        return given.text()

    def usual_columns(self, frequency_postures: int) -> Iterator[Column]:
        """Yield what a table has if the file does not say."""
        yield Column("weakest", "min", "stiffness_translation_min")
        yield Column("weakest_rotation", "min", "stiffness_rotation_min")
        yield Column("mean_stiffness", "mean", "stiffness_translation_min")
        for load in self.robot.loads:
            name = f"worst_{load}".replace("-", "_")
            yield Column(name, "max", "deflection_translation", load)
        if frequency_postures:
            yield Column("lowest_frequency", "min", "frequency_first")


def _as_written(si: float, unit: str) -> Value:
    """Return an SI value with the dimension of a unit, "" for one that fits any."""
    if not unit:
        return Value(si)
    return Value(si, parse_quantity(f"1 {unit}").dims, unit=unit)


def _count(entry: Entry) -> int:
    value = entry.node.value
    if not isinstance(value, int | float) or value != int(value):
        raise entry.error(f"'{entry.text()}' is no whole number", "write one, such as 1000")
    return int(value)


def _known() -> str:
    return "add 'of: QUANTITY'; the quantities are " + ", ".join(QUANTITIES)
