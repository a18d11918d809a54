"""The robot as a network of elastic links and joints between rigid clusters."""

from stiffkit.network.coordinates import (
    CoordinatesAtPosture,
    Model,
    NetworkCoordinates,
    elements_of,
)
from stiffkit.network.coupling import links_of, members, reduce_network
from stiffkit.network.graph import (
    Coupled,
    JointPart,
    LinkPart,
    Network,
    Node,
    Parallel,
    Part,
    Series,
    build_network,
)
from stiffkit.network.motions import FreeMotion, Motions
from stiffkit.network.parts import Looseness, PartsAtTool, add_elasticity, loose_directions

__all__ = [
    "CoordinatesAtPosture",
    "Coupled",
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
    "elements_of",
    "links_of",
    "loose_directions",
    "members",
    "reduce_network",
]
