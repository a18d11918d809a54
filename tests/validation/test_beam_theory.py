"""Beams against printed values.

Roark: W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 7th edition, 2002.
Timoshenko and Goodier: Theory of Elasticity, 3rd edition, 1970.
Cowper: The shear coefficient in Timoshenko's beam theory, J. Applied Mechanics 33 (1966) 335-340.
Pashkevich: A. Pashkevich, A. Klimchik, D. Chablat, P. Wenger, "Accuracy improvement for stiffness
modeling of parallel manipulators", 42nd CIRP Conference on Manufacturing Systems, 2009.
"""

import math

import numpy as np
import pytest

from stiffkit.link import Material, Section, beam_compliance, box, rectangle, round_bar, tube
from stiffkit.spatial import Frame, axis_rotation, shift_compliance

ALUMINIUM = Material("aluminium", E=70e9, nu=0.346, density=2700.0)
MM_PER_N, RAD_PER_N_MM = 1e-3, 1e3


def slender(section: Section) -> Section:
    """Return the section without its shear deformation."""
    return Section(section.area, section.Iy, section.Iz, section.torsion)


@pytest.mark.parametrize(
    ("ratio", "k1"),
    [
        (1.0, 0.1406),
        (1.2, 0.166),
        (1.5, 0.196),
        (2.0, 0.229),
        (2.5, 0.249),
        (3.0, 0.263),
        (4.0, 0.281),
        (5.0, 0.291),
        (10.0, 0.312),
    ],
)
def test_rectangle_torsion_table(ratio: float, k1: float) -> None:
    """Timoshenko and Goodier, section 109: torque = k1 G theta (2a)^3 (2b)."""
    digits = 4 if k1 == 0.1406 else 3
    assert round(rectangle(1.0, ratio).torsion / ratio, digits) == k1


@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0, 4.0])
def test_rectangle_torsion_formula(ratio: float) -> None:
    """Roark, table 10.1, case 4: K = a b^3 (16/3 - 3.36 b/a (1 - b^4 / 12 a^4)), half sides."""
    a, b = ratio / 2, 0.5
    K = a * b**3 * (16 / 3 - 3.36 * b / a * (1 - b**4 / (12 * a**4)))
    assert rectangle(1.0, ratio).torsion == pytest.approx(K, rel=5e-3)


def test_hollow_rectangle_torsion_formula() -> None:
    """Roark, table 10.1, case 16: K = 2 t t1 (a - t)^2 (b - t1)^2 / (a t + b t1 - t^2 - t1^2)."""
    a, b, t = 0.1, 0.06, 0.002
    K = 2 * t * t * (a - t) ** 2 * (b - t) ** 2 / (a * t + b * t - 2 * t**2)
    # The walls' own torsion is not in Roark's formula.
    own = 2 * (a - t + b - t) * t**3 / 3
    assert box(a, b, t).torsion - own == pytest.approx(K, rel=1e-12)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize(
    ("section", "numerator", "constant", "poisson"),
    [
        (round_bar(1.0), 6, 7, 6),
        (rectangle(1.0, 2.0), 10, 12, 11),
        (tube(1.0, 1e-7), 2, 4, 3),
        (box(1.0, 1.0, 1e-7), 20, 48, 39),
    ],
    ids=["round bar", "rectangle", "thin tube", "thin square tube"],
)
def test_shear_coefficients(
    section: Section, numerator: float, constant: float, poisson: float, nu: float
) -> None:
    """Cowper: kappa = numerator (1 + nu) / (constant + poisson nu)."""
    kappa = numerator * (1 + nu) / (constant + poisson * nu)
    for along in section.shear_coefficients(nu):
        assert along == pytest.approx(kappa)


def test_cantilever_with_end_load_and_end_moment() -> None:
    """Roark, table 8.1, cases 1a and 3a: y = W l^3 / 3EI, theta = W l^2 / 2EI; y = M l^2 / 2EI."""
    l, E, W, M = 1.0, 200e9, 1000.0, 50.0  # noqa: E741
    inertia = 0.02 * 0.04**3 / 12
    steel = Material("steel", E=E, nu=0.3, density=7850.0)
    k = beam_compliance(l, slender(rectangle(0.02, 0.04)), steel)
    assert (k @ [0, 0, W, 0, 0, 0])[2] == pytest.approx(W * l**3 / (3 * E * inertia))
    assert (k @ [0, 0, W, 0, 0, 0])[4] == pytest.approx(-W * l**2 / (2 * E * inertia))
    assert (k @ [0, 0, 0, 0, M, 0])[4] == pytest.approx(M * l / (E * inertia))
    assert (k @ [0, 0, 0, 0, M, 0])[2] == pytest.approx(-M * l**2 / (2 * E * inertia))


@pytest.mark.parametrize(("section", "F"), [(rectangle(0.02, 0.04), 6 / 5), (tube(0.04, 1e-7), 2)])
def test_deflection_by_shear(section: Section, F: float) -> None:
    """Roark, section 8.10: the end load of a cantilever adds F W l / A G, F = 6/5, 2."""
    # Roark's factors do not know Poisson's ratio.
    material = Material("without contraction", E=200e9, nu=0.0, density=7850.0)
    with_shear = beam_compliance(0.1, section, material)
    without = beam_compliance(0.1, slender(section), material)
    expected = F * 0.1 / (section.area * material.G)
    assert with_shear[2, 2] - without[2, 2] == pytest.approx(expected, rel=1e-5)


def test_parallelogram_axis_of_the_orthoglide() -> None:
    """Pashkevich, table 7, "parallelogram axis", single beam: 50 mm long, diameter 26 mm."""
    k = beam_compliance(0.05, slender(round_bar(0.026)), ALUMINIUM)
    printed = [1.34e-6, 2.65e-5, 2.65e-5, 4.29e-8, 3.18e-8, 3.18e-8]
    np.testing.assert_allclose(
        np.diag(k), np.array(printed) * np.repeat([MM_PER_N, RAD_PER_N_MM], 3), rtol=4e-3
    )


def test_foot_of_the_orthoglide() -> None:
    """Pashkevich, table 7, "foot", single beam: 150 mm, 16 x 26 mm, turned by 45 degrees.

    The paper takes the polar moment for torsion, which a rectangle does not have.
    """
    bar = rectangle(width=0.026, height=0.016)
    polar = Section(bar.area, bar.Iy, bar.Iz, bar.Iy + bar.Iz)
    k = beam_compliance(0.15, polar, ALUMINIUM)
    turned = shift_compliance(k, Frame(rotation=axis_rotation("z", math.radians(45))))
    printed = [3.45e-4, 3.45e-4, 18.1e-4, 2.10e-7, 2.10e-7, 0.91e-7]
    np.testing.assert_allclose(
        np.diag(turned), np.array(printed) * np.repeat([MM_PER_N, RAD_PER_N_MM], 3), rtol=6e-3
    )
