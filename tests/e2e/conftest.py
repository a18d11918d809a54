"""What the tests of the commands share."""

from __future__ import annotations

from pathlib import Path

import pytest

from .commandline import SMALL_ROBOT, run


@pytest.fixture(scope="session")
def biglide_map(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the directory that ``stiffkit map biglide`` made, with few postures."""
    here = tmp_path_factory.mktemp("biglide")
    ended = run("map", "biglide", "--points", "400", "-o", "out/biglide", cwd=here, timeout=180)
    assert ended.returncode == 0, ended.stderr
    return here / "out" / "biglide"


@pytest.fixture
def small_robot(tmp_path: Path) -> Path:
    """Return a small robot's file in an otherwise empty directory."""
    path = tmp_path / "two-arms.yaml"
    path.write_text(SMALL_ROBOT, encoding="utf-8")
    return path
