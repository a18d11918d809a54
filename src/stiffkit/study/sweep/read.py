"""Study files: YAML, read as robot files are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from stiffkit.files import Entry, Problems
from stiffkit.robot import Robot
from stiffkit.stiffness import Model
from stiffkit.study.sweep.spec import Column, StudySpec, Varied, slope_name
from stiffkit.study.sweep.written import (
    check_masses,
    check_parameter,
    open_about_robot,
    read_count,
    read_models,
    read_parameter,
    read_statistic,
    values_of_parameters,
)

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
    entry, name, robot = open_about_robot(path, "study: TITLE", SCHEMA_FILE)
    return _Reader(entry, robot).read(name)


class _Reader:
    """Reads a study of a robot whose file has been read."""

    def __init__(self, entry: Entry, robot: Robot) -> None:
        self.robot = robot
        self.parameters = values_of_parameters(robot)
        self.entry = entry

    def read(self, robot: str) -> StudySpec:
        problems = Problems()
        sample, seed = None, 0
        with problems.collect():
            sample, seed = self.sampling()
        varied: list[Varied] = []
        for name, entry in self.entry["vary"].items():
            with problems.collect():
                varied.append(self.varied(name, entry, in_grid=sample is None))
        models = read_models(self.entry.get("models"), ("refined",))
        frequency_postures = 0
        with problems.collect():
            frequency_postures = self.frequency_postures(models)
        columns: list[Column] = []
        for name, entry in self.results():
            with problems.collect():
                columns.append(self.column(name, entry, frequency_postures))
        problems.check()
        postures, derivatives = self.entry.get("postures"), self.entry.get("derivatives")
        spec = StudySpec(
            title=self.entry["study"].text(),
            robot=robot,
            varied=tuple(varied),
            sample=sample,
            seed=seed,
            postures=POSTURES if postures is None else read_count(postures),
            models=models,
            frequency_postures=frequency_postures,
            columns=tuple(columns) or tuple(self.usual_columns(frequency_postures)),
            derivatives=derivatives is not None and derivatives.node.value is True,
        )
        if derivatives is not None and spec.derivatives:
            self.check_derivatives(derivatives, spec)
        if spec.n_geometries > MOST_GEOMETRIES:
            raise self.entry["vary"].error(
                f"these are {spec.n_geometries} geometries, more than {MOST_GEOMETRIES}",
                "give fewer values, or 'sampling: {latin hypercube: 100000}'",
            )
        return spec

    def check_derivatives(self, entry: Entry, spec: StudySpec) -> None:
        """Raise FileError where the names that derivatives get are taken."""
        taken = {*RESERVED, *(column.name for column in spec.columns), *self.parameters}
        for column in spec.columns:
            for varied in spec.varied:
                name = slope_name(column, varied.name)
                if name in taken:
                    raise entry.error(
                        f"the derivatives of '{column.name}' by '{varied.name}' would be called"
                        f" '{name}', and there is one of that name",
                        "give the result another name",
                    )

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
        return read_count(entry["latin hypercube"]), 0 if seed is None else read_count(seed)

    def varied(self, name: str, entry: Entry, *, in_grid: bool) -> Varied:
        check_parameter(name, entry, self.robot)
        unit = self.robot.parameters[name].unit
        if isinstance(entry.node.value, list):
            if not in_grid:
                raise entry.error(
                    "a latin hypercube needs a range", "write '{from: 300 mm, to: 500 mm}'"
                )
            return Varied(
                name,
                tuple(read_parameter(name, one, self.parameters) for one in entry.elements()),
                unit,
            )
        low, high = (read_parameter(name, entry[end], self.parameters) for end in ("from", "to"))
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
        return Varied(name, tuple(np.linspace(low, high, read_count(count)).tolist()), unit)

    def frequency_postures(self, models: Sequence[Model]) -> int:
        entry = self.entry.get("frequencies")
        if entry is None:
            return 0
        if "refined" not in models:
            raise entry.error(
                "frequencies are those of the refined model", "add 'refined' to the models"
            )
        check_masses(entry, self.robot)
        return read_count(entry["postures"])

    def results(self) -> Iterator[tuple[str, Entry]]:
        entry = self.entry.get("results")
        return iter(()) if entry is None else entry.items()

    def column(self, name: str, entry: Entry, frequency_postures: int) -> Column:
        if name in self.parameters:
            raise entry.error(f"'{name}' is the name of a parameter", "choose another name")
        if name in RESERVED or name.endswith("_at"):
            raise entry.error(f"the table has a column '{name}' of its own", "choose another name")
        return read_statistic(name, entry, self.robot, frequency_postures)

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
