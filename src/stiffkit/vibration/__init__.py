"""Natural frequencies and mode shapes of postures."""

from stiffkit.vibration.bodies import Bodies, Discretisation, make_bodies
from stiffkit.vibration.modes import ModalModel, Modes

__all__ = ["Bodies", "Discretisation", "ModalModel", "Modes", "make_bodies"]
