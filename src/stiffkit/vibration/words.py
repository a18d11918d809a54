"""Modes in words: what the tool does, and where the strain energy is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stiffkit.spatial import Screw

Array = NDArray[np.float64]

_HARDLY = 0.02
"""Below this displacement of the tool, over the largest one, a mode hardly moves the tool."""

_MOVES, _TURNS = 0.3, 3.0
"""A tool whose turn, times the robot's length, is below the first share of its translation moves;
above the second it turns; between them it does both."""

_GOES_FAR = 0.5
"""A tool point whose displacement is above this share of the largest one is never said to turn
only."""

_ALONG_AXIS = 0.995
"""Cosine of the angle to an axis (6 degrees) below which a direction is called by its name."""

_TELLING = 0.1
"""Share of the strain energy that is worth telling."""


def describe_mode(
    twist: Array, point: Array, length: float, share: float, energy_shares: Mapping[str, float]
) -> str:
    """Return a mode in words.

    Args:
        twist: (6,), of the tool, SI, world axes, at the tool point.
        point: (3,), the tool point, m.
        length: m, typical of the robot.
        share: displacement of the tool point over the largest displacement in the mode.
        energy_shares: of links and joints, as in `stiffkit.vibration.Modes`.
    """
    words = f"tool {describe_tool(twist, point, length, share)}"
    energy = describe_energy(energy_shares)
    return f"{words}; {energy}" if energy else words


def describe_tool(twist: Array, point: Array, length: float, share: float) -> str:
    """Return what the tool does; arguments as in `describe_mode`."""
    translation = float(np.linalg.norm(twist[:3]))
    turn = length * float(np.linalg.norm(twist[3:]))
    if max(translation, turn) == 0.0:
        return "stands still"
    if share < _HARDLY and turn * share < _HARDLY * translation:
        return "hardly moves"
    if turn <= _MOVES * translation:
        return f"moves along {direction_words(twist[:3])}"
    if turn < _TURNS * translation or share > _GOES_FAR:
        return f"moves along {direction_words(twist[:3])}, turning about {_axis(twist)}"
    return f"turns about {_axis(twist)}{_through(twist, point, length)}"


def describe_energy(energy_shares: Mapping[str, float]) -> str:
    """Return the links and joints that store most of the strain energy, at most three."""
    # Equal shares, as of symmetric robots, differ by rounding: these go by their names.
    ranked = sorted(energy_shares.items(), key=lambda item: (-round(item[1], 4), item[0]))
    telling = [item for i, item in enumerate(ranked) if i == 0 or item[1] >= _TELLING][:3]
    if not telling:
        return ""
    (first, most), *others = telling
    words = [f"{first} stores {_percent(most)} of the strain energy"]
    return ", ".join([*words, *(f"{name} {_percent(share)}" for name, share in others)])


def direction_words(direction: Array) -> str:
    """Return a direction (3,) of any length as "z" or "(0.71, 0.71, 0)"; its sense is dropped."""
    unit = direction / np.linalg.norm(direction)
    for name, cosine in zip("xyz", np.abs(unit), strict=True):
        if cosine >= _ALONG_AXIS:
            return name
    rounded = np.round(unit, 2) + 0.0
    sense = -1.0 if rounded[np.flatnonzero(rounded)[0]] < 0.0 else 1.0
    return "(" + ", ".join(f"{x + 0.0:.3g}" for x in sense * rounded) + ")"


def _axis(twist: Array) -> str:
    return direction_words(twist[3:])


def _through(twist: Array, point: Array, length: float) -> str:
    """Return where the axis of a turn lies, if it is not at the tool point."""
    nearest = Screw.of_twist(twist, point, length).point
    if np.linalg.norm(nearest - point) < 0.01 * length:
        return ""
    where = ", ".join(f"{round(1e3 * x) + 0:d}" for x in nearest)
    return f" through ({where}) mm"


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"
