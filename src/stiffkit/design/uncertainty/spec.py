"""What is uncertain about a robot, and what is asked of it, as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from statistics import NormalDist
from typing import Any, Literal

from stiffkit.stiffness import Model
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep import Column, StudySpec, Varied

Distribution = Literal["normal", "uniform"]

_SPREAD = 3.0
"""Standard deviations to each side within which a parameter is looked at."""


@dataclass(frozen=True)
class UncertainParameter:
    """A parameter of the robot file that is known with an error."""

    name: str
    value: float
    """SI."""
    sigma: float
    """Standard deviation, SI."""
    distribution: Distribution
    unit: str
    """The unit that the robot file has it in."""


@dataclass(frozen=True)
class UncertainLink:
    """A link whose compliance is known with an error."""

    name: str
    relative: float | None
    """Standard deviation of one factor for the whole compliance; None for the covariance of its
    elements that the link was identified with."""


@dataclass(frozen=True)
class Asked:
    """A quantity of each posture."""

    name: str
    """In the dataset."""
    quantity: str
    load: str | None

    @property
    def units(self) -> str:
        """The SI unit."""
        return QUANTITIES[self.quantity].units


@dataclass(frozen=True)
class UncertaintySpec:
    """A study of uncertainty that has been read and checked."""

    title: str
    robot: str
    """Name of the catalogue, or absolute path."""
    parameters: tuple[UncertainParameter, ...]
    links: tuple[UncertainLink, ...]
    asked: tuple[Asked, ...]
    models: tuple[Model, ...]
    postures: int
    confidence: float
    """Of the bands, 0 to 1."""
    samples: int
    """0 where the first order is not checked by sampling."""
    sampled_postures: int
    """About how many postures are sampled, spread over the workspace like the others."""
    seed: int
    """Of what is drawn at random."""

    @property
    def sources(self) -> tuple[str, ...]:
        """Names of what is uncertain, no two alike: parameters, then links."""
        parameters = [p.name for p in self.parameters]
        links = [f"link {u.name}" if u.name in parameters else u.name for u in self.links]
        return (*parameters, *links)

    @property
    def standard_deviations(self) -> float:
        """Half the width of the bands, in standard deviations of a normal distribution."""
        return NormalDist().inv_cdf(0.5 + 0.5 * self.confidence)

    def study(self, postures: int) -> StudySpec:
        """Return the long study that varies the uncertain parameters, over so many postures."""
        return StudySpec(
            title=self.title,
            robot=self.robot,
            varied=tuple(
                Varied(p.name, (p.value - _SPREAD * p.sigma, p.value + _SPREAD * p.sigma), p.unit)
                for p in self.parameters
            ),
            sample=1,
            seed=self.seed,
            postures=postures,
            models=self.models,
            frequency_postures=0,
            columns=tuple(Column(a.name, "mean", a.quantity, a.load) for a in self.asked),
        )

    def plain(self) -> dict[str, Any]:
        """Return the study as JSON can hold it."""
        return asdict(self)
