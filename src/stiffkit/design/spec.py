"""What a design study asks for, as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from stiffkit.stiffness import Model
from stiffkit.study.sweep import Column, StudySpec, Varied

Kind = Literal["continuous", "integer", "choice"]

MeasureKind = Literal["statistic", "reached", "mass", "size", "lowest", "highest", "stroke"]

_ANCHORS_FROM = 2000
"""Geometries of a latin hypercube among which those are chosen that all others begin from."""


@dataclass(frozen=True)
class Variable:
    """What is free in a design: a parameter of the robot file, or several that change together."""

    name: str
    kind: Kind
    parameters: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    """SI, for each parameter: both ends of a continuous range, or all values that it can have."""
    units: tuple[str, ...]
    """The units that the robot file has the parameters in."""
    options: tuple[str, ...] = ()
    """Names of what is chosen from, where they have names."""

    @property
    def count(self) -> int:
        """How many values there are; 0 where it is continuous."""
        return 0 if self.kind == "continuous" else len(self.values[0])


@dataclass(frozen=True)
class Measure:
    """A number of a design that is asked for, one for each model."""

    name: str
    kind: MeasureKind
    column: Column | None = None
    """The statistic over the workspace, of that kind."""
    joint: str = ""
    """A joint's coordinate such as "slide_1.y", of the kinds lowest, highest and stroke: over the
    workspace."""


@dataclass(frozen=True)
class Objective:
    """A measure that is to be as large or as small as can be."""

    measure: Measure
    maximise: bool


@dataclass(frozen=True)
class Constraint:
    """A measure with a bound."""

    measure: Measure
    above: bool
    """Whether the measure must be above the bound, else below it."""
    bound: float | None
    """SI; None for what the start has."""


@dataclass(frozen=True)
class Grid:
    """Every combination of values."""

    steps: int
    """Values of each continuous variable, both ends included; of others, all are taken."""


@dataclass(frozen=True)
class Gradient:
    """Constrained optimisation by gradients, from several starts."""

    starts: int
    points: int
    """Points of the front that are aimed at between the best of each objective."""


@dataclass(frozen=True)
class Evolution:
    """Evolution of a population towards the front."""

    population: int
    generations: int


@dataclass(frozen=True)
class Global:
    """Global search for the first objective."""

    population: int
    generations: int


@dataclass(frozen=True)
class Methods:
    """How designs are looked for, in this order; None for what is not used."""

    grid: Grid | None = None
    gradient: Gradient | None = None
    evolution: Evolution | None = None
    global_: Global | None = None
    seed: int = 0


@dataclass(frozen=True)
class DesignSpec:
    """A design study that has been read and checked."""

    title: str
    robot: str
    """Name of the catalogue, or absolute path."""
    variables: tuple[Variable, ...]
    derived: tuple[tuple[str, str], ...]
    """Parameters of the robot file that follow from others, and their expressions."""
    postures: int
    models: tuple[Model, ...]
    frequency_postures: int
    """0 if no frequencies are asked for."""
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    methods: Methods

    @property
    def goals(self) -> tuple[Objective | Constraint, ...]:
        """The objectives, then the constraints."""
        return (*self.objectives, *self.constraints)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """Those of the objectives, then those of the constraints."""
        return tuple(goal.measure for goal in self.goals)

    @property
    def parameters(self) -> tuple[Varied, ...]:
        """The parameters that differ from design to design, with the ends of their ranges."""
        return tuple(
            Varied(name, (min(values), max(values)), unit)
            for variable in self.variables
            for name, values, unit in zip(
                variable.parameters, variable.values, variable.units, strict=True
            )
        )

    @property
    def study(self) -> StudySpec:
        """The long study whose geometries are the designs."""
        return StudySpec(
            title=self.title,
            robot=self.robot,
            varied=self.parameters,
            sample=_ANCHORS_FROM,
            seed=0,
            postures=self.postures,
            models=self.models,
            frequency_postures=self.frequency_postures,
            columns=tuple(m.column for m in self.measures if m.column is not None),
        )

    def plain(self) -> dict[str, Any]:
        """Return the study as JSON can hold it."""
        return asdict(self)
