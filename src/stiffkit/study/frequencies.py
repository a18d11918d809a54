"""Lowest natural frequencies of all postures of a map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import LinkError
from stiffkit.kinematics import Postures, Status
from stiffkit.robot import Robot
from stiffkit.stiffness import Model
from stiffkit.study.analysis import Analysis
from stiffkit.study.branches import Followed, follow
from stiffkit.study.grid import PoseGrid
from stiffkit.vibration import (
    SPARE_MODES,
    FastModes,
    ModalModel,
    ModeVectors,
    modes_in_own_axes,
    platform_mass,
    simplified_mode_vectors,
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
    followed: dict[Model, Followed]
    """The modes of each model that has an answer, followed over the workspace."""


def has_mass(robot: Robot) -> bool:
    """Tell whether anything of a robot has mass."""
    return bool(robot.tool.mass) or any(link.mass for link in robot.links.values())


def map_frequencies(
    analysis: Analysis,
    grid: PoseGrid,
    postures: Postures,
    status: NDArray[np.int8],
    simplified: Array,
    models: Sequence[Model],
) -> Frequencies:
    """Return the frequencies at N postures, the poses of a grid.

    ``status`` (n_models, N) says where there is an answer; ``simplified`` (21, N) are the
    compliances of the simplified model. Raises LinkError where a link's mass cannot be distributed.
    """
    values = np.full((len(models), N_MODES, len(postures)), np.nan)
    method, followed = "", {}
    for m, model in enumerate(models):
        known = status[m] == Status.OK
        if not known.any():
            continue
        if model == "refined":
            modes, method = _refined(analysis, postures.coordinates[:, known])
        else:
            modes = _simplified(analysis, simplified[:, known], postures.tool[:, known])
        values[m][:, known] = modes.frequencies[:N_MODES]
        followed[model] = follow(modes, grid, known, N_MODES)
    return Frequencies(values, method, followed)


def _simplified(analysis: Analysis, lower: Array, tool: Array) -> ModeVectors:
    try:
        mass = platform_mass(analysis.robot)
    except LinkError:
        # A platform without mass has no frequency in this model, which is no fault of the robot.
        n = lower.shape[1]
        return ModeVectors(np.full((N_MODES, n), np.nan), np.zeros((n, N_MODES, 0)))
    return simplified_mode_vectors(lower, tool, mass, analysis.kinematics.length)


def _refined(analysis: Analysis, q: Array) -> tuple[ModeVectors, str]:
    kinematics = analysis.kinematics
    full = ModalModel(kinematics.tree, kinematics.length)
    fast = FastModes(full, q, N_MODES)
    trust = fast.trust
    found = (
        f"{trust.size} basis vectors, at {trust.checked} fresh postures within"
        f" {trust.error:.1e} of the full model"
    )
    if trust.good:
        return fast.modes(q), f"fast model: {found}"
    if q.shape[1] > _MOST_BY_FULL_MODEL:
        return fast.modes(q), f"fast model, NOT good to its tolerance: {found}"
    return (
        modes_in_own_axes(full, q, N_MODES + SPARE_MODES),
        f"full model at each posture; the fast one was not good enough ({found})",
    )
