"""Better dimensions: designs judged over their workspaces, gradients, optima, uncertainty."""

from stiffkit.design.points import map_design, parameters_of, write_design_robot
from stiffkit.design.read import SCHEMA_FILE, read_design
from stiffkit.design.spec import DesignSpec
from stiffkit.design.study import DATASET, run_design

__all__ = [
    "DATASET",
    "SCHEMA_FILE",
    "DesignSpec",
    "map_design",
    "parameters_of",
    "read_design",
    "run_design",
    "write_design_robot",
]
