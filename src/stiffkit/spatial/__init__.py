"""Rotations, frames, twists and wrenches in NumPy, for everything outside the posture kernel."""

from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import axis_rotation, exp_rotation, log_rotation, skew
from stiffkit.spatial.twist import Screw, shift_compliance, shift_stiffness, twist_shift

__all__ = [
    "Frame",
    "Screw",
    "axis_rotation",
    "exp_rotation",
    "log_rotation",
    "shift_compliance",
    "shift_stiffness",
    "skew",
    "twist_shift",
]
