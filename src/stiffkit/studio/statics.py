"""Static deflections of everything, in the coordinates that modes are given in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics.numeric import one_thread
from stiffkit.network import Motions
from stiffkit.vibration import ModalModel

Array = NDArray[np.float64]

_WORK = 1e-8
"""Work on free motions, over that on all, below which there is none."""


def static_shape(model: ModalModel, q: Array, wrench: Array) -> Array | None:
    """Return the shape (n_shape, 1) under a wrench (6,), N and N m, at coordinates (n,).

    It has the coordinates of `stiffkit.vibration.Modes.shapes`; their energy less the work of the
    wrench is least. None where the wrench does work on a motion that nothing holds.
    """
    at = next(model.coordinates.at_each(q[:, None]))
    with one_thread():
        motions = Motions.of(at)
        to_si = np.array([model.length] * 3 + [1.0] * 3)
        force = at.tool.T @ (to_si * wrench)
        if np.linalg.norm(motions.free.T @ force) > _WORK * np.linalg.norm(force):
            return None
        R = motions.factor()
        held = np.linalg.solve(R, np.linalg.solve(R.T, motions.held.T @ force))
        return np.asarray((motions.held @ held)[:, None])


def tool_twist(model: ModalModel, q: Array, shapes: Array) -> Array:
    """Return the tool's twist (6, n), SI, world axes, in shapes (n_shape, n) at a posture (n,)."""
    at = next(model.coordinates.at_each(q[:, None]))
    to_si = np.array([model.length] * 3 + [1.0] * 3)
    return np.asarray(to_si[:, None] * (at.tool @ shapes))
