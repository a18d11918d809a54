"""The scalar quantities of a posture that maps show, and that studies and designs reduce.

Each is defined here once: what it is called, what it is read off and how, and which end is the bad
one. Whether the refined or the simplified model is meant is said where a quantity is asked for; its
compliance, or its natural frequencies, are what is read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.smallmat import vector
from stiffkit.stiffness import DEFLECTIONS, STIFFNESSES, Reading, deflection
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
    """One number of a posture, SI."""

    name: str
    """In datasets, and in files that ask for it."""
    source: Literal["deflection", "compliance", "frequencies"]
    """What it is read off: the deflection (6) under a load case, m and rad; the lower triangle
    of the compliance (21), SI; or the natural frequencies (k >= 1), Hz, ascending."""
    read: Reading
    """How: in a kernel, of scalars. `of` does it with arrays."""
    dimension: Dimension
    label: str
    """What figures and tables call it."""
    long_name: str
    """What it is in a sentence, after "largest" or "mean"."""
    scale: str
    """The quantity whose size says what is rounding error in this one."""

    @property
    def units(self) -> str:
        """The SI unit, as datasets have it."""
        return _UNITS[self.dimension]

    @property
    def per_load(self) -> bool:
        """Whether it is that of a load case."""
        return self.source == "deflection"

    @property
    def worst_is_largest(self) -> bool:
        """True for deflections; False for stiffnesses and frequencies, whose smallest is worst."""
        return self.source == "deflection"

    def of(self, values: Array) -> Array:
        """Return the quantity (...) of many postures, whose ``source`` is ``values`` (n, ...)."""
        with np.errstate(all="ignore"):
            return np.asarray(self.read(vector(values)))

    def of_compliance(self, lower: Array, wrench: Array | None = None) -> Array:
        """Return the quantity (...) of compliances given by their lower triangles (21, ...), SI.

        ``wrench`` (6,) is that of the load case, where it is the quantity of one.
        """
        return self.of(lower if wrench is None else deflection(lower, wrench))


_UNITS = {
    LENGTH: "m",
    ANGLE: "rad",
    STIFFNESS_TRANSLATION: "N/m",
    STIFFNESS_ROTATION: "N m/rad",
    FREQUENCY: "Hz",
}


def _deflection(
    name: str, dimension: Dimension, label: str, long_name: str, *, part_of: str = ""
) -> Quantity:
    read = DEFLECTIONS[name]
    return Quantity(name, "deflection", read, dimension, label, long_name, part_of or name)


def _stiffness(name: str, dimension: Dimension, label: str, long_name: str) -> Quantity:
    return Quantity(name, "compliance", STIFFNESSES[name], dimension, label, long_name, name)


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        quantity.name: quantity
        for quantity in (
            _deflection(
                "deflection_translation", LENGTH, "Deflection", "deflection of the tool point"
            ),
            _deflection(
                "deflection_xy",
                LENGTH,
                "Deflection in the xy plane",
                "deflection of the tool point in the x-y plane",
                part_of="deflection_translation",
            ),
            _deflection(
                "deflection_z",
                LENGTH,
                "Deflection along z",
                "deflection of the tool point along z",
                part_of="deflection_translation",
            ),
            _deflection("deflection_rotation", ANGLE, "Angular deflection", "rotation of the tool"),
            _stiffness(
                "stiffness_translation_min",
                STIFFNESS_TRANSLATION,
                "Stiffness, weakest direction",
                "translational stiffness, weakest direction",
            ),
            _stiffness(
                "stiffness_translation_max",
                STIFFNESS_TRANSLATION,
                "Stiffness, strongest direction",
                "translational stiffness, strongest direction",
            ),
            _stiffness(
                "stiffness_rotation_min",
                STIFFNESS_ROTATION,
                "Rotational stiffness, weakest axis",
                "rotational stiffness, weakest direction",
            ),
            _stiffness(
                "stiffness_rotation_max",
                STIFFNESS_ROTATION,
                "Rotational stiffness, strongest axis",
                "rotational stiffness, strongest direction",
            ),
            Quantity(
                "frequency_first",
                "frequencies",
                lambda frequencies: frequencies[0],
                FREQUENCY,
                "Lowest natural frequency",
                "lowest natural frequency",
                scale="frequency_first",
            ),
        )
    }
)
"""By name, in the order in which figures and reports list them."""
