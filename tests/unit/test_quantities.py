"""Quantities read off arrays are those that maps hold, of whichever source."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from stiffkit.plots.quantities import kind_of
from stiffkit.plots.units import Kind
from stiffkit.robot import load_robot
from stiffkit.stiffness import lower_triangles
from stiffkit.study import QUANTITIES, Quantity, map_workspace

every_quantity = pytest.mark.parametrize("quantity", QUANTITIES.values(), ids=lambda q: q.name)


@cache
def biglide() -> Any:
    return map_workspace(load_robot("biglide"), points=6).sel(model="refined")


@every_quantity
def test_what_is_read_off_its_source_is_what_a_map_holds(quantity: Quantity) -> None:
    dataset = biglide()
    held = dataset[quantity.name]
    match quantity.source:
        case "deflection":
            source = dataset["deflection"].transpose("direction", ...).values
        case "compliance":
            source = lower_triangles(dataset["compliance"].values)
        case "frequencies":
            source = dataset["frequency"].transpose("mode", ...).values
    np.testing.assert_allclose(quantity.of(source), held.values, rtol=1e-12)
    assert quantity.per_load == ("load" in held.dims)
    assert (held.attrs["units"], held.attrs["long_name"]) == (quantity.units, quantity.long_name)


@every_quantity
def test_a_softer_robot_is_worse(quantity: Quantity) -> None:
    """Twice the compliance: deflections grow, stiffnesses and frequencies fall."""
    rigid = np.linspace(1.0, 2.0, 6)
    lower = lower_triangles(np.diag(rigid)[..., None])
    sources = {
        "deflection": (rigid[:, None], 2.0 * rigid[:, None]),
        "compliance": (lower, 2.0 * lower),
        "frequencies": (rigid[:, None], rigid[:, None] / np.sqrt(2.0)),
    }
    firm, soft = sources[quantity.source]
    assert (quantity.of(soft) > quantity.of(firm)).all() == quantity.worst_is_largest


@every_quantity
def test_rounding_is_judged_by_a_quantity_of_the_same_unit(quantity: Quantity) -> None:
    assert QUANTITIES[quantity.scale].units == quantity.units


def test_every_quantity_has_units_for_the_reader() -> None:
    others = {Kind.POSITION, Kind.ANGLE, Kind.RATIO}
    assert {kind_of(quantity) for quantity in QUANTITIES.values()} == set(Kind) - others
