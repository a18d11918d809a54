"""What a robot is, and how a robot file becomes one."""

from stiffkit.robot.catalogue import CatalogueRobot, describe_robots, list_robots
from stiffkit.robot.joints import with_freedoms
from stiffkit.robot.loader import RobotFile, load_robot
from stiffkit.robot.model import (
    BASE,
    DIRECTIONS,
    Freedom,
    Home,
    Joint,
    Link,
    Load,
    Parameter,
    Robot,
    Tool,
    Workspace,
)
from stiffkit.robot.place import with_place

__all__ = [
    "BASE",
    "DIRECTIONS",
    "CatalogueRobot",
    "Freedom",
    "Home",
    "Joint",
    "Link",
    "Load",
    "Parameter",
    "Robot",
    "RobotFile",
    "Tool",
    "Workspace",
    "describe_robots",
    "list_robots",
    "load_robot",
    "with_freedoms",
    "with_place",
]
