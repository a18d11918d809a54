"""Tables 7 and 8 beside ours, and the Orthoglide without its over-constraints."""

from __future__ import annotations

import numpy as np
import pytest

from stiffkit.reproduce import PrintedRow, Standing, study_over_constraint, without_over_constraints
from stiffkit.reproduce.pashkevich_2009_orthoglide import PLACES, table_rows
from stiffkit.robot import load_robot
from stiffkit.study import Analysis


def row(printed: str, ours: float | None, *, is_other: bool = False) -> PrintedRow:
    values = None if ours is None else (ours,)
    return PrintedRow("Table", "row", ("k",), (printed,), values, "", "", "", is_other)


@pytest.mark.parametrize(
    ("printed", "ours", "standing"),
    [
        ("1.34e-6", 1.3454e-6, Standing.FOLLOWS),  # cut off
        ("1.34e-6", 1.3351e-6, Standing.FOLLOWS),  # rounded
        ("1.34e-6", 1.3349e-6, Standing.DIFFERS),
        ("1.34e-6", 1.3501e-6, Standing.DIFFERS),
        ("1.34e-6", None, Standing.UNKNOWN),
    ],
)
def test_a_row_stands_by_its_printed_digits(
    printed: str, ours: float | None, standing: Standing
) -> None:
    assert row(printed, ours).standing is standing


def test_another_part_is_no_comparison() -> None:
    assert row("1.34e-6", 1.34e-6, is_other=True).standing is Standing.OTHER


def test_every_printed_row_stands_beside_ours() -> None:
    rows = table_rows(with_cad=False)
    assert [one.table for one in rows] == ["Table 7"] * 10 + ["Table 8"] * 7
    standing = {one.row: one.standing for one in rows}
    follows = {name for name, found in standing.items() if found is Standing.FOLLOWS}
    assert follows == {
        *(f"{part}, single beam" for part in ("foot", "axle", "bar")),
        "lump model with rigid axis, parabolic mesh",
    }
    differing = [one for one in rows if one.standing is Standing.DIFFERS]
    assert all(one.why and one.deviation is not None and one.deviation < 0.05 for one in differing)
    assert len(differing) == 2
    assert all(one.assumed for one in rows)


def test_without_over_constraints_the_count_is_the_mobility() -> None:
    robot = load_robot("orthoglide")
    free = Analysis(without_over_constraints(robot)).kinematics
    assert free.mobility.counted == free.mobility.numeric == 3
    assert free.mobility.idle == 0
    assert free.asked == ("x", "y", "z")


@pytest.mark.parametrize("name", ["orthoglide", "orthoglide-multi-beam", "orthoglide-table-7"])
def test_without_over_constraints_the_robot_is_softer(name: str) -> None:
    found = study_over_constraint(load_robot(name), PLACES)
    assert found.counted == (-9, 3)
    assert found.mobility == (3, 3)
    for posture in found.postures:
        # Fewer constraints, no smaller compliance, whatever the load.
        assert posture.least > 1.0 - 1e-9
    near, isotropic, far = found.postures
    # In the isotropic posture each bar pulls along its drive: only rotations get softer.
    np.testing.assert_allclose(isotropic.ratios[:3], 1.0, atol=1e-9)
    assert (isotropic.ratios[3:] > 1.03).all()
    for corner in (near, far):
        assert (corner.ratios[:3] > 1.02).all()
        assert (corner.ratios[3:] > 1.5).all()
