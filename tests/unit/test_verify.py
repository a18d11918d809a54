"""Verifying a posture: what is compared, what is refused, and the pieces that it is made of."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import block_array, coo_array, csr_array, eye_array, tril

pytest.importorskip("netgen.occ")

import verify_robots as robots  # type: ignore[import-not-found]
from fea_parts import STEEL, ends, mesh, part  # type: ignore[import-not-found]

from stiffkit.errors import CadError, PoseError
from stiffkit.fea import SolveSettings
from stiffkit.fea.discretisation import Discretisation, node_count
from stiffkit.fea.elasticity import Elasticity
from stiffkit.fea.factor import Factor
from stiffkit.robot import Robot, load_robot
from stiffkit.spatial import Frame, exp_rotation
from stiffkit.verify import Compared, Resolution, verify_postures
from stiffkit.verify.fit import Placed, find_gaps, find_overlaps


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the parts, and a cache of its own."""
    folder = tmp_path_factory.mktemp("verify")
    robots.make_parts(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        yield folder


@pytest.fixture(scope="module")
def five_bar(folder: Path) -> Robot:
    robot: Robot = robots.robot(folder, robots.FIVE_BAR, "clamped", "average")
    return robot


# --- pieces ---------------------------------------------------------------------------------------


def test_a_quasi_definite_matrix_is_factorised_from_its_lower_triangle() -> None:
    rng = np.random.default_rng(1)
    A = csr_array(rng.standard_normal((40, 40)) * (rng.random((40, 40)) < 0.2))
    C = csr_array(rng.standard_normal((6, 40)))
    whole = block_array([[A @ A.T + eye_array(40), C.T], [C, -1e-3 * eye_array(6)]], format="csr")
    load = rng.standard_normal(46)
    x = Factor(coo_array(tril(whole))).solve(load)
    np.testing.assert_allclose(whole @ x, load, atol=1e-10)


@pytest.mark.parametrize(
    "settings",
    [
        SolveSettings(1),
        SolveSettings(3),
        SolveSettings(3, np.r_[np.full(5, 3), np.full(1000, 2)].astype(np.intp)),
    ],
)
def test_a_part_s_matrices_are_those_that_links_are_solved_with(settings: SolveSettings) -> None:
    bar, meshed = part("beam", length=50.0), mesh("beam", 0.01, length=50.0)
    if settings.orders is not None:
        settings = replace(settings, orders=settings.orders[: len(meshed.tets)])
    (base, tip) = ends(bar)
    ours = Discretisation(meshed, [STEEL], settings)
    other = Elasticity(meshed, [STEEL], settings, held_faces=base.faces)
    assert ours.n_nodes == other.n_nodes == node_count(meshed, settings)
    field = np.random.default_rng(0).standard_normal((ours.n_nodes, 3, 1))
    forces = ours.stiffness() @ field[:, :, 0].T.ravel()
    np.testing.assert_allclose(
        forces, other.apply_stiffness(field)[:, :, 0].T.ravel(), atol=1e-9 * np.abs(forces).max()
    )
    motions = ours.rigid_motions(tip.point)
    assert np.abs(ours.stiffness() @ motions).max() < 1e-9 * np.abs(forces).max()
    np.testing.assert_allclose(ours.reading(tip) @ motions, np.eye(6), atol=1e-9)
    mass = motions.T @ ours.mass() @ motions
    assert mass[0, 0] == pytest.approx(STEEL.density * bar.volume, rel=1e-9)


def placed(T_world_part: Frame) -> Placed:
    bar = part("beam", length=50.0)
    ports = {port.name: port for port in ends(bar)}
    return Placed(bar, ports, T_world_part, mesh("beam", 0.01, length=50.0))


def joint_of(first: Frame, second: Frame) -> tuple[list[str], list[str]]:
    """Gaps and overlaps, in words, of two bars of 50 x 10 x 10 mm, the tip of one on the other."""
    robot = load_robot("five-bar")
    elbow = robot.joints["elbow_left"]
    both = {elbow.from_body: placed(first), elbow.to_body: placed(second)}
    gaps = find_gaps([elbow], both)
    return [g.describe() for g in gaps], [o.describe() for o in find_overlaps([elbow], both)]


def test_bars_that_meet_fit() -> None:
    assert joint_of(Frame(), Frame.at(0.05)) == ([], [])
    turned = Frame(exp_rotation([0.0, 0.0, 1.0]), np.array([0.05, 0.0, 0.0]))
    assert joint_of(Frame(), turned) == ([], [])


def test_a_gap_is_measured_and_named() -> None:
    gaps, overlaps = joint_of(Frame(), Frame.at(0.057, 0.0, 0.002))
    assert gaps == [
        "joint elbow_left: the interfaces left_arm.tip and left_rod.base are 7 mm apart"
    ]
    assert overlaps == []


def test_parts_that_overlap_away_from_their_joint_are_named() -> None:
    crossing = Frame(exp_rotation([0.0, 0.0, np.pi / 2]), np.array([0.025, -0.025, 0.0]))
    gaps, overlaps = joint_of(Frame(), crossing)
    assert len(gaps) == len(overlaps) == 1
    assert overlaps[0].startswith("left_arm and left_rod overlap: ")
    depth = float(overlaps[0].split(": ")[1].split(" mm")[0])
    assert 1.0 < depth <= 5.0


def test_the_difference_is_split() -> None:
    one = Compared("x,x", reduced=1.02, same_meshes=1.001, whole=1.0)
    assert one.difference == pytest.approx(0.02)
    assert one.modelling == pytest.approx(0.001)
    assert one.discretisation == pytest.approx(0.019)


# --- a posture ------------------------------------------------------------------------------------


def test_the_meshes_share_is_told_from_the_model_s(five_bar: Robot) -> None:
    # Rods fold back on their arms there, and the links' own meshes are of order 2.
    at, other = {"x": 0.01, "y": 0.1}, Resolution(0.03, 3)
    found = verify_postures(five_bar, [at], n_modes=2, resolution=other, allow_overlap=True)
    (posture,) = found.postures
    names = [one.name for one in posture.elements]
    # The robot is symmetric to its plane, so nothing couples motions in it with those out of it.
    assert {"x,x", "x,y", "y,rz", "z,rx"} <= set(names)
    assert not {"x,z", "y,z", "z,rz"} & set(names)
    largest = posture.largest
    assert largest["compliance"] > 1e-3
    assert largest["compliance_modelling"] < 1e-7
    assert largest["frequencies_modelling"] < 1e-3
    assert [(p.links, p.order, p.own_mesh) for p in found.parts] == [
        (("left_arm", "right_arm"), 3, False),
        (("left_rod", "right_rod"), 3, False),
    ]
    # Four bars, and the held directions of five joints: 5 + 2 x 6 - 1, and so on.
    assert found.n_unknowns > 2 * sum(p.unknowns for p in found.parts) - 4 * 300
    assert "left_arm and left_rod overlap" in posture.notes[0]

    plain = json.loads(json.dumps(found.as_json(), allow_nan=False))
    assert plain["parts"][0]["links"] == ["left_arm", "right_arm"]
    (told,) = plain["postures"]
    assert told["elements"][0]["name"] == "x,x"
    assert len(told["frequencies"]) == 2


# --- what is refused ------------------------------------------------------------------------------


def test_links_that_are_not_given_by_cad_are_named() -> None:
    with pytest.raises(
        CadError, match=r"left_arm \(beam\), left_rod \(beam\), right_arm"
    ) as caught:
        verify_postures(load_robot("five-bar"))
    assert "by 'cad'" in caught.value.mend


def test_postures_without_a_compliance_are_told_as_pose_tells_them(
    five_bar: Robot, folder: Path
) -> None:
    with pytest.raises(PoseError, match="unreachable: the assembly mode of the home posture"):
        verify_postures(five_bar, [{"y": 0.6}])
    with pytest.raises(PoseError, match=r"unreachable at x=0.01,y=0.6: the assembly mode"):
        verify_postures(five_bar, [{}, {"x": 0.01, "y": 0.6}])
    text = robots.FIVE_BAR.replace("to: right_arm.base, drive: 2e4", "to: right_arm.base")
    free = robots.robot(folder, text, "clamped", "average")
    with pytest.raises(PoseError, match="uncontrolled: the robot does not hold its tool"):
        verify_postures(free)


def test_overlap_is_an_error_unless_it_is_allowed(five_bar: Robot) -> None:
    with pytest.raises(CadError, match="left_arm and left_rod overlap") as caught:
        verify_postures(five_bar, [{"y": 0.1}], resolution=Resolution(0.05, 1))
    assert "--allow-overlap" in caught.value.mend
