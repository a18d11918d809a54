"""Errors that are found after a robot file has been read, and are yet of the file."""

from __future__ import annotations

from stiffkit.errors import RobotFileError, StiffkitError
from stiffkit.robot.model import Robot


def with_place(error: StiffkitError, robot: Robot, key: str) -> StiffkitError:
    """Return an error with its place in the robot file; as it is if the robot has no file.

    ``key`` is the path of the key to blame, such as ``home`` or ``workspace.z``.
    """
    if robot.source is None:
        return error
    section = key.partition(".")[0]
    line = robot.lines.get(section)
    return RobotFileError(
        error.what, path=robot.source, line=line, key=key, mend=error.mend
    )
