"""Loop closure, mobility and reach: the robot as rigid bodies."""

from stiffkit.kinematics.closure import ClosureEquations
from stiffkit.kinematics.locate import Located
from stiffkit.kinematics.mobility import Mobility
from stiffkit.kinematics.places import Locator, Places
from stiffkit.kinematics.postures import Kinematics, Postures, Status, typical_length
from stiffkit.kinematics.tree import SpanningTree

__all__ = [
    "ClosureEquations",
    "Kinematics",
    "Located",
    "Locator",
    "Mobility",
    "Places",
    "Postures",
    "SpanningTree",
    "Status",
    "typical_length",
]
