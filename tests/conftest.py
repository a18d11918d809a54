"""Settings and fixtures of all tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from hypothesis import settings

from stiffkit.robot import Robot, load_robot

# The same examples in every run: a failure means a change of the code, never luck.
settings.register_profile(
    "stiffkit", deadline=None, derandomize=True, print_blob=True, max_examples=50, database=None
)
settings.load_profile("stiffkit")


@pytest.fixture
def robot_of(tmp_path: Path) -> Callable[..., Robot]:
    """Return a function from the text of a robot file, and parameters to replace, to the robot."""

    def write_and_load(text: str, parameters: Mapping[str, str | float] | None = None) -> Robot:
        path = tmp_path / "robot.yaml"
        path.write_text(text, encoding="utf-8")
        return load_robot(path, parameters)

    return write_and_load
