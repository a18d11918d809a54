"""The quantities of a stiffness map that can be drawn, with what a reader has to know of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import xarray as xr

from stiffkit.errors import OutputError
from stiffkit.plots.units import Kind


@dataclass(frozen=True)
class Quantity:
    """A variable of the map with one number for each posture."""

    name: str
    """Name of the variable in the dataset."""
    label: str
    kind: Kind
    per_load: bool
    """Whether it depends on the load case."""
    worst_is_largest: bool
    """True for deflections, False for stiffnesses."""
    scale: str
    """Variable whose size says what is rounding error in this one."""


def _deflection(name: str, label: str, kind: Kind, scale: str) -> Quantity:
    return Quantity(name, label, kind, per_load=True, worst_is_largest=True, scale=scale)


def _stiffness(name: str, label: str, kind: Kind) -> Quantity:
    return Quantity(name, label, kind, per_load=False, worst_is_largest=False, scale=name)


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        quantity.name: quantity
        for quantity in (
            _deflection(
                "deflection_translation",
                "Deflection",
                Kind.DEFLECTION,
                "deflection_translation",
            ),
            _deflection(
                "deflection_xy",
                "Deflection in the xy plane",
                Kind.DEFLECTION,
                "deflection_translation",
            ),
            _deflection(
                "deflection_z", "Deflection along z", Kind.DEFLECTION, "deflection_translation"
            ),
            _deflection(
                "deflection_rotation", "Angular deflection", Kind.ROTATION, "deflection_rotation"
            ),
            _stiffness(
                "stiffness_translation_min",
                "Stiffness, weakest direction",
                Kind.STIFFNESS,
            ),
            _stiffness(
                "stiffness_translation_max",
                "Stiffness, strongest direction",
                Kind.STIFFNESS,
            ),
            _stiffness(
                "stiffness_rotation_min",
                "Rotational stiffness, weakest axis",
                Kind.ROTATIONAL_STIFFNESS,
            ),
            _stiffness(
                "stiffness_rotation_max",
                "Rotational stiffness, strongest axis",
                Kind.ROTATIONAL_STIFFNESS,
            ),
            _stiffness("frequency_first", "Lowest natural frequency", Kind.FREQUENCY),
        )
    }
)
"""By name, in the order in which figures and reports list them."""


def quantity_named(dataset: xr.Dataset, name: str) -> Quantity:
    """Return the quantity ``name``.

    Raises:
        OutputError: if the dataset does not hold it, or it cannot be drawn.
    """
    present = [known for known in QUANTITIES if known in dataset]
    if name not in present:
        raise OutputError(
            f"the map has no quantity {name!r} to draw",
            mend=f"choose one of: {', '.join(present)}",
        )
    return QUANTITIES[name]


def quantities_of(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Return the quantities that the dataset holds."""
    return tuple(quantity for name, quantity in QUANTITIES.items() if name in dataset)


def main_quantities(dataset: xr.Dataset, *, planar: bool) -> tuple[Quantity, ...]:
    """Return the few quantities that say most about the robot, the most telling first.

    A planar robot is stiff in its plane and soft across it, so the two are kept apart; a spatial
    robot has one deflection.
    """
    deflections = ("deflection_xy", "deflection_z") if planar else ("deflection_translation",)
    stiffnesses = ("stiffness_translation_min", "stiffness_rotation_min")
    wanted = (*deflections, *stiffnesses, "frequency_first")
    return tuple(QUANTITIES[name] for name in wanted if name in dataset)
