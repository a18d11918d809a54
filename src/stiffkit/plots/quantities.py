"""The quantities that a stiffness map holds, and the units in which a reader expects them."""

from __future__ import annotations

import xarray as xr

from stiffkit.errors import OutputError
from stiffkit.plots.units import Kind
from stiffkit.study import QUANTITIES, Quantity
from stiffkit.units import ANGLE, FREQUENCY, LENGTH, STIFFNESS_ROTATION, STIFFNESS_TRANSLATION

_KINDS = {
    LENGTH: Kind.DEFLECTION,
    ANGLE: Kind.ROTATION,
    STIFFNESS_TRANSLATION: Kind.STIFFNESS,
    STIFFNESS_ROTATION: Kind.ROTATIONAL_STIFFNESS,
    FREQUENCY: Kind.FREQUENCY,
}


def kind_of(quantity: Quantity) -> Kind:
    """Return what the numbers of a quantity are to a reader."""
    return _KINDS[quantity.dimension]


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
