"""The scalar quantities of a posture that maps show and studies reduce."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.stiffness import rotational_stiffness, translational_stiffness
from stiffkit.units import (
    ANGLE,
    FREQUENCY,
    LENGTH,
    STIFFNESS_ROTATION,
    STIFFNESS_TRANSLATION,
    Dimension,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """What a number means."""

    units: str
    long_name: str
    dimension: Dimension


QUANTITIES = {
    "deflection_translation": Quantity("m", "deflection of the tool point", LENGTH),
    "deflection_xy": Quantity("m", "deflection of the tool point in the x-y plane", LENGTH),
    "deflection_z": Quantity("m", "deflection of the tool point along z", LENGTH),
    "deflection_rotation": Quantity("rad", "rotation of the tool", ANGLE),
    "stiffness_translation_min": Quantity(
        "N/m", "translational stiffness, weakest direction", STIFFNESS_TRANSLATION
    ),
    "stiffness_translation_max": Quantity(
        "N/m", "translational stiffness, strongest direction", STIFFNESS_TRANSLATION
    ),
    "stiffness_rotation_min": Quantity(
        "N m/rad", "rotational stiffness, weakest direction", STIFFNESS_ROTATION
    ),
    "stiffness_rotation_max": Quantity(
        "N m/rad", "rotational stiffness, strongest direction", STIFFNESS_ROTATION
    ),
    "frequency_first": Quantity("Hz", "lowest natural frequency", FREQUENCY),
}
"""By the names that they have in datasets. The frequency is known at few postures only."""


def needs_load(name: str) -> bool:
    """Tell whether a quantity is that of a load case."""
    return name.startswith("deflection")


_OF_DEFLECTION: dict[str, Callable[[Array], Array]] = {
    "deflection_translation": lambda d: np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]),
    "deflection_xy": lambda d: np.sqrt(d[0] * d[0] + d[1] * d[1]),
    "deflection_z": lambda d: np.abs(d[2]),
    "deflection_rotation": lambda d: np.sqrt(d[3] * d[3] + d[4] * d[4] + d[5] * d[5]),
}

_OF_COMPLIANCE: dict[str, Callable[[Array], Array]] = {
    "stiffness_translation_min": lambda lower: translational_stiffness(lower).weakest,
    "stiffness_translation_max": lambda lower: translational_stiffness(lower).strongest,
    "stiffness_rotation_min": lambda lower: rotational_stiffness(lower).weakest,
    "stiffness_rotation_max": lambda lower: rotational_stiffness(lower).strongest,
}


def of_deflection(name: str, deflection: Array) -> Array:
    """Return a quantity (...) of deflections (6, ...), m and rad."""
    return _OF_DEFLECTION[name](deflection)


def of_compliance(name: str, lower: Array) -> Array:
    """Return a quantity (...) of compliances, given by their lower triangles (21, ...), SI."""
    return _OF_COMPLIANCE[name](lower)
