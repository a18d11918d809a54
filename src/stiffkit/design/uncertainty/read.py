"""Files about uncertainty: YAML, read as study files are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from stiffkit.design.uncertainty.links import covariance_of
from stiffkit.design.uncertainty.spec import (
    Asked,
    Distribution,
    UncertainLink,
    UncertainParameter,
    UncertaintySpec,
)
from stiffkit.errors import LinkError
from stiffkit.files import Entry, Problems, suggest
from stiffkit.files.shares import read_share
from stiffkit.robot import DIRECTIONS, Robot
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.written import (
    check_parameter,
    open_about_robot,
    read_count,
    read_models,
    read_parameter,
    values_of_parameters,
)

SCHEMA_FILE = Path(__file__).with_name("schema.json")
"""The published schema of files about uncertainty."""

POSTURES = 500
"""Postures of the workspace if nothing is said."""
CONFIDENCE = 0.95
SAMPLES = 1000
SAMPLED_POSTURES = 9
"""Few: a robot that is drawn is solved anew at each."""

IDENTIFIED = "identified"

_RESERVED = ("model", "source", "part", "point", "status", "sampled_posture", *DIRECTIONS)
_ENDINGS = ("sigma", "low", "high", "cause", "share", "share_at_worst", "gain_per_kg")
"""Names in the dataset that quantities cannot have, and endings that theirs get."""

_PER_CENT = re.compile(r"[^%]*%\s*")


def read_uncertainty(path: Path) -> UncertaintySpec:
    """Return the study of uncertainty of a file.

    Raises FileError, with the place and how to mend it, where anything is wrong with it or with the
    robot file that it names.
    """
    entry, name, robot = open_about_robot(path, "uncertainty: TITLE", SCHEMA_FILE)
    return _Reader(entry, robot).read(name)


class _Reader:
    """Reads a study of uncertainty of a robot whose file has been read."""

    def __init__(self, entry: Entry, robot: Robot) -> None:
        self.robot = robot
        self.values = values_of_parameters(robot)
        self.entry = entry

    def read(self, robot: str) -> UncertaintySpec:
        problems = Problems()
        parameters: list[UncertainParameter] = []
        for name, entry in self._items("parameters"):
            with problems.collect():
                parameters.append(self.parameter(name, entry))
        links: list[UncertainLink] = []
        for name, entry in self._items("links"):
            with problems.collect():
                links.append(self.link(name, entry))
        asked: list[Asked] = []
        for name, entry in self._items("quantities"):
            with problems.collect():
                asked.append(self.asked(name, entry))
        confidence = self.entry.get("confidence")
        share = CONFIDENCE
        with problems.collect():
            if confidence is not None:
                share = read_share(confidence, 1.0, CONFIDENCE)
        problems.check()
        if "links" not in self.entry:
            links = list(self.identified_links())
        if not parameters and not links:
            raise self.entry.error(
                "nothing here is uncertain", "give 'parameters' or 'links' with their errors"
            )
        return UncertaintySpec(
            title=self.entry["uncertainty"].text(),
            robot=robot,
            parameters=tuple(parameters),
            links=tuple(links),
            asked=tuple(asked) or tuple(self.usual_quantities()),
            models=read_models(self.entry.get("models"), ("refined",)),
            postures=self._count("postures", POSTURES),
            confidence=share,
            samples=self._count("samples", SAMPLES),
            sampled_postures=self._count("sampled postures", SAMPLED_POSTURES),
            seed=self._count("seed", 0),
        )

    def _items(self, key: str) -> Iterator[tuple[str, Entry]]:
        entry = self.entry.get(key)
        return iter(()) if entry is None else entry.items()

    def _count(self, key: str, default: int) -> int:
        entry = self.entry.get(key)
        return default if entry is None else read_count(entry)

    def parameter(self, name: str, entry: Entry) -> UncertainParameter:
        check_parameter(name, entry, self.robot)
        given = [key for key in ("sigma", "tolerance") if key in entry]
        if len(given) != 1:
            raise entry.error(
                f"{' and '.join(given) or 'no error'} stands here, one is needed",
                "write '{sigma: 2 %}' for a standard deviation, or '{tolerance: 0.1 mm}' for"
                " evenly distributed values that far to both sides",
            )
        parameter = self.robot.parameters[name]
        distribution: Distribution = "normal" if given == ["sigma"] else "uniform"
        size = self.size(name, entry[given[0]], parameter.value)
        sigma = size if distribution == "normal" else size / float(np.sqrt(3.0))
        return UncertainParameter(name, parameter.value, sigma, distribution, parameter.unit)

    def size(self, name: str, entry: Entry, value: float) -> float:
        """Return an error, SI, of a parameter with a value."""
        if _PER_CENT.fullmatch(entry.text()):
            if value == 0.0:
                raise entry.error(
                    f"the parameter '{name}' is 0, and so is every share of it",
                    "give the error with a unit",
                )
            return read_share(entry, 1.0, 0.02) * abs(value)
        size = read_parameter(name, entry, self.values)
        if not size > 0.0:
            raise entry.error(
                f"'{entry.text()}' is too small: an error must be above zero",
                "leave the parameter out if it is known exactly",
            )
        return size

    def link(self, name: str, entry: Entry) -> UncertainLink:
        links = self.robot.links
        if name not in links:
            raise entry.error(f"{self.robot.name} has no link '{name}'", suggest(name, links))
        relative = None
        if not entry.is_text(IDENTIFIED):
            sigma = entry.get("sigma")
            if sigma is None:
                raise entry.error(
                    f"'{entry.text()}' is no error of a link",
                    f"write '{{sigma: 2 %}}', or '{IDENTIFIED}' for the covariance that it was"
                    " identified with",
                )
            relative = read_share(sigma, 1.0, 0.02)
        uncertain = UncertainLink(name, relative)
        try:
            covariance_of(links[name], uncertain)
        except LinkError as error:
            raise entry.blame(error) from None
        return uncertain

    def identified_links(self) -> Iterator[UncertainLink]:
        """Yield the links that have a covariance, whatever it is good for."""
        for name, link in self.robot.links.items():
            if link.covariance is not None:
                uncertain = UncertainLink(name, None)
                try:
                    covariance_of(link, uncertain)
                except LinkError as error:
                    raise self.entry.blame(error) from None
                yield uncertain

    def asked(self, name: str, entry: Entry) -> Asked:
        self.check_name(name, entry)
        quantity, place = entry.text(), entry
        load: Entry | None = None
        if isinstance(entry.node.value, dict):
            quantity, place = next(entry.items())
            load = place
        if quantity not in QUANTITIES:
            raise place.error(f"'{quantity}' is no quantity", suggest(quantity, QUANTITIES))
        known = QUANTITIES[quantity]
        if known.source == "frequencies":
            raise place.error(
                "natural frequencies have no error bars",
                "ask for stiffnesses, or for deflections under a load",
            )
        if not known.per_load:
            if load is not None:
                raise place.error(f"{quantity} is the same for all loads", f"write '{quantity}'")
            return Asked(name, quantity, None)
        return Asked(name, quantity, self.load(quantity, entry if load is None else load, load))

    def load(self, quantity: str, place: Entry, given: Entry | None) -> str:
        loads = list(self.robot.loads)
        if given is not None:
            if given.text() in loads:
                return given.text()
            raise given.error(
                f"{self.robot.name} has no load case '{given.text()}'",
                suggest(given.text(), loads) or "its file has no loads; add some",
            )
        if len(loads) == 1:
            return loads[0]
        raise place.error(
            f"under which load? {quantity} is that of a load case",
            f"write '{{{quantity}: LOAD}}'; known: {', '.join(loads)}"
            if loads
            else "the robot file has no loads; add some",
        )

    def check_name(self, name: str, entry: Entry) -> None:
        """Raise FileError where the dataset has a name already."""
        taken = name in _RESERVED or name.startswith(("part_", "sampled_")) or "_sampled_" in name
        if taken or name.endswith(tuple(f"_{ending}" for ending in _ENDINGS)):
            raise entry.error(
                f"the dataset may have a variable '{name}' of its own", "choose another name"
            )

    def usual_quantities(self) -> Iterator[Asked]:
        """Yield what is asked for if the file does not say."""
        yield Asked("weakest", "stiffness_translation_min", None)
        for load in self.robot.loads:
            slug = re.sub(r"\W+", "_", load)
            yield Asked(f"deflection_{slug}", "deflection_translation", load)
