"""Studies of a robot: one pose, a map of the workspace, a summary."""

from stiffkit.study.analysis import Analysis
from stiffkit.study.map import map_workspace
from stiffkit.study.modes import (
    MODELS_OF_VIBRATION,
    Mode,
    ModesResult,
    VibrationModel,
    analyse_modes,
)
from stiffkit.study.pose import PoseResult, analyse_pose
from stiffkit.study.quantities import QUANTITIES, Quantity
from stiffkit.study.store import (
    FACES,
    MAP,
    MODES,
    REPRODUCTION,
    VERIFICATION,
    cad_link,
    identification,
    open_map,
    whole_directory,
    write_dataset,
)
from stiffkit.study.summary import Summary, probe_workspace, summarise

__all__ = [
    "FACES",
    "MAP",
    "MODELS_OF_VIBRATION",
    "MODES",
    "QUANTITIES",
    "REPRODUCTION",
    "VERIFICATION",
    "Analysis",
    "Mode",
    "ModesResult",
    "PoseResult",
    "Quantity",
    "Summary",
    "VibrationModel",
    "analyse_modes",
    "analyse_pose",
    "cad_link",
    "identification",
    "map_workspace",
    "open_map",
    "probe_workspace",
    "summarise",
    "whole_directory",
    "write_dataset",
]
