import math
import pickle

import numpy as np
import pytest

from stiffkit.errors import LinkError
from stiffkit.link import CowperCoefficient, Section, box, rectangle, round_bar, tube


def test_round_bar() -> None:
    section = round_bar(0.02)
    assert section.area == pytest.approx(math.pi * 1e-4)
    assert section.Iy == section.Iz == pytest.approx(math.pi * 0.01**4 / 4)
    assert section.torsion == pytest.approx(math.pi * 0.01**4 / 2)


def test_tube_is_a_bar_less_a_bar() -> None:
    outer, inner, section = round_bar(0.05), round_bar(0.04), tube(0.05, 0.005)
    assert section.area == pytest.approx(outer.area - inner.area)
    assert section.Iy == pytest.approx(outer.Iy - inner.Iy)
    assert section.torsion == pytest.approx(outer.torsion - inner.torsion)


def test_rectangle_has_width_along_y_and_height_along_z() -> None:
    section = rectangle(width=0.01, height=0.03)
    assert section.area == pytest.approx(3e-4)
    assert section.Iy == pytest.approx(0.01 * 0.03**3 / 12)
    assert section.Iz == pytest.approx(0.03 * 0.01**3 / 12)


@pytest.mark.parametrize("ratio", [1.0, 1.1, 1.7, 3.0, 20.0])
def test_rectangle_torsion_equals_the_plain_series(ratio: float) -> None:
    n = np.arange(1, 20001, 2)
    series = np.sum(np.tanh(n * math.pi * ratio / 2) / n**5.0)
    expected = ratio / 3 * (1 - 192 / math.pi**5 / ratio * series)
    assert rectangle(1.0, ratio).torsion == pytest.approx(expected, rel=1e-14)
    assert rectangle(ratio, 1.0).torsion == rectangle(1.0, ratio).torsion


def test_long_rectangles_do_not_overflow() -> None:
    assert rectangle(1e-6, 1.0).torsion == pytest.approx(1e-18 / 3, rel=1e-5)


def test_box_is_a_rectangle_less_a_rectangle() -> None:
    outer, inner, section = rectangle(0.06, 0.1), rectangle(0.05, 0.09), box(0.06, 0.1, 0.005)
    assert section.area == pytest.approx(outer.area - inner.area)
    assert section.Iy == pytest.approx(outer.Iy - inner.Iy)
    assert section.Iz == pytest.approx(outer.Iz - inner.Iz)


def test_thin_box_torsion_tends_to_bredt() -> None:
    wall = 1e-5
    bredt = 4 * (0.06 * 0.1) ** 2 * wall / (2 * (0.06 + 0.1))
    assert box(0.06, 0.1, wall).torsion == pytest.approx(bredt, rel=1e-3)


@pytest.mark.parametrize(
    ("width", "height", "wall", "exact"),
    [
        # Finite-difference solutions of Prandtl's problem, refined until 0.1 % remains.
        (1.0, 1.0, 0.05, 0.0439),
        (1.0, 1.0, 0.1, 0.0771),
        (1.0, 1.0, 0.25, 0.1291),
        (2.0, 1.0, 0.1, 0.2164),
        (2.0, 1.0, 0.3, 0.4186),
    ],
)
def test_box_torsion_keeps_its_stated_limits(
    width: float, height: float, wall: float, exact: float
) -> None:
    limit = 0.022 if wall <= 0.05 else 0.04 if wall <= 0.1 else 0.065
    assert box(width, height, wall).torsion == pytest.approx(exact, rel=limit)


def _shear_flow_coefficient(flange: float, web: float) -> float:
    """Energy coefficient I^2 / (A t sum of Q^2 ds) of a thin box, Q the first moment from the top.

    Without Poisson's ratio Cowper's coefficient is the same; both are per unit of thickness.
    """
    s = np.linspace(0.0, 1.0, 20001)
    h, b = web / 2, flange / 2
    in_flange = h * b * s
    in_web = h * b + h**2 / 2 * (1 - (1 - s) ** 2)
    energy = 4 * (np.trapezoid(in_flange**2, b * s) + np.trapezoid(in_web**2, h * s))
    second_moment = 2 * web**3 / 12 + 2 * flange * h**2
    return float(second_moment**2 / (2 * (flange + web)) / energy)


@pytest.mark.parametrize(("width", "height"), [(1.0, 1.0), (1.0, 3.0), (2.5, 1.0)])
def test_box_shear_without_poisson_is_that_of_the_shear_flow(width: float, height: float) -> None:
    shear_y, shear_z = box(width, height, 1e-9).shear_coefficients(0.0)
    assert shear_z == pytest.approx(_shear_flow_coefficient(width, height), rel=1e-6)
    assert shear_y == pytest.approx(_shear_flow_coefficient(height, width), rel=1e-6)


def test_tube_shear_joins_bar_and_thin_ring() -> None:
    assert tube(1.0, 0.5 - 1e-9).shear_coefficients(0.3)[0] == pytest.approx(
        round_bar(1.0).shear_coefficients(0.3)[0]
    )
    assert tube(1.0, 1e-6).shear_coefficients(0.3)[0] == pytest.approx(2.6 / 4.9)


def test_a_given_section_keeps_its_numbers() -> None:
    section = Section(area=1e-4, Iy=1e-9, Iz=2e-9, torsion=3e-9, shear_z=0.8)
    assert section.shear_coefficients(0.3) == (None, 0.8)


def test_sections_travel_between_processes() -> None:
    section = tube(0.04, 0.004)
    assert pickle.loads(pickle.dumps(section)) == section  # noqa: S301


@pytest.mark.parametrize("value", [0.0, -0.02, math.nan, math.inf])
def test_sizes_must_be_positive(value: float) -> None:
    with pytest.raises(LinkError, match=f"round bar: the diameter is {value:g} and must be pos"):
        round_bar(value)
    with pytest.raises(LinkError, match="tube: the wall is"):
        tube(0.1, value)
    with pytest.raises(LinkError, match="rectangle: the height is"):
        rectangle(0.1, value)
    with pytest.raises(LinkError, match="box: the width is"):
        box(value, 0.1, 0.01)
    with pytest.raises(LinkError, match="section: the torsion is"):
        Section(1e-4, 1e-9, 1e-9, value)


def test_a_wall_that_does_not_fit() -> None:
    with pytest.raises(LinkError, match=r"tube: a wall of 20 mm does not fit.*20 mm"):
        tube(0.04, 0.02)
    with pytest.raises(LinkError, match=r"box: a wall of 30 mm does not fit.*25 mm"):
        box(0.1, 0.05, 0.03)


@pytest.mark.parametrize("kappa", [0.0, -0.5, 1.2])
def test_shear_coefficients_must_be_possible(kappa: float) -> None:
    with pytest.raises(LinkError, match="shear coefficient shear_y") as caught:
        Section(1e-4, 1e-9, 1e-9, 2e-9, shear_y=kappa)
    assert f"{kappa:g}" in caught.value.what


def test_cowper_coefficient_depends_on_poissons_ratio() -> None:
    assert CowperCoefficient(10, 12, 11).at(0.0) == pytest.approx(5 / 6)
    assert CowperCoefficient(10, 12, 11).at(0.5) == pytest.approx(15 / 17.5)
