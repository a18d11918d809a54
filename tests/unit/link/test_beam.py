import math

import numpy as np
import pytest

from stiffkit.errors import LinkError
from stiffkit.link import (
    Material,
    Section,
    beam_compliance,
    beam_inertia,
    box,
    rectangle,
    round_bar,
)

STEEL = Material("steel", E=200e9, nu=0.25, density=8000.0)
SLENDER = Section(area=2e-4, Iy=3e-9, Iz=5e-9, torsion=4e-9)


def test_slender_beam_closed_form() -> None:
    L, E, G = 0.5, 200e9, 80e9
    A, Iy, Iz, J = 2e-4, 3e-9, 5e-9, 4e-9
    expected = np.diag(
        [
            L / (E * A),
            L**3 / (3 * E * Iz),
            L**3 / (3 * E * Iy),
            L / (G * J),
            L / (E * Iy),
            L / (E * Iz),
        ]
    )
    expected[1, 5] = expected[5, 1] = L**2 / (2 * E * Iz)
    expected[2, 4] = expected[4, 2] = -(L**2) / (2 * E * Iy)
    np.testing.assert_allclose(beam_compliance(L, SLENDER, STEEL), expected, rtol=1e-14)


def test_a_force_bends_the_tip_its_own_way() -> None:
    k = beam_compliance(0.5, SLENDER, STEEL)
    up = k @ [0, 0, 100, 0, 0, 0]
    # The tip of a beam along x that is pushed up tilts its x axis up: a turn about -y.
    assert up[2] > 0
    assert up[4] < 0
    sideways = k @ [0, 100, 0, 0, 0, 0]
    assert sideways[1] > 0
    assert sideways[5] > 0


def test_shear_adds_to_the_two_deflections_only() -> None:
    sheared = Section(area=2e-4, Iy=3e-9, Iz=5e-9, torsion=4e-9, shear_y=0.5, shear_z=0.8)
    added = beam_compliance(0.5, sheared, STEEL) - beam_compliance(0.5, SLENDER, STEEL)
    expected = np.zeros((6, 6))
    expected[1, 1] = 0.5 / (0.5 * 80e9 * 2e-4)
    expected[2, 2] = 0.5 / (0.8 * 80e9 * 2e-4)
    np.testing.assert_allclose(added, expected, rtol=1e-9, atol=1e-20)


def test_poissons_ratio_reaches_the_shear_coefficient() -> None:
    k = beam_compliance(0.1, rectangle(0.01, 0.1), STEEL)
    kappa = 10 * 1.25 / (12 + 11 * 0.25)
    expected = 0.1**3 / (3 * 200e9 * 0.01 * 0.1**3 / 12) + 0.1 / (kappa * 80e9 * 0.001)
    assert k[2, 2] == pytest.approx(expected)


def test_beam_inertia_of_a_cuboid() -> None:
    mass, center, inertia = beam_inertia(0.5, rectangle(0.02, 0.04), STEEL)
    assert mass == pytest.approx(8000 * 0.5 * 0.02 * 0.04)
    np.testing.assert_allclose(center, [0.25, 0, 0])
    a, b, c = 0.5**2, 0.02**2, 0.04**2
    np.testing.assert_allclose(inertia, mass / 12 * np.diag([b + c, a + c, a + b]), rtol=1e-14)


def test_beam_inertia_of_a_cylinder() -> None:
    mass, _, inertia = beam_inertia(0.3, round_bar(0.1), STEEL)
    assert inertia[0, 0] == pytest.approx(mass * 0.05**2 / 2)
    assert inertia[1, 1] == inertia[2, 2] == pytest.approx(mass * (3 * 0.05**2 + 0.3**2) / 12)


@pytest.mark.parametrize("length", [0.0, -0.1, math.nan, math.inf])
def test_length_must_be_positive(length: float) -> None:
    for function in (beam_compliance, beam_inertia):
        with pytest.raises(LinkError, match=f"beam: the length is {length:g} m"):
            function(length, box(0.1, 0.1, 0.01), STEEL)
