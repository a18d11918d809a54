"""Links from CAD with more than two ports: a bar held at one end, with two ports further along."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.fea import link_from_cad
from stiffkit.fea.cad_link import CadLink, as_json
from stiffkit.link.file import read_link_file
from stiffkit.link.ports import places_of, relative_to_base
from stiffkit.robot import load_robot
from stiffkit.spatial import twist_shift
from stiffkit.study import analyse_pose

Array = NDArray[np.float64]

SHAPES = Path(__file__).parent

BAR = """\
link: Bar
cad: bar.step
material: steel
base: {{faces: {{name: {base}}}, interface: clamped}}
{ports}
mesh: {{size: 10 mm, order: 2}}
modes: 2
"""

MIDDLE = "{faces: {name: middle}, interface: rigid}"
END = "{faces: {name: tip}, interface: average}"


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return a directory with a bar of two halves, whose middle is a face too, and a cache."""
    here = tmp_path_factory.mktemp("ports")
    make = (
        f"import sys; sys.path.insert(0, {str(SHAPES)!r}); import fea_shapes as shapes; "
        "shapes.split_bar().WriteStep('bar.step')"
    )
    subprocess.run([sys.executable, "-c", make], cwd=here, check=True, capture_output=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(here / "cache"))
        yield here


def link_with(here: Path, ports: str, name: str, base: str = "base") -> CadLink:
    path = here / f"{name}.yaml"
    path.write_text(BAR.format(ports=ports, base=base), encoding="utf-8")
    return link_from_cad(path)


@pytest.fixture(scope="module")
def three(here: Path) -> CadLink:
    return link_with(here, f"ports:\n  tip: {END}\n  middle: {MIDDLE}", "three")


def relative(k: Array, other: Array) -> float:
    size = np.sqrt(np.diag(other))
    return float(np.max(np.abs(k - other) / np.outer(size, size)))


def test_a_rigid_middle_parts_the_halves(here: Path, three: CadLink) -> None:
    """Whatever is done to it, the end moves along with it, and bends as the outer half alone."""
    assert list(three.solved.ports) == ["tip", "middle"]
    k = three.compliance
    arm = twist_shift([0.05, 0.0, 0.0])
    inner = k[6:, 6:]
    np.testing.assert_allclose(k[:6, 6:], arm @ inner, atol=1e-9 * k[:6, 6:].max())
    middle = link_with(here, f"ports: {{middle: {MIDDLE}}}", "middle")
    np.testing.assert_allclose(middle.solved.ports["middle"].position, [0.05, 0.0, 0.0], atol=1e-9)
    assert relative(inner, middle.compliance) < 1e-9
    outer = link_with(here, f"tip: {END}", "outer", base="middle")
    assert relative(k[:6, :6] - arm @ inner @ arm.T, outer.compliance) < 1e-9


def test_an_average_port_changes_nothing_for_the_others(here: Path) -> None:
    average = MIDDLE.replace("rigid", "average")
    both = link_with(here, f"ports:\n  tip: {END}\n  middle: {average}", "average")
    alone = link_with(here, f"tip: {END}", "alone")
    assert relative(both.compliance[:6, :6], alone.compliance) < 1e-9


def test_the_superelement_has_all_ports_and_the_mass(three: CadLink) -> None:
    element = three.solved.element
    assert element.mass.shape == (20, 20)
    motions = np.vstack([np.eye(6), *(twist_shift(p) for p in places_of(three.solved.ports))])
    mass = motions.T @ element.mass[:18, :18] @ motions
    np.testing.assert_allclose(np.diag(mass)[:3], three.solved.mass, rtol=1e-7)
    K = element.stiffness(places_of(three.solved.ports))[:18, :18]
    assert np.abs(K @ motions).max() < 1e-7 * np.abs(K).max()
    B = relative_to_base(places_of(three.solved.ports))
    np.testing.assert_allclose(B @ motions, 0.0, atol=1e-12)


def test_link_file_cache_and_json_carry_every_port(here: Path, three: CadLink) -> None:
    again = link_from_cad(here / "three.yaml")
    assert again.from_cache
    np.testing.assert_array_equal(again.compliance, three.compliance)
    assert list(again.solved.ports) == ["tip", "middle"]
    again.write(here / "three.link.yaml")
    read = read_link_file(here / "three.link.yaml")
    assert list(read.ports) == ["tip", "middle"]
    np.testing.assert_array_equal(read.compliance, three.compliance)
    assert read.notes == ()
    assert list(as_json(again)["ports"]) == ["tip", "middle"]
    assert again.solved.surface.displacements.shape[2] == 12


def test_the_base_may_give_the_axes(here: Path) -> None:
    text = BAR.format(ports=f"ports:\n  middle: {MIDDLE}\n  tip: {END}", base="base")
    turned = text.replace("interface: clamped", "interface: clamped, rotate: {z: 90 deg}")
    (here / "turned.yaml").write_text(turned, encoding="utf-8")
    link = link_from_cad(here / "turned.yaml")
    np.testing.assert_allclose(link.solved.ports["tip"].position, [0.0, -0.1, 0.0], atol=1e-9)
    stretch = link.compliance[7, 7]
    assert stretch == pytest.approx(0.1 / (MATERIAL_E * 1e-4), rel=0.05)


MATERIAL_E = 210e9

ROBOT = """\
robot: Bar between two walls
links:
  bar: {cad: three.yaml}
  hand: {rigid: {}}
joints:
  root: {prismatic: z, from: base, to: bar.base, drive: rigid}
  stay: {spherical: true, from: base, at: [50 mm, 0, 0], to: bar.middle, elastic: {z: 1e7 N/m}}
  grip: {revolute: x, from: bar.tip, to: hand, drive: 1e4 N m/rad}
tool: {at: hand}
loads: {down: {force: [0, 0, -10 N]}}
"""


def test_a_robot_uses_every_port(here: Path, three: CadLink) -> None:
    (here / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    robot = load_robot(here / "robot.yaml")
    pose = analyse_pose(robot)
    # By hand: the middle held across, but free to turn, and held by a spring along z.
    k = three.compliance
    held = [6, 7, 8]
    spring = np.diag([0.0, 0.0, 1e-7])
    at = k[:6, held] @ np.linalg.solve(k[np.ix_(held, held)] + spring, k[held, :6])
    expected = k[:6, :6] - at
    found = pose.compliance
    size = np.sqrt(np.diag(expected))
    rest = np.array(found) - expected
    rest[3, 3] -= 1e-4
    assert np.max(np.abs(rest) / np.outer(size, size)) < 1e-9
