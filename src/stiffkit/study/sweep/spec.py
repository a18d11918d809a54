"""What a study asks for, as plain data that can be written down and sent to other machines."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

from stiffkit.stiffness import Model

StatisticName = Literal["min", "max", "mean", "percentile", "share above", "share below"]

STATISTICS: tuple[StatisticName, ...] = (
    "min",
    "max",
    "mean",
    "percentile",
    "share above",
    "share below",
)


@dataclass(frozen=True)
class Varied:
    """A parameter that differs from geometry to geometry."""

    name: str
    values: tuple[float, ...]
    """SI: all values in a grid, both ends of the range in a random sample."""
    unit: str
    """The unit that the robot file has it in."""


@dataclass(frozen=True)
class Column:
    """A column of the table: a statistic of a quantity over the workspace of a geometry."""

    name: str
    statistic: StatisticName
    quantity: str
    """Of `stiffkit.study.quantities.QUANTITIES`."""
    load: str | None = None
    value: float | None = None
    """Per cent of a percentile; threshold of a share, SI."""

    @property
    def has_place(self) -> bool:
        """Whether the value stands at one posture, whose tool pose the table shows too."""
        return self.statistic in ("min", "max")

    @property
    def has_slope(self) -> bool:
        """Whether it changes little by little with the parameters; shares do it in leaps."""
        return not self.statistic.startswith("share")


def slope_name(column: Column, parameter: str) -> str:
    """Return the name of a column's derivatives by a parameter in the table."""
    return f"{column.name}_by_{parameter}"


@dataclass(frozen=True)
class StudySpec:
    """A study that has been read and checked."""

    title: str
    robot: str
    """Name of the catalogue, or absolute path."""
    varied: tuple[Varied, ...]
    sample: int | None
    """Number of geometries of a latin hypercube; None for the grid of all combinations."""
    seed: int
    postures: int
    models: tuple[Model, ...]
    frequency_postures: int
    """0 if no frequencies are asked for."""
    columns: tuple[Column, ...]
    derivatives: bool = False
    """Whether the table has the columns' derivatives by the varied parameters too."""

    @property
    def n_geometries(self) -> int:
        """Number of rows of the table."""
        if self.sample is not None:
            return self.sample
        count = 1
        for varied in self.varied:
            count *= len(varied.values)
        return count

    def plain(self) -> dict[str, Any]:
        """Return the study as JSON can hold it."""
        return asdict(self)

    @staticmethod
    def from_plain(plain: dict[str, Any]) -> StudySpec:
        """Return the study that `plain` was made from."""
        given = {field.name: plain[field.name] for field in fields(StudySpec)}
        varied = tuple(
            Varied(one["name"], tuple(one["values"]), one["unit"]) for one in given.pop("varied")
        )
        columns = tuple(Column(**one) for one in given.pop("columns"))
        models = tuple(given.pop("models"))
        return StudySpec(varied=varied, columns=columns, models=models, **given)
