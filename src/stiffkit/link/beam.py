"""Straight beams of constant section (S. Timoshenko, Strength of Materials, part I)."""

from __future__ import annotations

import math

import numpy as np

from stiffkit.errors import LinkError
from stiffkit.link.materials import Material
from stiffkit.link.sections import Section
from stiffkit.spatial.rotation import Array


def beam_compliance(length: float, section: Section, material: Material) -> Array:
    """Return the compliance (6x6, SI) of the tip of a beam with its base clamped.

    Link frame: x from base to tip, y and z the axes of the section; twist = k wrench with the
    translation first. Timoshenko's beam where the section has a shear coefficient, the slender
    beam of Euler and Bernoulli where it has none. Raises `LinkError` if the length is not positive.
    """
    _check_length(length)
    bend_y = length / (material.E * section.Iy)
    bend_z = length / (material.E * section.Iz)
    shear_y, shear_z = (
        0.0 if kappa is None else length / (kappa * material.G * section.area)
        for kappa in section.shear_coefficients(material.nu)
    )
    k = np.diag(
        [
            length / (material.E * section.area),
            bend_z * length**2 / 3.0 + shear_y,
            bend_y * length**2 / 3.0 + shear_z,
            length / (material.G * section.torsion),
            bend_y,
            bend_z,
        ]
    )
    # A force along +y turns the tip about +z; a force along +z turns it about -y.
    k[1, 5] = k[5, 1] = bend_z * length / 2.0
    k[2, 4] = k[4, 2] = -bend_y * length / 2.0
    return k


def beam_inertia(length: float, section: Section, material: Material) -> tuple[float, Array, Array]:
    """Return mass (kg), centre of mass ((3,), m) and inertia (3x3, kg m^2) of a beam.

    The centre of mass is given in the link frame, the inertia about the centre of mass in the
    axes of the link frame. Raises `LinkError` if the length is not positive.
    """
    _check_length(length)
    line_density = material.density * section.area
    mass = line_density * length
    across_y = material.density * section.Iy * length
    across_z = material.density * section.Iz * length
    along = mass * length**2 / 12.0
    inertia = np.diag([across_y + across_z, along + across_y, along + across_z])
    return mass, np.array([length / 2.0, 0.0, 0.0]), inertia


def _check_length(length: float) -> None:
    if not (length > 0.0 and math.isfinite(length)):
        raise LinkError(f"beam: the length is {length:g} m and must be positive")
