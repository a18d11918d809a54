"""The parameters of a robot as sliders: where they stand, and how far they go."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stiffkit.errors import StiffkitError
from stiffkit.robot import Robot, RobotFile
from stiffkit.robot.dependence import Dependence
from stiffkit.units import LENGTH, Exponents, Value, parse_quantity

_STEPS = 200
"""Steps of a slider."""
_TURN = math.pi / 6.0
"""How far angles go to both sides, rad."""
_ANGLES = ("deg", "rad", "mrad")
"""Their units; a percentage has no dimension either, and is no angle."""
_SHARE = 0.25
"""How far a length that is zero goes to both sides, over the robot's typical length."""
_HALVINGS = 6


@dataclass(frozen=True)
class Slider:
    """A parameter that can be moved; SI."""

    name: str
    value: float
    """That of the robot file."""
    unit: str
    """The unit that the robot file has it in, "" for a bare number."""
    low: float
    """Lowest value of a slider."""
    high: float
    step: float
    follows: bool
    """Whether it follows from other parameters; given a value, it does so no more."""
    solves_parts: bool
    """Whether parts from CAD are solved anew for each value, which takes from seconds to minutes.
    """

    @property
    def live(self) -> bool:
        """Whether it is one to move with the hand: own, and quick."""
        return not (self.follows or self.solves_parts)


def sliders_of(file: RobotFile, robot: Robot, length: float) -> dict[str, Slider]:
    """Return the parameters of a robot of some typical ``length`` (m), by name.

    From half to double of their own values, or as far as the file allows.
    """
    known = file.dependence()
    return {
        name: _slider(file, name, parameter.value, parameter.unit, known, length)
        for name, parameter in robot.parameters.items()
    }


def _slider(
    file: RobotFile, name: str, value: float, unit: str, known: Dependence, length: float
) -> Slider:
    slow = name in known.solved
    low, high = known.ranges.get(name) or _ends(value, unit, length)
    if not slow:
        low, high = (_possible(file, name, unit, value, end) for end in (low, high))
    step = (high - low) / _STEPS
    return Slider(name, value, unit, low, high, step, name in known.following, slow)


def _ends(value: float, unit: str, length: float) -> tuple[float, float]:
    if unit in _ANGLES:
        return value - _TURN, value + _TURN
    if value:
        return min(0.5 * value, 2.0 * value), max(0.5 * value, 2.0 * value)
    away = _SHARE * length if dimension_of(unit) == LENGTH.dims else 1.0
    return -away, away


def _possible(file: RobotFile, name: str, unit: str, value: float, end: float) -> float:
    """Return how far towards one end the file makes sense."""

    def makes_sense(there: float) -> bool:
        try:
            file.robot({name: in_si(there, unit)})
        except StiffkitError:
            return False
        return True

    if makes_sense(end):
        return end
    good, bad = value, end
    for _ in range(_HALVINGS):
        middle = 0.5 * (good + bad)
        if makes_sense(middle):
            good = middle
        else:
            bad = middle
    return good


def in_si(value: float, unit: str) -> Value:
    """Return a value (SI) of a parameter that the file has in some unit."""
    return Value(value, dimension_of(unit))


def dimension_of(unit: str) -> Exponents | None:
    """Return the dimension of a unit; None for a bare number, which fits any."""
    return parse_quantity(f"1 {unit}").dims if unit else None
