"""``stiffkit verify``: the table, JSON, the directory, and what it refuses."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from .commandline import output_of, refusal_of

pytest.importorskip("netgen.occ")


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A directory with a robot of CAD parts, and a cache of its own."""
    here = tmp_path_factory.mktemp("verify")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(here / "cache"))
        patch.syspath_prepend(str(Path(__file__).parents[1] / "unit"))
        import verify_robots as robots  # type: ignore[import-not-found]

        robots.make_parts(here)
        # It is loaded, so that its links are solved before a command that must end in time.
        robots.robot(here, robots.FIVE_BAR, "clamped", "average").source.rename(here / "five.yaml")
        yield here
        sys.modules.pop("verify_robots")


def test_the_table_and_the_directory(here: Path) -> None:
    at = ("--at", "x=30mm,y=400mm", "--at", "y=0.35")
    shown = output_of("verify", "five.yaml", *at, "-n", "1", "-o", "out", cwd=here)
    lines = shown.splitlines()
    assert lines[0] == "five: the reduced model beside finite elements of the whole robot"
    elements = [line.split() for line in lines if line.strip().startswith("x,x")]
    assert [element[3:6] for element in elements] == 2 * [["<", "1e-06", "%"]]
    assert [line.split(",")[1] for line in lines if line.startswith("tool ")] == [
        " y 400 mm",
        " y 350 mm",
    ]
    assert "left_arm, right_arm" in shown
    assert lines[-1] == "verify.json in out"
    kept = json.loads((here / "out" / "verify.json").read_text("utf-8"))
    for posture in kept["postures"]:
        assert posture["largest_differences"]["compliance"] < 1e-7
        assert len(posture["frequencies"]) == 1


def test_what_cannot_be_meshed_is_refused(tmp_path: Path) -> None:
    told = refusal_of("verify", "five-bar", cwd=tmp_path)
    assert "elastic links that are not given by CAD: left_arm (beam)" in told
    assert "positive --size" in refusal_of("verify", "five-bar", "--size", "0", cwd=tmp_path)
    assert "positive" in refusal_of("verify", "five-bar", "--size", "-1 mm", cwd=tmp_path)
