from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray
from scipy.linalg import LinAlgError

from stiffkit.errors import LinkError, PoseError
from stiffkit.kinematics import Status
from stiffkit.robot import Robot, load_robot
from stiffkit.study import Analysis, ModesResult, VibrationModel, analyse_modes
from stiffkit.vibration.words import describe_energy, describe_tool, direction_words

CANTILEVER = """\
robot: Cantilever
links:
  beam: {beam: {length: 1 m, section: {rectangle: [20 mm, 10 mm]}, material: steel}}
joints:
  wall: {revolute: z, from: base, to: beam.base, drive: rigid}
tool: {at: beam.tip}
home: {wall: 0 deg}
workspace: {x: [500 mm, 900 mm]}
"""


def robot(directory: Path, text: str) -> Robot:
    path = directory / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    return load_robot(path)


def arms(
    directory: Path,
    *,
    upper: str = "",
    tool: str = ", mass: 2 kg",
    shoulder: str = ", drive: 1e4 N m/rad",
    elbow: str = ", drive: 5e3 N m/rad",
) -> Robot:
    """Two rigid arms in a plane, the second one at a right angle: no loops, masses at will."""
    return robot(
        directory,
        f"""\
robot: Two arms
links:
  upper: {{rigid: {{length: 400 mm}}{upper}}}
  fore: {{rigid: {{length: 300 mm}}}}
joints:
  shoulder: {{revolute: z, from: base, to: upper.base{shoulder}}}
  elbow: {{revolute: z, from: upper.tip, to: fore.base{elbow}}}
tool: {{at: fore.tip{tool}}}
home: {{shoulder: 0 deg, elbow: 90 deg}}
workspace: {{x: [200 mm, 400 mm]}}
""",
    )


@pytest.fixture(scope="module")
def biglide() -> Analysis:
    return Analysis(load_robot("biglide"))


@pytest.fixture(scope="module")
def at_home(biglide: Analysis) -> ModesResult:
    return analyse_modes(biglide)


def test_four_modes_by_default(at_home: ModesResult) -> None:
    assert at_home.status is Status.OK
    assert at_home.frequencies_hz == pytest.approx([97.4, 134.0, 176.0, 198.7], abs=0.1)
    assert at_home.notes == ("an inertia without a mass counts for nothing: foot_1, foot_2",)
    assert at_home.free_motions == ()


def test_modes_are_described(at_home: ModesResult) -> None:
    first, second = at_home.modes[:2]
    assert first.description.startswith("tool moves along z")
    assert "foot_2 stores 60 % of the strain energy, foot_1 24 %" in first.description
    assert "leg_1 stores 53 % of the strain energy" in second.description
    assert sum(first.energy_shares.values()) == pytest.approx(1.0)


def test_rules_name_every_mass(at_home: ModesResult) -> None:
    assert set(at_home.rules) == {"foot_1", "foot_2", "leg_1", "leg_2", "tool point"}
    assert "equivalent beam" in at_home.rules["leg_1"]
    assert "8 consistent elements" in at_home.rules["leg_1"]
    assert at_home.rules["tool point"] == "46 kg: point mass"
    assert at_home.rules["foot_1"] == "no mass given: a spring"


def test_json_is_plain(at_home: ModesResult) -> None:
    read = json.loads(json.dumps(at_home.as_json(), allow_nan=False))
    assert read["status"] == "ok"
    assert read["frequencies_hz"] == pytest.approx(at_home.frequencies_hz)
    assert read["frequencies_hz"] == sorted(read["frequencies_hz"])
    assert read["modes"][0]["tool"]["z"] == pytest.approx(at_home.modes[0].tool[2])


def test_lumped_model_has_twenty_elements_by_default(biglide: Analysis) -> None:
    lumped = analyse_modes(biglide, n=2, model="lumped")
    assert "20 rigid elements" in lumped.rules["leg_1"]
    refined = analyse_modes(biglide, n=2)
    assert lumped.frequencies_hz == pytest.approx(refined.frequencies_hz, rel=2e-3)


def test_elements_are_counted(biglide: Analysis) -> None:
    assert "3 consistent elements" in analyse_modes(biglide, n_elements=3).rules["leg_1"]
    with pytest.raises(PoseError, match="too few"):
        analyse_modes(biglide, model="lumped", n_elements=1)
    with pytest.raises(PoseError, match="no elements"):
        analyse_modes(biglide, model="simplified", n_elements=5)
    with pytest.raises(PoseError, match="0 modes"):
        analyse_modes(biglide, n=0)


def test_simplified_model_has_as_many_modes_as_drives(biglide: Analysis) -> None:
    result = analyse_modes(biglide, model="simplified")
    assert result.status is Status.OK
    assert result.n_existing == len(result.modes) == 2
    assert result.notes == ("4 modes were asked for, and the simplified model has 2 modes here",)


def test_idle_motions_without_mass_do_not_disturb_the_simplified_model() -> None:
    # The rods of a Delta robot spin freely, and have no mass in this model.
    result = analyse_modes(load_robot("delta"), model="simplified")
    assert result.n_existing == 3
    assert len(result.idle_motions) == 6
    assert result.frequencies_hz == pytest.approx([38.539, 38.539, 77.969], abs=1e-3)


def test_modes_of_equal_frequency_are_told_apart_by_the_axes() -> None:
    first, second = analyse_modes(load_robot("delta"), n=2).modes
    assert first.frequency_hz == pytest.approx(second.frequency_hz, rel=1e-9)
    assert first.description.startswith("tool moves along x")
    assert second.description.startswith("tool moves along y")
    assert abs(first.tool[1]) < 1e-6 * abs(first.tool[0])


def test_posture_out_of_reach(biglide: Analysis) -> None:
    result = analyse_modes(biglide, {"x": 3.0})
    assert result.status is Status.UNREACHABLE
    assert "x = 3 m" in result.reason
    assert result.modes == ()
    assert result.drawing is None
    json.dumps(result.as_json(), allow_nan=False)


def test_free_motions_are_kept_apart(tmp_path: Path) -> None:
    heavy = ", mass: 3 kg, center_of_mass: [0.3, 0, 0]"
    result = analyse_modes(arms(tmp_path, upper=heavy, shoulder=""))
    assert result.status is Status.UNCONTROLLED
    assert len(result.free_motions) == 1
    assert "shoulder" in result.free_motions[0]
    assert result.reason.endswith(result.free_motions[0])
    # One arm folds against the other's spin. By Lagrange, with u of both angles and the elbow's
    # spring: a free rotation and 1/omega^2 = the inertia left when momentum is taken out, over K.
    J = np.array([[-0.3, -0.3], [0.4, 0.0]])
    M = 2.0 * J.T @ J + np.diag([3.0 * 0.3**2, 0.0])
    left = M[1, 1] - M[0, 1] ** 2 / M[0, 0]
    assert result.n_existing == 1
    assert result.frequencies_hz == pytest.approx(np.sqrt(5e3 / left) / (2 * np.pi), rel=1e-9)


def test_two_arms_in_closed_form(tmp_path: Path) -> None:
    # A point mass on two rotary springs: k = J diag(1/K) J^T, f = 1/(2 pi sqrt(eig(m k))).
    result = analyse_modes(arms(tmp_path))
    J = np.array([[-0.3, -0.3], [0.4, 0.0]])
    k = J @ np.diag([1e-4, 1 / 5e3]) @ J.T
    omega = np.sort(1.0 / np.sqrt(2.0 * np.linalg.eigvalsh(k)))
    assert result.frequencies_hz == pytest.approx(omega / (2 * np.pi), rel=1e-9)
    assert result.n_existing == 2


def test_the_platform_is_all_that_is_fixed_to_the_tool(tmp_path: Path) -> None:
    expected = analyse_modes(arms(tmp_path), model="simplified").frequencies_hz
    grips = robot(
        tmp_path,
        (tmp_path / "robot.yaml")
        .read_text()
        .replace(", mass: 2 kg", "")
        .replace(
            "joints:",
            "  gripper: {rigid: {length: 1 m}, mass: 2 kg, center_of_mass: [0, 0, 0]}\njoints:\n"
            "  flange: {fixed: true, from: fore.tip, to: gripper.base}",
        ),
    )
    assert analyse_modes(grips, model="simplified").frequencies_hz == pytest.approx(expected)


@pytest.mark.parametrize("model", ["refined", "lumped"])
def test_a_link_with_mass_and_no_inertia_vibrates(model: VibrationModel) -> None:
    robot = load_robot("biglide")
    slim = replace(robot.links["leg_2"], inertia=None)
    result = analyse_modes(replace(robot, links={**robot.links, "leg_2": slim}), model=model)
    assert result.frequencies_hz[:2] == pytest.approx([97.6, 134.0], abs=0.2)


@pytest.mark.parametrize("model", ["refined", "simplified"])
def test_no_mass_is_an_error(tmp_path: Path, model: VibrationModel) -> None:
    with pytest.raises(LinkError, match="no mass") as told:
        analyse_modes(arms(tmp_path, tool=""), model=model)
    assert "mass: 5 kg" in told.value.mend


def test_mass_without_any_spring_is_told(tmp_path: Path) -> None:
    result = analyse_modes(arms(tmp_path, shoulder=", drive: rigid", elbow=", drive: rigid"))
    assert result.status is Status.OK
    assert result.modes == ()
    assert "no elastic mode" in result.notes[0]


def test_cantilever_as_a_robot(tmp_path: Path) -> None:
    result = analyse_modes(robot(tmp_path, CANTILEVER), n=2)
    E, density = 2.1e11, 7850.0
    for thickness, found in zip((0.01, 0.02), result.frequencies_hz, strict=True):
        slender = 1.87510407**2 / (2 * np.pi) * np.sqrt(E * thickness**2 / 12 / density)
        assert found == pytest.approx(slender, rel=2e-3)


# Words.


@pytest.mark.parametrize(
    ("twist", "share", "words"),
    [
        ([0, 0, 1, 0, 0, 0], 1.0, "moves along z"),
        ([0, 0, -1, 0, 0, 0], 1.0, "moves along z"),
        ([1, 1, 0, 0, 0, 0.1], 1.0, "moves along (0.71, 0.71, 0)"),
        ([-1, 1, 0, 0, 0, 0.1], 1.0, "moves along (0.71, -0.71, 0)"),
        ([1, 0, 0, 0, 1, 0], 1.0, "moves along x, turning about y"),
        ([0, 0, 0, 0, 0, 1], 0.3, "turns about z"),
        ([0, 0.2, 0, 0, 0, 2], 0.3, "turns about z through (900, 0, 0) mm"),
        ([1, 0, 0, 0, 0, 0], 0.001, "hardly moves"),
        ([0, 0, 0, 0, 0, 0], 0.0, "stands still"),
    ],
)
def test_tool_in_words(twist: list[float], share: float, words: str) -> None:
    point = np.array([1.0, 0.0, 0.0])
    assert describe_tool(np.array(twist, dtype=float), point, 1.0, share) == words


def test_direction_near_an_axis_has_its_name() -> None:
    assert direction_words(np.array([0.0, -3.0, 0.1])) == "y"
    assert direction_words(np.array([0.0, -3.0, 1.0])) == "(0, 0.95, -0.32)"


def test_energy_in_words() -> None:
    shares = {"leg": 0.62, "foot": 0.2, "drive": 0.12, "rod": 0.06}
    assert describe_energy(shares) == "leg stores 62 % of the strain energy, foot 20 %, drive 12 %"
    assert describe_energy({"a": 0.05, "b": 0.04}) == "a stores 5 % of the strain energy"
    # Equal shares differ by rounding; words must not.
    tied = {"b": 0.5 + 1e-12, "a": 0.5 - 1e-12}
    assert describe_energy(tied) == "a stores 50 % of the strain energy, b 50 %"
    assert describe_energy({}) == ""


def test_a_matrix_on_which_the_fast_algorithm_fails_is_solved_by_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """LAPACK's gesdd gives up on some rare matrices."""
    expected = analyse_modes(load_robot("five-bar")).frequencies_hz
    tried = []

    def svd(A: NDArray[np.float64], *, lapack_driver: str = "gesdd", **rest: Any) -> Any:
        tried.append(lapack_driver)
        if lapack_driver == "gesdd":
            raise LinAlgError("SVD did not converge")
        return scipy.linalg.svd(A, lapack_driver=lapack_driver, **rest)

    monkeypatch.setattr("stiffkit.vibration.modes.svd", svd)
    found = analyse_modes(load_robot("five-bar")).frequencies_hz
    assert tried == ["gesdd", "gesvd"]
    np.testing.assert_allclose(found, expected, rtol=1e-12)
