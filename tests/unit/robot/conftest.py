"""Robot files for the tests, written as text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from stiffkit.robot import Robot, load_robot

Load = Callable[..., Robot]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Write a text to a file and load it as a robot."""

    def write_and_load(text: str, parameters: Mapping[str, str | float] | None = None) -> Robot:
        path = tmp_path / "robot.yaml"
        path.write_text(text, encoding="utf-8")
        return load_robot(path, parameters)

    return write_and_load
