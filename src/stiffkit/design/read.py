"""Design files: YAML, read as study files are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from stiffkit.design.read_measures import MeasureReader
from stiffkit.design.read_variables import read_variable
from stiffkit.design.spec import (
    Constraint,
    DesignSpec,
    Evolution,
    Global,
    Gradient,
    Grid,
    Measure,
    Methods,
    Objective,
    Variable,
)
from stiffkit.files import Entry, Problems
from stiffkit.robot import Robot
from stiffkit.study.sweep.written import (
    check_masses,
    check_parameter,
    open_about_robot,
    read_count,
    read_models,
    read_parameter,
    values_of_parameters,
)

SCHEMA_FILE = Path(__file__).with_name("schema.json")
"""The published schema of design files."""

POSTURES = 200
"""Postures of each design if nothing is said."""

MOST_DESIGNS = 1_000_000
"""Of a grid."""

_STARTS, _POINTS = 8, 7
_POPULATION, _GENERATIONS = 40, 25
_STEPS = 5

RESERVED = ("design", "model", "violation", "feasible", "front", "origin")
"""Names in the dataset of designs that nothing else can have."""


def read_design(path: Path) -> DesignSpec:
    """Return the design study of a file.

    Raises FileError, with the place and how to mend it, where anything is wrong with it or with the
    robot file that it names.
    """
    entry, name, robot = open_about_robot(path, "design: TITLE", SCHEMA_FILE)
    return _Reader(entry, robot).read(name)


class _Reader:
    """Reads a design study of a robot whose file has been read."""

    def __init__(self, entry: Entry, robot: Robot) -> None:
        self.robot = robot
        self.parameters = values_of_parameters(robot)
        self.entry = entry
        self.taken: dict[str, str] = dict.fromkeys(RESERVED, "of the result")
        """Names, and whose they are."""

    def read(self, robot: str) -> DesignSpec:
        problems = Problems()
        variables: list[Variable] = []
        for name, entry in self.entry["vary"].items():
            with problems.collect():
                variables.append(read_variable(name, entry, self.robot, self.parameters))
                self.claim(variables[-1], entry)
        derived: list[tuple[str, str]] = []
        for name, entry in self._items("derived"):
            with problems.collect():
                derived.append((name, self.derived(name, entry)))
        frequency_postures = 0
        with problems.collect():
            frequency_postures = self.frequency_postures()
        measures = MeasureReader(self.robot, frequency_postures)
        objectives: list[Objective] = []
        for name, entry in self.entry["objectives"].items():
            with problems.collect():
                self.name(name, entry, "of an objective")
                objectives.append(measures.objective(name, entry))
        constraints: list[Constraint] = []
        for name, entry in self._items("constraints"):
            with problems.collect():
                found = measures.constraints(name, entry)
                for one in found:
                    self.name(one.measure.name, entry, "of a constraint")
                constraints.extend(found)
        methods = Methods()
        with problems.collect():
            methods = self.methods(variables, len(objectives))
        problems.check()
        if not any(one.measure.kind == "reached" for one in constraints):
            constraints.insert(0, self.all_reached())
        postures = self.entry.get("postures")
        return DesignSpec(
            title=self.entry["design"].text(),
            robot=robot,
            variables=tuple(variables),
            derived=tuple(derived),
            postures=POSTURES if postures is None else read_count(postures),
            models=read_models(self.entry.get("models"), ("refined",)),
            frequency_postures=frequency_postures,
            objectives=tuple(objectives),
            constraints=tuple(constraints),
            methods=methods,
        )

    def _items(self, key: str) -> Iterator[tuple[str, Entry]]:
        entry = self.entry.get(key)
        return iter(()) if entry is None else entry.items()

    def name(self, name: str, entry: Entry, whose: str) -> None:
        """Take a name of the dataset. Raises FileError where it is taken already."""
        if name in self.parameters:
            raise entry.error(f"'{name}' is the name of a parameter", "choose another name")
        if name in self.taken:
            raise entry.error(
                f"'{name}' is the name {self.taken[name]} already", "choose another name"
            )
        self.taken[name] = whose

    def claim(self, variable: Variable, entry: Entry) -> None:
        """Take the parameters of a variable. Raises FileError where another has one of them."""
        for parameter in variable.parameters:
            if parameter in self.taken:
                raise entry.error(
                    f"parameter '{parameter}' is varied by '{self.taken[parameter]}' already",
                    "let one of the two set it",
                )
            self.taken[parameter] = variable.name
        if variable.name not in self.parameters:
            self.name(variable.name, entry, "of a choice")

    def derived(self, name: str, entry: Entry) -> str:
        check_parameter(name, entry, self.robot)
        if name in self.taken:
            raise entry.error(
                f"parameter '{name}' is varied, and cannot follow from others",
                "remove it here or under 'vary'",
            )
        read_parameter(name, entry, self.parameters)
        return entry.text()

    def frequency_postures(self) -> int:
        entry = self.entry.get("frequencies")
        if entry is None:
            return 0
        check_masses(entry, self.robot)
        return read_count(entry["postures"])

    def all_reached(self) -> Constraint:
        """Return the constraint that holds if none says how much of the workspace is needed."""
        name = "reached"
        while name in self.taken or name in self.parameters:
            name = f"workspace_{name}"
        return Constraint(Measure(name, "reached"), above=True, bound=1.0)

    def methods(self, variables: list[Variable], n_objectives: int) -> Methods:
        entry = self.entry.get("method")
        continuous = [v for v in variables if v.kind == "continuous"]
        usual = Gradient(_STARTS, _POINTS if n_objectives > 1 else 0) if continuous else None
        evolved = Evolution(_POPULATION, _GENERATIONS)
        given = {} if entry is None else dict(entry.items())
        seed = read_count(given["seed"]) if "seed" in given else 0
        if not given.keys() - {"seed"}:
            alone = len(continuous) == len(variables) and n_objectives == 1
            return Methods(gradient=usual, evolution=None if alone else evolved, seed=seed)
        if "gradient" in given and not continuous:
            raise given["gradient"].error(
                "there is no gradient: no parameter is continuous",
                "give one as '{from: ..., to: ...}', or use 'grid', 'evolution' or 'global'",
            )
        numbers = {name: _Numbers(one) for name, one in given.items()}
        found = Methods(
            grid=Grid(numbers["grid"].get("steps", _STEPS)) if "grid" in given else None,
            gradient=Gradient(
                numbers["gradient"].get("starts", _STARTS),
                numbers["gradient"].get("points", _POINTS) if n_objectives > 1 else 0,
            )
            if "gradient" in given
            else None,
            evolution=Evolution(*numbers["evolution"].generations())
            if "evolution" in given
            else None,
            global_=Global(*numbers["global"].generations()) if "global" in given else None,
            seed=seed,
        )
        if found.grid is not None:
            self._check_grid(given["grid"], variables, found.grid.steps)
        return found

    def _check_grid(self, entry: Entry, variables: list[Variable], steps: int) -> None:
        count = 1
        for variable in variables:
            count *= variable.count or steps
        if count > MOST_DESIGNS:
            raise entry.error(
                f"these are {count} designs, more than {MOST_DESIGNS}",
                "give fewer 'steps', vary fewer parameters, or use another method",
            )


class _Numbers:
    """Whole numbers of a method."""

    def __init__(self, entry: Entry) -> None:
        self.entry = entry

    def get(self, key: str, default: int) -> int:
        given = self.entry.get(key)
        return default if given is None else read_count(given)

    def generations(self) -> tuple[int, int]:
        return self.get("population", _POPULATION), self.get("generations", _GENERATIONS)
