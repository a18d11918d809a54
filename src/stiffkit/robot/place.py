"""What is wrong in a robot file, but found only after it has been read."""

from __future__ import annotations

from typing import TypeVar

from stiffkit.errors import AssemblyError, PoseError
from stiffkit.robot.model import Robot

Error = TypeVar("Error", AssemblyError, PoseError)


def with_place(error: Error, robot: Robot, key: str) -> Error:
    """Return an error that begins with its place: ``file:line: key``, as far as it is known.

    ``key`` is the path of the key to blame, such as ``home`` or ``workspace.z``.
    """
    line = robot.lines.get(key.partition(".")[0])
    place = [str(part) for part in (robot.source, line) if part is not None]
    return type(error)(": ".join([":".join(place), key, error.what]), mend=error.mend)
