"""The reduced model beside one sparse system of all nodes of all parts, on the same meshes.

With the same discretisation both are the same mathematics: what is left of a difference would be an
error of the reduction, of the link's frames, of the assembly, or of the joints.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("netgen.occ")

import verify_robots as robots  # type: ignore[import-not-found]

from stiffkit.link import MATERIALS
from stiffkit.progress import no_progress
from stiffkit.robot import Robot
from stiffkit.study import Analysis, analyse_modes, analyse_pose
from stiffkit.verify.body import Body
from stiffkit.verify.frequencies import lowest_frequencies
from stiffkit.verify.meshes import Resolution, mesh_parts
from stiffkit.verify.places import Places
from stiffkit.verify.posture import bodies_of, frames_of
from stiffkit.verify.whole import Whole

SAME = 1e-7
"""Relative difference of significant elements; the sum of two solvers' rounding."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the parts, and a cache of its own."""
    folder = tmp_path_factory.mktemp("whole")
    robots.make_parts(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        yield folder


def bodies(robot: Robot) -> dict[str, Body]:
    parts = mesh_parts(robot, Resolution(), no_progress)
    assert all(part.is_own for part in parts)
    return bodies_of(robot, parts, no_progress)


def whole_at(analysis: Analysis, bodies: dict[str, Body], at: dict[str, float]) -> Whole:
    q = analysis.kinematics.solve_at(at).coordinates[:, 0]
    places = Places(analysis.kinematics.tree, q)
    return Whole(analysis.robot, bodies, frames_of(analysis.robot, places), places)


def compare(analysis: Analysis, bodies: dict[str, Body], at: dict[str, float]) -> None:
    whole = whole_at(analysis, bodies, at)
    k, reduced = whole.compliance(), analyse_pose(analysis, at).compliance
    assert reduced is not None
    size = np.sqrt(np.outer(np.diag(k), np.diag(k)))
    significant = np.abs(k) > 1e-3 * size
    assert np.abs(reduced / k - 1.0)[significant].max() < SAME
    assert whole.residual < 1e-7
    frequencies = lowest_frequencies(whole, 4)
    # The links' modes are cut off, which makes the reduced model a little stiffer.
    stiffer = analyse_modes(analysis, at, 4).frequencies_hz / frequencies - 1.0
    assert stiffer.max() < 5e-3
    assert stiffer.min() > -1e-7


@pytest.mark.parametrize(
    ("base", "postures"),
    [
        # At y = 528 mm the arms and the rods are nearly in line: 300 um/N along y become 6.
        ("clamped", [(0.0, 0.4), (-0.08, 0.45), (0.0, 0.528)]),
        ("average", [(0.05, 0.35), (0.03, 0.5)]),
    ],
)
def test_a_five_bar(folder: Path, base: str, postures: list[tuple[float, float]]) -> None:
    robot = robots.robot(folder, robots.FIVE_BAR, base, "average")
    analysis, parts = Analysis(robot), bodies(robot)
    for x, y in postures:
        compare(analysis, parts, {"x": x, "y": y})


def test_a_slide_with_a_rigid_body_and_a_spinning_rod(folder: Path) -> None:
    robot = robots.robot(folder, robots.SLIDE, "rigid", "rigid", low="spherical: true")
    other = robots.robot(folder, robots.SLIDE, "rigid", "rigid", low="universal: [y, z]")
    parts = bodies(robot)
    for one, spins in ((robot, 1), (other, 0)):
        analysis = Analysis(one)
        compare(analysis, parts, {})
        assert whole_at(analysis, parts, {}).free_motions.shape[1] == spins


def test_two_bars_in_line_are_one_long_bar(folder: Path) -> None:
    text = """\
robot: Two bars
links:
  first: {rod}
  second: {{like: first}}
joints:
  root: {{fixed: true, from: base, to: first.base}}
  weld: {{fixed: true, from: first.tip, to: second.base}}
tool: {{at: second.tip}}
"""
    robot = robots.robot(folder, text, "average", "average", order=3)
    k = whole_at(Analysis(robot), bodies(robot), {}).compliance()
    E, length, b, h = MATERIALS["steel"].E, 0.7, 0.016, 0.010
    assert k[0, 0] == pytest.approx(length / (E * b * h), rel=2e-3)
    assert k[1, 1] == pytest.approx(length**3 / (3 * E * h * b**3 / 12), rel=3e-3)
    assert k[2, 2] == pytest.approx(length**3 / (3 * E * b * h**3 / 12), rel=3e-3)
    assert k[4, 4] == pytest.approx(length / (E * b * h**3 / 12), rel=2e-3)
