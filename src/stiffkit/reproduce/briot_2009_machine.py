"""Briot 2009, sections 2.1, 2.2, 3.1 and 3.2: the machine as it is, over its workspace."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import eigh

from stiffkit.link import equivalent_line
from stiffkit.link.superelement import (
    Superelement,
    consistent_superelement,
    lumped_superelement,
)
from stiffkit.reproduce.briot_2009_family import (
    LUMPED,
    MACHINE,
    MODELS,
    analyse,
    moves_along_z,
    read_deflection,
    twists_of,
)
from stiffkit.robot import Link, Robot, load_robot
from stiffkit.spatial.rotation import Array
from stiffkit.stiffness import Model
from stiffkit.vibration import ModalModel, platform_mass, simplified_frequencies

POSTURES, PLACES = 101, 13
"""Along x, for figures 3, 5 and 7, and for figure 10."""
MODES = 60
"""How many modes section 3.2 looks at."""
FINE = 60
"""Consistent elements that stand for the theory of a beam."""


@dataclass(frozen=True, eq=False)
class Machine:
    """The machine along x, from the left to the right end of its workspace."""

    x: Array
    """(n,), m."""
    deflections: Mapping[Model, Mapping[str, Array]]
    """(n,), m, under each load of 1000 N, as the figures read them."""
    simplified: Array
    """(n,), Hz, the first natural frequency of the simplified model."""
    places: Array
    """(p,), m, where the refined modes are."""
    refined: Array
    """(2, p), Hz, the lowest two."""
    along_z: Array
    """(2, p), whether they move the tool along z."""
    shares: tuple[Mapping[str, float], ...]
    """(p,), of the strain energy of the second mode in each part."""
    drive_share: float
    """The largest share of the strain energy that the drives have in the first `MODES` modes."""
    leg_1: Mapping[str, float]
    """Hz, lowest frequency of its equivalent beam, clamped: bending in the plane ("y") and along z
    ("z"), extension ("x") and torsion ("rx")."""
    lumped_error: float
    """Of the lowest two of these, cut into rigid elements, relative."""
    turned_leg_2: float
    """Change of the lowest two refined frequencies, relative, at the centre of the workspace, where
    the inertia of leg 2 is turned so that its long axis is that of the leg."""

    def inner(self, share: float) -> slice:
        """Return the postures in the middle ``share`` of the workspace."""
        cut = round(0.5 * (1.0 - share) * self.x.size)
        return slice(cut, self.x.size - cut)

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON, SI."""
        return {
            "x": self.x.tolist(),
            "deflection": {
                model: {load: values.tolist() for load, values in loads.items()}
                for model, loads in self.deflections.items()
            },
            "frequency_simplified": self.simplified.tolist(),
            "x_of_modes": self.places.tolist(),
            "frequency_refined": self.refined.tolist(),
            "energy_of_second_mode": [dict(shares) for shares in self.shares],
            "leg_1": dict(self.leg_1),
        }


def study_machine() -> Machine:
    """Return figures 3, 5, 7 and 10, and what the text says of single modes."""
    analysis = analyse(load_robot(MACHINE))
    kinematics, robot = analysis.kinematics, analysis.robot
    low, high = robot.workspace.ranges["x"]
    x = np.linspace(low, high, POSTURES)
    postures = kinematics.solve(np.stack([x, np.zeros_like(x)]))
    frequencies = simplified_frequencies(
        analysis.simplified.at(postures).lower,
        postures.tool,
        platform_mass(robot),
        kinematics.length,
    )
    places = np.round(np.linspace(0, POSTURES - 1, PLACES)).astype(int)
    modal = ModalModel(kinematics.tree, kinematics.length, LUMPED)
    at_places = list(modal.at_each(postures.coordinates[:, places], 2))
    centre = postures.coordinates[:, POSTURES // 2]
    turned = analyse(_with_turned_leg_2(robot)).kinematics
    other = ModalModel(turned.tree, turned.length, LUMPED).at(centre, 2).frequencies_hz
    lowest = modal.at(centre, MODES)
    beam, lumped = _leg_1(robot.links["leg_1"])
    bends = [min(beam["y"], beam["z"]), max(beam["y"], beam["z"])]
    also = [min(lumped["y"], lumped["z"]), max(lumped["y"], lumped["z"])]
    return Machine(
        x,
        {
            model: {
                name: read_deflection(name, twist)
                for name, twist in twists_of(analysis, postures, model).items()
            }
            for model in MODELS
        },
        frequencies[0],
        x[places],
        np.array([modes.frequencies_hz for modes in at_places]).T,
        np.array([moves_along_z(modes) for modes in at_places]).T,
        tuple(modes.energy_shares[1] for modes in at_places),
        max(sum(s.get(d, 0.0) for d in ("slide_1", "slide_2")) for s in lowest.energy_shares),
        beam,
        float(np.abs(np.divide(also, bends) - 1.0).max()),
        float(np.abs(other / lowest.frequencies_hz[:2] - 1.0).max()),
    )


def _with_turned_leg_2(robot: Robot) -> Robot:
    leg = robot.links["leg_2"]
    if leg.inertia is None:
        return robot
    quarter_turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    inertia = quarter_turn @ leg.inertia @ quarter_turn.T
    return replace(robot, links={**robot.links, "leg_2": replace(leg, inertia=inertia)})


def _leg_1(link: Link) -> tuple[dict[str, float], dict[str, float]]:
    """Return the lowest frequencies of the equivalent beam: by theory, and of rigid elements."""
    if link.compliance is None or link.mass is None:
        raise ValueError("the leg has no compliance or no mass")
    tip = link.ports["tip"].position
    line = equivalent_line(link.compliance, tip, link.mass, link.center_of_mass, link.inertia)
    return (
        _clamped(consistent_superelement(line, FINE, None), line.length),
        _clamped(lumped_superelement(line, LUMPED.n_elements, None), line.length),
    )


def _clamped(element: Superelement, length: float) -> dict[str, float]:
    """Return the lowest frequency, Hz, of each motion of the tip, with the base held."""
    n = element.mode_stiffness.size
    K = np.zeros((6 + n, 6 + n))
    K[:6, :6] = np.linalg.inv(element.compliance)
    K[6:, 6:] = np.diag(element.mode_stiffness)
    squared, shapes = eigh(K, element.mass[6:, 6:])
    moves = np.abs(shapes[:4]) * np.array([1.0, 1.0, 1.0, length])[:, None]
    kinds = np.argmax(moves, axis=0)
    return {
        name: float(np.sqrt(squared[np.argmax(kinds == k)]) / (2.0 * np.pi))
        for k, name in enumerate(("x", "y", "z", "rx"))
    }
