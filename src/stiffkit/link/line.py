"""Links as elastic lines with mass: beams, and the equivalent beams of links given by matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffkit.errors import LinkError
from stiffkit.link.materials import Material
from stiffkit.link.outline import Outline
from stiffkit.link.sections import Section
from stiffkit.spatial.rotation import Array, skew


@dataclass(frozen=True, eq=False)
class Line:
    """A straight elastic line from the base port's origin to the tip's, in link axes."""

    tip: Array
    """(3,), m, tip from base."""
    flexibility: Array
    """(6, 6), twist per metre of line and unit of wrench; diagonal for a beam along x."""
    density_start: float
    """kg/m at the base; it runs linearly to `density_end` at the tip."""
    density_end: float
    rotary_inertia: Array
    """(3, 3), kg m^2 per metre, of the section about the line; constant."""
    rule: str
    """How the line was made, in words."""
    outline: Outline | None = None
    """What its section looks like, y and z of the link; None where nothing is known of it."""

    @property
    def length(self) -> float:
        """m."""
        return float(np.linalg.norm(self.tip))

    def compliance(self, length: float) -> Array:
        """Return the compliance (6, 6) of the end of a piece, ``length`` m, with its start held."""
        h, N, kappa = length, self.carry(), self.flexibility
        bent = N @ kappa
        return np.asarray(h * kappa + h**2 / 2 * (bent + bent.T) + h**3 / 3 * bent @ N.T)

    def carry(self) -> Array:
        """Return N (6, 6): the twist at a point ``a`` metres further is ``(I + a N) twist``."""
        N = np.zeros((6, 6))
        N[:3, 3:] = -skew(self.tip / self.length)
        return N

    def section_mass(self, s: float) -> Array:
        """Return the mass matrix per metre (6, 6) at ``s`` metres from the base."""
        share = s / self.length
        density = (1.0 - share) * self.density_start + share * self.density_end
        mass = np.zeros((6, 6))
        mass[:3, :3] = density * np.eye(3)
        mass[3:, 3:] = self.rotary_inertia
        return mass


def beam_line(length: float, section: Section, material: Material, mass: float) -> Line:
    """Return the line of a uniform beam along x, of a mass (kg) that may differ from its own.

    Timoshenko's beam with rotary inertia where the section has a shear coefficient; without one it
    is Euler and Bernoulli's, still with rotary inertia.
    """
    E, G = material.E, material.G
    shear = [
        0.0 if kappa is None else 1.0 / (kappa * G * section.area)
        for kappa in section.shear_coefficients(material.nu)
    ]
    bending = [1.0 / (E * section.Iy), 1.0 / (E * section.Iz)]
    flexibility = np.diag([1.0 / (E * section.area), *shear, 1.0 / (G * section.torsion), *bending])
    own = material.density * section.area * length
    rho = material.density * mass / own
    rotary = rho * np.diag([section.Iy + section.Iz, section.Iy, section.Iz])
    tip = np.array([length, 0.0, 0.0])
    even = mass / length
    return Line(tip, flexibility, even, even, rotary, "beam", section.outline)


def equivalent_line(
    compliance: Array, tip: Array, mass: float, center_of_mass: Array | None, inertia: Array | None
) -> Line:
    """Return the equivalent beam of a link given by its compliance (6, 6) at the tip, and its mass.

    A beam of constant section whose compliance has the given one's first four diagonal elements,
    along the line and across it (Briot et al. 2009, sections 2.3 and 3.3). Its mass density runs
    linearly so that the centre of mass lies where it is given along the line; the moment of inertia
    about the line is spread evenly. Raises LinkError if the tip lies at the base, or the centre of
    mass lies outside the middle third, where no such density is positive.
    """
    length = float(np.linalg.norm(tip))
    if length == 0.0:
        raise LinkError("a link whose tip lies at its base has no equivalent beam")
    axes = _axes_along(tip / length)
    turn = np.kron(np.eye(2), axes)
    k = turn.T @ compliance @ turn
    bend_y, bend_z = 3.0 * k[2, 2] / length**3, 3.0 * k[1, 1] / length**3
    section = np.diag([k[0, 0] / length, 0.0, 0.0, k[3, 3] / length, bend_y, bend_z])
    center = 0.5 if center_of_mass is None else float(center_of_mass @ tip) / length**2
    slope = 12.0 * (center - 0.5)
    if abs(slope) > 2.0:
        raise LinkError(
            f"the centre of mass lies at {center:.3g} of the way from base to tip, and no linear"
            " density puts it outside the middle third",
            mend="give the link as a superelement, or as two links",
        )
    even = mass / length
    about_line = 0.0 if inertia is None else float(axes[:, 0] @ inertia @ axes[:, 0])
    rotary = np.asarray(about_line / length * np.outer(axes[:, 0], axes[:, 0]), dtype=float)
    return Line(
        np.asarray(tip, dtype=float),
        turn @ section @ turn.T,
        even * (1.0 - slope / 2.0),
        even * (1.0 + slope / 2.0),
        rotary,
        "equivalent beam of constant section with k11, k22, k33 and k44 of the given compliance",
    )


def _axes_along(direction: Array) -> Array:
    """Return axes (3, 3) in columns, the first along a unit vector, the others as near as can be.

    For a line along x they are the link's own.
    """
    others = np.eye(3)
    y = others[:, 1] if abs(direction[1]) < 0.9 else others[:, 0]
    z = np.cross(direction, y)
    z /= np.linalg.norm(z)
    return np.stack([direction, np.cross(z, direction), z], axis=1)
