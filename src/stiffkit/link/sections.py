"""Cross-sections of straight beams.

The local frame of a section has x along the beam and the principal axes y and z in the section,
with the origin at the centroid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from stiffkit.errors import LinkError
from stiffkit.link.outline import Outline, equivalent_outline

ZETA_5 = 1.0369277551433699263
"""Riemann's zeta function at 5."""


@dataclass(frozen=True)
class CowperCoefficient:
    """A shear coefficient ``a (1 + nu) / (b + c nu)``, the form of all of Cowper's results.

    Source: G. R. Cowper, "The shear coefficient in Timoshenko's beam theory", Journal of Applied
    Mechanics 33 (1966), 335-340.
    """

    a: float
    b: float
    c: float

    def at(self, nu: float) -> float:
        """Return the coefficient for Poisson's ratio ``nu``."""
        return self.a * (1.0 + nu) / (self.b + self.c * nu)


@dataclass(frozen=True)
class Section:
    """The properties of a cross-section; `LinkError` if one of them is not positive.

    A shear coefficient kappa makes the shear stiffness ``kappa G A``. It is a number in (0, 1], a
    function of Poisson's ratio, or None for a beam that does not deform in shear.
    """

    area: float
    """m^2."""
    Iy: float
    """m^4, second moment of area about y: the integral of z^2."""
    Iz: float
    """m^4, second moment of area about z: the integral of y^2."""
    torsion: float
    """m^4, torsion constant of Saint-Venant; the polar moment only for round sections."""
    shear_y: CowperCoefficient | float | None = None
    """Shear coefficient of a force along y."""
    shear_z: CowperCoefficient | float | None = None
    """Shear coefficient of a force along z."""
    shape: Outline | None = None
    """What it looks like; None where only its properties are known."""

    def __post_init__(self) -> None:
        """Check the values."""
        _positive("section", area=self.area, Iy=self.Iy, Iz=self.Iz, torsion=self.torsion)
        _check_shear("shear_y", self.shear_y)
        _check_shear("shear_z", self.shear_z)

    @property
    def outline(self) -> Outline:
        """What it looks like, or what has its area and second moments and may stand for it."""
        return self.shape or equivalent_outline(self.area, self.Iy, self.Iz, self.torsion)

    def shear_coefficients(self, nu: float) -> tuple[float | None, float | None]:
        """Return the shear coefficients along y and z for Poisson's ratio ``nu``."""
        return _shear_at(self.shear_y, nu), _shear_at(self.shear_z, nu)


def round_bar(diameter: float) -> Section:
    """Return a solid circular section, diameter in m; `LinkError` if it is not positive."""
    _positive("round bar", diameter=diameter)
    second_moment = math.pi * diameter**4 / 64.0
    shear = CowperCoefficient(6.0, 7.0, 6.0)
    return Section(
        area=math.pi * diameter**2 / 4.0,
        Iy=second_moment,
        Iz=second_moment,
        torsion=2.0 * second_moment,
        shear_y=shear,
        shear_z=shear,
        shape=Outline("ellipse", diameter, diameter),
    )


def tube(outer_diameter: float, wall: float) -> Section:
    """Return a circular tube, sizes in m; `LinkError` if they are not positive or do not fit."""
    _positive("tube", outer_diameter=outer_diameter, wall=wall)
    _wall_fits("tube", "the outer diameter", outer_diameter, wall)
    inner_diameter = outer_diameter - 2.0 * wall
    second_moment = math.pi * (outer_diameter**4 - inner_diameter**4) / 64.0
    m2 = (inner_diameter / outer_diameter) ** 2
    q = (1.0 + m2) ** 2
    shear = CowperCoefficient(6.0 * q, 7.0 * q + 20.0 * m2, 6.0 * q + 12.0 * m2)
    return Section(
        area=math.pi * (outer_diameter**2 - inner_diameter**2) / 4.0,
        Iy=second_moment,
        Iz=second_moment,
        torsion=2.0 * second_moment,
        shear_y=shear,
        shear_z=shear,
        shape=Outline("ellipse", outer_diameter, outer_diameter, inner_diameter, inner_diameter),
    )


def rectangle(width: float, height: float) -> Section:
    """Return a solid rectangle, width along y and height along z in m.

    The torsion constant is exact to rounding. Raises `LinkError` if a size is not positive.
    """
    _positive("rectangle", width=width, height=height)
    shear = CowperCoefficient(10.0, 12.0, 11.0)
    return Section(
        area=width * height,
        Iy=width * height**3 / 12.0,
        Iz=height * width**3 / 12.0,
        torsion=_rectangle_torsion(width, height),
        shear_y=shear,
        shear_z=shear,
        shape=Outline("rectangle", width, height),
    )


def box(width: float, height: float, wall: float) -> Section:
    """Return a rectangular hollow section: outer width along y and height along z, and wall, in m.

    Area and second moments are exact for sharp corners. Torsion and shear are those of thin walls
    on the mid-line: torsion by Bredt with the walls' own part added (as EN 10210-2:2006, annex A,
    has it), shear by Cowper. Against numerical solutions of Prandtl's problem the torsion constant
    is 2 % too small for a wall of 1/20 of the smaller side, 4 % for 1/10, and within 6.5 % for any
    wall. The shear coefficient is meant for walls up to about 1/10; where the hole vanishes it is
    half of what it should be.
    Raises `LinkError` if a size is not positive or the wall does not fit.
    """
    _positive("box", width=width, height=height, wall=wall)
    _wall_fits("box", "its smaller side", min(width, height), wall)
    inner_width, inner_height = width - 2.0 * wall, height - 2.0 * wall
    mid_width, mid_height = width - wall, height - wall
    return Section(
        area=width * height - inner_width * inner_height,
        Iy=(width * height**3 - inner_width * inner_height**3) / 12.0,
        Iz=(height * width**3 - inner_height * inner_width**3) / 12.0,
        torsion=_box_torsion(mid_width, mid_height, wall),
        shear_y=_box_shear(flange=mid_height, web=mid_width),
        shear_z=_box_shear(flange=mid_width, web=mid_height),
        shape=Outline("rectangle", width, height, inner_width, inner_height),
    )


def _rectangle_torsion(width: float, height: float) -> float:
    """Return the torsion constant of a rectangle (Timoshenko and Goodier, section 109).

    The book's series is ``sum over odd n of tanh(n pi b / 2a) / n^5``. Here tanh is split into 1,
    whose sum is known, and ``tanh - 1``, whose sum has converged after a dozen terms.
    """
    a, b = min(width, height), max(width, height)
    decay = math.exp(-math.pi * b / a)
    rest = sum(2.0 * decay**n / (1.0 + decay**n) / n**5 for n in range(1, 24, 2))
    series = 31.0 / 32.0 * ZETA_5 - rest
    return a**3 * b / 3.0 * (1.0 - 192.0 / math.pi**5 * a / b * series)


def _box_torsion(mid_width: float, mid_height: float, wall: float) -> float:
    perimeter = 2.0 * (mid_width + mid_height)
    enclosed = mid_width * mid_height
    return 4.0 * enclosed**2 * wall / perimeter + perimeter * wall**3 / 3.0


def _box_shear(flange: float, web: float) -> CowperCoefficient:
    """Return the coefficient of a thin-walled box of one thickness for a force along its webs."""
    m = n = flange / web
    return CowperCoefficient(
        10.0 * (1.0 + 3.0 * m) ** 2,
        12.0 + 72.0 * m + 150.0 * m**2 + 90.0 * m**3 + 30.0 * n**2 * (m + m**2),
        11.0 + 66.0 * m + 135.0 * m**2 + 90.0 * m**3 + 10.0 * n**2 * m,
    )


def _shear_at(shear: CowperCoefficient | float | None, nu: float) -> float | None:
    return shear.at(nu) if isinstance(shear, CowperCoefficient) else shear


def _check_shear(name: str, shear: CowperCoefficient | float | None) -> None:
    if isinstance(shear, float | int) and not 0.0 < shear <= 1.0:
        raise LinkError(
            f"section: the shear coefficient {name} is {shear:g} and must be above 0, at most 1",
            mend="give kappa of the shear stiffness kappa G A (5/6 for a rectangle), not 1/kappa; "
            "leave it out for a beam without shear deformation",
        )


def _positive(shape: str, **sizes: float) -> None:
    for name, size in sizes.items():
        if not (size > 0.0 and math.isfinite(size)):
            raise LinkError(
                f"{shape}: the {name.replace('_', ' ')} is {size:g} and must be positive"
            )


def _wall_fits(shape: str, across: str, size: float, wall: float) -> None:
    if wall >= size / 2.0:
        raise LinkError(
            f"{shape}: a wall of {1e3 * wall:g} mm does not fit, it must be below half of "
            f"{across}, {1e3 * size / 2.0:g} mm",
            mend="make the wall thinner, or take a solid section",
        )
