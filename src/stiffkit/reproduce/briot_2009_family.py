"""Briot 2009, sections 2.3 and 3.3: legs alpha times as long on the same stroke.

The family is the robot ``biglide-beams``: each leg is the beam of constant section that has the
first four diagonal elements of the machine's leg.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Literal

import numpy as np

from stiffkit.compiled import heyoka_available
from stiffkit.kinematics import Postures
from stiffkit.link.stretch import Stretch
from stiffkit.robot import Robot, load_robot
from stiffkit.spatial.rotation import Array
from stiffkit.stiffness import Model, deflection
from stiffkit.study import Analysis
from stiffkit.vibration import (
    Discretisation,
    ModalModel,
    Modes,
    platform_mass,
    simplified_frequencies,
)

MACHINE, FAMILY = "biglide", "biglide-beams"
"""Robots of the catalogue."""
LEGS = ("leg_1", "leg_2")
Reading = Literal["compliance", "stiffness"]
"""Which matrices' first four diagonal elements a leg and its equivalent beam have in common. The
paper says "stiffness matrices", and prints compliances."""
PLACES = ("centre", "left end", "right end")
"""Of the workspace: x = a - L2 + d/2, a - L2 and L1, the parts (a), (b) and (c) of the figures."""
LUMPED = Discretisation("lumped", n_elements=20, n_modes=8)
"""Of section 3.2: 20 rigid elements; 8 modes of each link are as good as all to 3e-4."""
MODELS: tuple[Model, ...] = ("simplified", "refined")


@dataclass(frozen=True, eq=False)
class Member:
    """One robot of the family, and what it gives at `PLACES`, which are the columns."""

    alpha: float
    analysis: Analysis
    postures: Postures

    @cached_property
    def twists(self) -> dict[Model, dict[str, Array]]:
        """(6, 3), m and rad, of the tool under each load of 1000 N."""
        return {model: twists_of(self.analysis, self.postures, model) for model in MODELS}

    @cached_property
    def deflections(self) -> dict[Model, dict[str, Array]]:
        """(3,), m, under each load, as `read_deflection` reads them."""
        return {
            model: {load: read_deflection(load, twist) for load, twist in loads.items()}
            for model, loads in self.twists.items()
        }

    @property
    def beside_z(self) -> Array:
        """(3,), deflection in the plane over that along z, under f_z in the refined model."""
        twist = self.twists["refined"]["f_z"]
        return np.asarray(np.hypot(twist[0], twist[1]) / np.abs(twist[2]))

    @cached_property
    def simplified(self) -> Array:
        """(3,), Hz, the first natural frequency of the simplified model."""
        k = self.analysis.simplified.at(self.postures).lower
        mass = platform_mass(self.analysis.robot)
        length = self.analysis.kinematics.length
        frequencies = simplified_frequencies(k, self.postures.tool, mass, length)
        return np.asarray(frequencies[0])

    @cached_property
    def _lowest(self) -> Array:
        """(3, 3): `along_z`, `in_plane` and `third` in rows."""
        kinematics = self.analysis.kinematics
        modal = ModalModel(kinematics.tree, kinematics.length, LUMPED)
        return np.transpose([_lowest(modal.at(q)) for q in self.postures.coordinates.T])

    @property
    def along_z(self) -> Array:
        """(3,), Hz, the lowest refined mode that moves the tool along z."""
        return np.asarray(self._lowest[0])

    @property
    def in_plane(self) -> Array:
        """(3,), Hz, the lowest refined mode that moves the tool in the plane."""
        return np.asarray(self._lowest[1])

    @property
    def third(self) -> Array:
        """(3,), Hz, the lowest refined mode but these two."""
        return np.asarray(self._lowest[2])

    def largest(self, model: Model) -> Array:
        """Return the largest deflection (3,), m, under any of the loads."""
        return np.asarray(np.max(list(self.deflections[model].values()), axis=0))

    def first(self, model: Model) -> Array:
        """Return the first natural frequency (3,), Hz."""
        if model == "simplified":
            return self.simplified
        return np.asarray(np.minimum(self.along_z, self.in_plane))


def read_deflection(load: str, twist: Array) -> Array:
    """Return the deflection (n,) that the figures show, m, from twists (6, n) under a load.

    In the plane under a force in it, along z under a force along z.
    """
    return np.abs(twist[2]) if load == "f_z" else np.asarray(np.hypot(twist[0], twist[1]))


def moves_along_z(modes: Modes) -> Array:
    """Tell which modes (n,) move the tool along z rather than in the plane."""
    return np.asarray(np.abs(modes.tool[2]) > np.linalg.norm(modes.tool[:2], axis=0))


def with_rigid_legs(robot: Robot) -> Robot:
    """Return a Biglide of which the feet and the drives alone yield."""
    links = {
        name: replace(link, compliance=None) if name in LEGS else link
        for name, link in robot.links.items()
    }
    return replace(robot, links=links)


def analyse(robot: Robot) -> Analysis:
    """Return a robot that is like many others: compiled once, computed often."""
    return Analysis(robot, backend="heyoka" if heyoka_available() else "numpy")


def at_places(analysis: Analysis) -> Postures:
    """Return the postures of a Biglide at the three places."""
    low, high = analysis.robot.workspace.ranges["x"]
    x = [(low + high) / 2.0, low, high]
    return analysis.kinematics.solve(np.array([x, [0.0, 0.0, 0.0]]))


def twists_of(analysis: Analysis, postures: Postures, model: Model) -> dict[str, Array]:
    """Return the twists (6, n) of the tool, m and rad, under each load of the robot."""
    lower = analysis.model(model).at(postures).lower
    return {name: deflection(lower, load.wrench) for name, load in analysis.robot.loads.items()}


def family_robot(alpha: float, reading: Reading = "compliance") -> Robot:
    """Return the robot whose legs are ``alpha`` times as long as the machine's."""
    robot = load_robot(FAMILY, {"alpha": alpha})
    if reading == "compliance":
        return robot
    machine = load_robot(MACHINE)
    links = dict(robot.links)
    for name in LEGS:
        given, reference = machine.links[name].compliance, machine.links[name].ports["tip"].position
        if given is not None:
            by = Stretch(alpha * reference, float(np.linalg.norm(reference)), "equivalent-beam")
            links[name] = replace(links[name], compliance=by.compliance(_beam_diagonal(given)))
    return replace(robot, links=links)


def _beam_diagonal(given: Array) -> Array:
    """Return a compliance (6, 6) with the k11 to k44 of a beam that has the stiffness of another.

    Clamped at both ends a beam is four times as stiff across as with one end free.
    """
    stiffness = np.diag(np.linalg.inv(given))
    return np.diag(np.array([1.0, 4.0, 4.0, 1.0, 1.0, 1.0]) / stiffness)


@cache
def study_member(alpha: float, reading: Reading = "compliance") -> Member:
    """Return the robot whose legs are ``alpha`` times as long as the machine's, put together."""
    analysis = analyse(family_robot(alpha, reading))
    return Member(alpha, analysis, at_places(analysis))


def _lowest(modes: Modes) -> tuple[float, float, float]:
    """Return the lowest frequency along z, that in the plane, and the lowest of the others, Hz."""
    is_along_z = moves_along_z(modes)
    z, plane = int(np.argmax(is_along_z)), int(np.argmin(is_along_z))
    frequencies = modes.frequencies_hz
    others = np.delete(frequencies, [z, plane])
    return float(frequencies[z]), float(frequencies[plane]), float(others[0])
