"""Natural frequencies and mode shapes of postures."""

from stiffkit.vibration.bodies import Bodies, Discretisation, make_bodies
from stiffkit.vibration.drawing import (
    SHOWN,
    JointDrawing,
    LinkDrawing,
    ModesDrawing,
    Path,
    draw_modes,
)
from stiffkit.vibration.fast import SPARE_MODES, FastModes
from stiffkit.vibration.geometries import FastGeometries
from stiffkit.vibration.modes import ModalModel, Modes
from stiffkit.vibration.moving import Moving, Spine
from stiffkit.vibration.own_axes import modes_in_own_axes
from stiffkit.vibration.simplified import (
    platform_mass,
    simplified_frequencies,
    simplified_mode_vectors,
    simplified_modes,
)
from stiffkit.vibration.struck import struck_robot
from stiffkit.vibration.tracking import Branches, ModeVectors, track_modes
from stiffkit.vibration.words import describe_mode

__all__ = [
    "SHOWN",
    "SPARE_MODES",
    "Bodies",
    "Branches",
    "Discretisation",
    "FastGeometries",
    "FastModes",
    "JointDrawing",
    "LinkDrawing",
    "ModalModel",
    "ModeVectors",
    "Modes",
    "ModesDrawing",
    "Moving",
    "Path",
    "Spine",
    "describe_mode",
    "draw_modes",
    "make_bodies",
    "modes_in_own_axes",
    "platform_mass",
    "simplified_frequencies",
    "simplified_mode_vectors",
    "simplified_modes",
    "struck_robot",
    "track_modes",
]
