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
from stiffkit.vibration.fast import FastModes
from stiffkit.vibration.modes import ModalModel, Modes
from stiffkit.vibration.simplified import (
    platform_mass,
    simplified_frequencies,
    simplified_modes,
)
from stiffkit.vibration.struck import struck_robot
from stiffkit.vibration.words import describe_mode

__all__ = [
    "SHOWN",
    "Bodies",
    "Discretisation",
    "FastModes",
    "JointDrawing",
    "LinkDrawing",
    "ModalModel",
    "Modes",
    "ModesDrawing",
    "Path",
    "describe_mode",
    "draw_modes",
    "make_bodies",
    "platform_mass",
    "simplified_frequencies",
    "simplified_modes",
    "struck_robot",
]
