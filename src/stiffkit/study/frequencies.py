"""Lowest natural frequencies of all postures of a map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import LinkError
from stiffkit.kinematics import Postures, Status
from stiffkit.stiffness import Model
from stiffkit.study.analysis import Analysis
from stiffkit.vibration import (
    FastModes,
    ModalModel,
    platform_mass,
    simplified_frequencies,
)

Array = NDArray[np.float64]

N_MODES = 4
"""Modes that a map holds."""

MOST_POSTURES = 100_000
"""Postures up to which a map holds frequencies without being asked for them."""

_MOST_BY_FULL_MODEL = 3_000
"""Postures that the full model is given where the fast one is not good enough."""


@dataclass(frozen=True, eq=False)
class Frequencies:
    """The frequencies of a map."""

    values: Array
    """(n_models, N_MODES, N), Hz, ascending; NaN where there is no answer."""
    method: str
    """How those of the refined model were computed, and how far they can be trusted."""


def has_mass(analysis: Analysis) -> bool:
    """Tell whether anything of the robot has mass."""
    robot = analysis.robot
    return bool(robot.tool.mass) or any(link.mass for link in robot.links.values())


def map_frequencies(
    analysis: Analysis,
    postures: Postures,
    status: NDArray[np.int8],
    simplified: Array,
    models: Sequence[Model],
) -> Frequencies:
    """Return the frequencies at N postures.

    ``status`` (n_models, N) says where there is an answer; ``simplified`` (21, N) are the
    compliances of the simplified model. Raises LinkError where a link's mass cannot be distributed.
    """
    values = np.full((len(models), N_MODES, len(postures)), np.nan)
    method = ""
    for m, model in enumerate(models):
        known = np.flatnonzero(status[m] == Status.OK)
        if known.size == 0:
            continue
        if model == "refined":
            values[m][:, known], method = _refined(analysis, postures.coordinates[:, known])
        else:
            values[m][:, known] = _simplified(
                analysis, simplified[:, known], postures.tool[:, known]
            )
    return Frequencies(values, method)


def _simplified(analysis: Analysis, lower: Array, tool: Array) -> Array:
    try:
        mass = platform_mass(analysis.robot)
    except LinkError:
        # A platform without mass has no frequency in this model, which is no fault of the robot.
        return np.full((N_MODES, lower.shape[1]), np.nan)
    return simplified_frequencies(lower, tool, mass, analysis.kinematics.length)[:N_MODES]


def _refined(analysis: Analysis, q: Array) -> tuple[Array, str]:
    kinematics = analysis.kinematics
    full = ModalModel(kinematics.tree, kinematics.length)
    fast = FastModes(full, q, N_MODES)
    trust = fast.trust
    found = (
        f"{trust.size} basis vectors, at {trust.checked} fresh postures within"
        f" {trust.error:.1e} of the full model"
    )
    if trust.good:
        return fast.frequencies(q), f"fast model: {found}"
    if q.shape[1] > _MOST_BY_FULL_MODEL:
        return fast.frequencies(q), f"fast model, NOT good to its tolerance: {found}"
    values = np.full((N_MODES, q.shape[1]), np.nan)
    for i, modes in enumerate(full.at_each(q, N_MODES)):
        values[: modes.frequencies_hz.size, i] = modes.frequencies_hz
    return values, f"full model at each posture; the fast one was not good enough ({found})"
