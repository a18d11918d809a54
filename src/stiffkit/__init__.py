"""Stiffness and vibration of parallel robots over their whole workspace.

Three lines to a result::

    import stiffkit
    result = stiffkit.analyse_pose(stiffkit.load_robot("biglide"), {"x": 0.4975, "y": 0.0})
    print(result.compliance)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stiffkit.errors import StiffkitError
    from stiffkit.fea import CadLink, PythonPart, link_from_cad
    from stiffkit.identify import IdentifiedLink, identify_link
    from stiffkit.robot import Robot, list_robots, load_robot
    from stiffkit.study import (
        ModesResult,
        PoseResult,
        Summary,
        analyse_modes,
        analyse_pose,
        map_workspace,
        open_map,
        summarise,
    )

__version__ = "0.1.0"

# Rooms load when they are first used, so that a command that needs none starts at once.
_HOMES = {
    "StiffkitError": "stiffkit.errors",
    "CadLink": "stiffkit.fea",
    "PythonPart": "stiffkit.fea",
    "link_from_cad": "stiffkit.fea",
    "IdentifiedLink": "stiffkit.identify",
    "identify_link": "stiffkit.identify",
    "Robot": "stiffkit.robot",
    "list_robots": "stiffkit.robot",
    "load_robot": "stiffkit.robot",
    "ModesResult": "stiffkit.study",
    "PoseResult": "stiffkit.study",
    "Summary": "stiffkit.study",
    "analyse_modes": "stiffkit.study",
    "analyse_pose": "stiffkit.study",
    "map_workspace": "stiffkit.study",
    "open_map": "stiffkit.study",
    "summarise": "stiffkit.study",
}

__all__ = [
    "CadLink",
    "IdentifiedLink",
    "ModesResult",
    "PoseResult",
    "PythonPart",
    "Robot",
    "StiffkitError",
    "Summary",
    "__version__",
    "analyse_modes",
    "analyse_pose",
    "identify_link",
    "link_from_cad",
    "list_robots",
    "load_robot",
    "map_workspace",
    "open_map",
    "summarise",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its room."""
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'stiffkit' has no attribute {name!r}")
