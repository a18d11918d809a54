"""The robot as a network of elastic links and joints between rigid clusters."""

from stiffkit.network.coordinates import CoordinatesAtPosture, Model, NetworkCoordinates
from stiffkit.network.graph import (
    JointPart,
    LinkPart,
    Network,
    Node,
    Parallel,
    Part,
    Series,
    build_network,
    reduce_series_parallel,
)
from stiffkit.network.motions import FreeMotion, Motions
from stiffkit.network.parts import Looseness, PartsAtTool, add_elasticity, loose_directions

__all__ = [
    "CoordinatesAtPosture",
    "FreeMotion",
    "JointPart",
    "LinkPart",
    "Looseness",
    "Model",
    "Motions",
    "Network",
    "NetworkCoordinates",
    "Node",
    "Parallel",
    "Part",
    "PartsAtTool",
    "Series",
    "add_elasticity",
    "build_network",
    "loose_directions",
    "reduce_series_parallel",
]
