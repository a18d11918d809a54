"""Links with more than two ports against the same bodies made of links with two."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.compiled import Backend
from stiffkit.kinematics import Kinematics, Status
from stiffkit.network import LinkPart, build_network, reduce_network
from stiffkit.robot import DIRECTIONS, Link, Robot, load_robot
from stiffkit.spatial import Frame, axis_rotation
from stiffkit.stiffness import Stiffness, full_matrices
from stiffkit.vibration import Discretisation, FastModes, ModalModel, draw_modes

from .condensed import LEFT, RIGHT, condensed, sprung, with_superelements

Array = NDArray[np.float64]

ALL_MODES = Discretisation(n_modes=None)

SWING = """\
robot: Swing on a wall
links:
  stem: {beam: {length: 120 mm, section: {round: 12 mm}, material: steel}}
  bar: {beam: {length: 200 mm, section: {rectangle: [8 mm, 14 mm]}, material: steel}}
  arm: {beam: {length: 160 mm, section: {round: 14 mm}, material: aluminium}}
  rod: {beam: {length: 180 mm, section: {round: 10 mm}, material: steel}}
  hand: {rigid: {length: 40 mm}, mass: 1 kg}
joints:
  motor: {revolute: z, from: base, to: stem.base, drive: 4e4 N m/rad}
  weld: {fixed: true, from: stem.base, at: [0, 10 mm, 0], rotate: {z: 70 deg}, to: bar.base}
  elbow: {revolute: z, from: stem.tip, to: arm.base, elastic: {z: 1e7 N/m}}
  knee: {revolute: z, from: bar.tip, to: rod.base}
  wrist: {revolute: z, from: arm.tip, to: hand, drive: 2e4 N m/rad}
  pin: {revolute: z, from: rod.tip, to: hand.tip, elastic: {z: 5e6 N/m, rx: 2e3 N m/rad}}
tool: {at: hand.tip, mass: 2 kg}
home: {motor: 5 deg, elbow: 50 deg, knee: -80 deg, wrist: 10 deg}
"""


@cache
def swing(folder: Path) -> Robot:
    path = folder / "swing.yaml"
    path.write_text(SWING)
    return with_superelements(load_robot(path))


@cache
def orthoglide() -> tuple[Robot, Robot]:
    """Return the catalogue's Orthoglide, and the same with whole axles for its six pairs."""
    robot = with_superelements(load_robot("orthoglide"))
    whole = robot
    for k in (1, 2, 3):
        for weld in (f"near_axle_{k}", f"far_axle_{k}"):
            whole = condensed(whole, weld)
    return robot, whole


def unit_free_difference(found: Array, asked: Array) -> float:
    """Return the largest difference of two compliances, over the diagonal."""
    size = np.sqrt(np.diag(asked))
    return float(np.max(np.abs(found - asked) / np.outer(size, size)))


def compliance_and_frequencies(robot: Robot, values: Array) -> tuple[Array, Array]:
    """Return compliances (N, 6, 6) by the general assembly, and frequencies (N, 10)."""
    kinematics = Kinematics(robot)
    postures = kinematics.solve(values)
    assert postures.reached.all()
    stiffness = Stiffness(kinematics)
    modal = ModalModel(kinematics.tree, kinematics.length, ALL_MODES)
    compliances, frequencies = [], []
    for q in postures.coordinates.T:
        found = stiffness.assembly.at(q)
        assert found.compliance is not None
        compliances.append(found.compliance)
        frequencies.append(modal.at(q, 10).frequencies_hz)
    return np.array(compliances), np.array(frequencies)


def assert_alike(first: Robot, second: Robot, values: Array) -> None:
    (k, f), (other_k, other_f) = (compliance_and_frequencies(r, values) for r in (first, second))
    assert max(unit_free_difference(*pair) for pair in zip(other_k, k, strict=True)) < 1e-9
    np.testing.assert_allclose(other_f, f, rtol=1e-9)


def test_whole_axles_are_the_halves_of_the_orthoglide() -> None:
    halves, whole = orthoglide()
    assert len(whole.links) == len(halves.links) - 6
    assert whole.links["near_left_1"].other_ports == (LEFT, RIGHT)
    # Home, the corners of the workspace on the diagonal where it is nearly singular, off centre.
    values = np.array(
        [[0.0, 0.1265, -0.0735, 0.03], [0, 0.1265, -0.0735, -0.05], [0, 0.1265, -0.0735, 0.08]]
    )
    assert_alike(halves, whole, values)


@cache
def sprung_axles() -> tuple[Robot, Robot]:
    """Return the Orthoglide with springs below four of its axles, apart from them and inside."""
    _, robot = orthoglide()
    apart, within = robot, robot
    rng = np.random.default_rng(1)
    size = np.sqrt(np.diag(np.asarray(robot.links["near_left_1"].compliance)[:6, :6]))
    for name in ("near_left_1", "far_left_1", "far_left_2", "near_left_3"):
        root = size[:, None] * rng.normal(size=(6, 6))
        apart, _ = sprung(apart, name, root @ root.T)
        _, within = sprung(within, name, root @ root.T)
    return apart, within


def test_what_all_ports_share_couples_them() -> None:
    apart, within = sprung_axles()
    compliance = within.links["near_left_1"].compliance
    assert compliance is not None
    assert np.abs(compliance[:6, 6:]).max() > 0.1 * compliance[:6, :6].max()
    values = np.array([[0.0, 0.1, -0.06, 0.03], [0.0, 0.1, -0.06, -0.05], [0.0, 0.1, -0.06, 0.08]])
    assert_alike(apart, within, values)


@pytest.mark.parametrize("backend", ["numpy", "heyoka"])
def test_chains_between_whole_axles_stay_on_the_fast_path(backend: Backend) -> None:
    if backend == "heyoka":
        pytest.importorskip("heyoka")
    stiffness = Stiffness(Kinematics(sprung_axles()[1]), backend=backend)
    assert stiffness.method == "composition"
    rng = np.random.default_rng(2)
    postures = stiffness.kinematics.solve(rng.uniform(-0.07, 0.12, (3, 20)))
    found = full_matrices(stiffness.at(postures).lower)
    exact = stiffness.assembly.at_each(postures.coordinates)
    for n, assembled in enumerate(exact):
        assert assembled.compliance is not None
        assert unit_free_difference(found[..., n], assembled.compliance) < 1e-9


def test_singular_postures_are_told_alike() -> None:
    """The fast path of the halves against that of whole axles; at L / sqrt(3) all bars are flat."""
    values = np.array([-0.1, 0.0, 0.31 / np.sqrt(3.0)]) * np.ones((3, 1))
    for robot in orthoglide():
        stiffness = Stiffness(Kinematics(robot))
        assert stiffness.method == "composition"
        found = stiffness.at(stiffness.kinematics.solve(values)).status
        assert found.tolist() == [Status.OK, Status.OK, Status.SINGULAR]


def test_the_fast_model_of_vibration_knows_coupled_links() -> None:
    _, whole = sprung_axles()
    kinematics = Kinematics(whole)
    rng = np.random.default_rng(0)
    q = kinematics.solve(rng.uniform(-0.06, 0.06, (3, 24))).coordinates
    full = ModalModel(kinematics.tree, kinematics.length, ALL_MODES)
    fast = FastModes(full, q[:, :20], 4)
    assert fast.trust.good
    exact = np.array([full.at(x, 4).frequencies_hz for x in q[:, 20:].T]).T
    np.testing.assert_allclose(fast.frequencies(q[:, 20:]), exact, rtol=1e-4)


@pytest.fixture
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.getbasetemp()


def test_a_bent_lever_is_its_two_beams(folder: Path) -> None:
    """Their bases lie apart, their axes are turned, and springs stand beside them."""
    robot = swing(folder)
    lever = condensed(robot, "weld")
    assert lever.links["stem"].other_ports == (LEFT, RIGHT)
    kinematics = Kinematics(robot)
    at_home = np.array([kinematics.home.tool[DIRECTIONS.index(d)] for d in kinematics.asked])
    assert_alike(robot, lever, at_home + 0.002 * np.array([[0.0, -1.0, 0.3], [0.0, -0.5, -1.0]]))


def with_spare_port(link: Link) -> Link:
    """Return a link with a third port that bends with its tip, and by itself."""
    assert link.compliance is not None
    rng = np.random.default_rng(5)
    root = np.linalg.cholesky(link.compliance)
    coupling = 0.4 * rng.normal(size=(6, 6))
    spare = root @ (coupling @ coupling.T + np.eye(6)) @ root.T
    mixed = root @ coupling.T @ root.T
    ports = {
        "base": Frame(),
        "spare": Frame(axis_rotation("y", 0.3), np.array([0.05, 0.02, 0.0])),
        "tip": link.ports["tip"],
    }
    compliance = np.block([[spare, mixed.T], [mixed, link.compliance]])
    return replace(link, ports=ports, compliance=compliance, line=None, mass=None)


def test_a_port_that_nothing_uses_changes_nothing() -> None:
    """The network leaves it out, and the robot stays on the fast path."""
    robot = load_robot("five-bar")
    links = {
        name: replace(link, line=None, mass=None) if link.compliance is not None else link
        for name, link in robot.links.items()
    }
    plain = replace(robot, links=links)
    spare = replace(robot, links={**links, "left_rod": with_spare_port(links["left_rod"])})
    values = np.array([[0.0, 0.1, -0.1], [0.4, 0.35, 0.42]])
    methods, lowers = [], []
    for one in (plain, spare):
        stiffness = Stiffness(Kinematics(one))
        methods.append(stiffness.method)
        postures = stiffness.kinematics.solve(values)
        lowers.append(stiffness.at(postures).lower)
        general = Stiffness(stiffness.kinematics)
        general._function = None
        lowers.append(general.at(postures).lower)
    assert methods == ["composition", "composition"]
    for found in lowers[1:]:
        np.testing.assert_allclose(found, lowers[0], atol=1e-9 * np.abs(lowers[0]).max())


def test_ports_that_only_the_link_itself_ties_are_coupled() -> None:
    """A bar between two ports of a link stiffens its third: it may not be left out."""
    robot = load_robot("five-bar")
    link = with_spare_port(robot.links["left_rod"])
    joints = dict(robot.joints)
    joints["brace"] = replace(
        joints["elbow_left"],
        name="brace",
        from_body="left_rod",
        from_port="spare",
        T_from_joint=link.ports["spare"],
        to_body="left_rod",
        to_port="base",
        T_to_joint=Frame(),
    )
    braced = replace(robot, links={**robot.links, "left_rod": link}, joints=joints)
    assert reduce_network(build_network(replace(braced, joints=robot.joints))) is not None
    assert reduce_network(build_network(braced)) is None
    parts = {edge.part for edge in build_network(braced).edges}
    assert {LinkPart("left_rod", "spare"), LinkPart("left_rod", "tip")} <= parts


def test_modes_are_drawn_to_every_port() -> None:
    _, whole = orthoglide()
    kinematics = Kinematics(whole)
    model = ModalModel(kinematics.tree, kinematics.length, ALL_MODES)
    q = kinematics.home.coordinates[:, 0]
    drawing = draw_modes(model, q, model.at(q, 2))
    (axle,) = (link for link in drawing.links if link.name == "near_left_1")
    ends = [path.rest[[0, -1]] for path in axle.paths[:2]]
    # Both lines begin at the base, in the middle, and end half of d = 100 mm away from it.
    np.testing.assert_allclose(ends[0][0], ends[1][0], atol=1e-9)
    np.testing.assert_allclose(ends[0][1] - ends[0][0], ends[1][0] - ends[1][1], atol=1e-9)
    assert np.linalg.norm(ends[0][1] - ends[0][0]) == pytest.approx(0.05)


def test_without_a_superelement_the_mass_goes_along_with_the_base() -> None:
    robot = load_robot("five-bar")
    link = replace(with_spare_port(robot.links["left_rod"]), mass=2.0)
    heavy = replace(robot, links={**robot.links, "left_rod": link})
    kinematics = Kinematics(heavy)
    bodies = ModalModel(kinematics.tree, kinematics.length).bodies
    assert "left_rod" in bodies.rigid
    assert np.trace(bodies.rigid["left_rod"][:3, :3]) == pytest.approx(6.0)
