"""What the studio draws: outlines, meshes, solids of every robot, and how they move."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from stiffkit.kinematics import Kinematics
from stiffkit.link import (
    Outline,
    Section,
    box,
    equivalent_outline,
    rectangle,
    round_bar,
    tube,
)
from stiffkit.robot import BASE, Freedom, Link, load_robot
from stiffkit.robot.catalogue import describe_robots
from stiffkit.spatial import Frame, exp_rotation
from stiffkit.stiffness import PrincipalAxes
from stiffkit.studio.ellipsoid import LONGEST, ellipsoid
from stiffkit.studio.link_solids import link_solids
from stiffkit.studio.mesh import Mesh, rounded_hull, sweep, unit_ball
from stiffkit.studio.seats import Seats
from stiffkit.studio.solid import Follow, Ride
from stiffkit.studio.solids import Anatomy, suggested_scale
from stiffkit.studio.strokes import strokes
from stiffkit.studio.thinning import thinned
from stiffkit.verify.places import Places as KernelPlaces
from stiffkit.vibration import ModalModel, Moving
from stiffkit.vibration.curve import bent_twists

Array = NDArray[np.float64]

ROBOTS = [robot.name for robot in describe_robots() if not robot.from_cad]

SECTIONS = {
    "round": round_bar(0.03),
    "tube": tube(0.04, 0.004),
    "rectangle": rectangle(0.02, 0.05),
    "box": box(0.04, 0.06, 0.003),
}


@cache
def kinematics_of(name: str) -> Kinematics:
    return Kinematics(load_robot(name), backend="numpy")


def home_of(name: str) -> Array:
    return np.asarray(kinematics_of(name).home.coordinates[:, 0])


@cache
def anatomy_of(name: str) -> Anatomy:
    return Anatomy.of(kinematics_of(name).tree, home_of(name))


@cache
def modes_of(name: str) -> tuple[ModalModel, Array, Array]:
    """The model, shapes of three modes, and the tool's twists in them."""
    kinematics = kinematics_of(name)
    model = ModalModel(kinematics.tree, kinematics.length, backend="numpy")
    modes = model.at(home_of(name), 3)
    return model, modes.shapes, modes.tool


def moving_at_home(name: str) -> Moving:
    model, shapes, _ = modes_of(name)
    return Moving(model, anatomy_of(name).places(home_of(name)), home_of(name), shapes)


# Outlines.


def properties(corners: Array) -> Array:
    """Area and second moments about y and z (the polygon formulas), zero without corners."""
    if not len(corners):
        return np.zeros(3)
    (y, z), (v, w) = corners.T, np.roll(corners, -1, axis=0).T
    cross = y * w - v * z
    return np.array(
        [
            cross.sum() / 2.0,
            (cross * (z**2 + z * w + w**2)).sum() / 12.0,
            (cross * (y**2 + y * v + v**2)).sum() / 12.0,
        ]
    )


def check_properties(outline: Outline, section: Section) -> None:
    found = properties(outline.edge(2000)) - properties(outline.hole(2000))
    assert found == pytest.approx(np.array([section.area, section.Iy, section.Iz]), rel=2e-5)


@pytest.mark.parametrize("name", SECTIONS)
def test_outline_has_the_section_s_properties(name: str) -> None:
    section = SECTIONS[name]
    assert not section.outline.is_equivalent
    check_properties(section.outline, section)


@pytest.mark.parametrize("name", SECTIONS)
def test_equivalent_outline_is_the_section_itself(name: str) -> None:
    section = SECTIONS[name]
    only_numbers = Section(section.area, section.Iy, section.Iz, section.torsion).outline
    assert only_numbers.is_equivalent
    assert only_numbers.shape == section.outline.shape
    assert only_numbers.width == pytest.approx(section.outline.width, rel=0.05)
    check_properties(only_numbers, section)


@given(st.floats(1e-3, 1.0), st.floats(1e-3, 1.0), st.floats(0.02, 0.9), st.booleans())
@settings(max_examples=50, deadline=None)
def test_equivalent_outline_has_the_properties_that_it_stands_for(
    width: float, height: float, share: float, is_round: bool
) -> None:
    section = (
        tube(width, share * width / 2.0)
        if is_round
        else box(width, height, share * min(width, height) / 2.0)
    )
    check_properties(
        equivalent_outline(section.area, section.Iy, section.Iz, section.torsion), section
    )


def test_numbers_that_no_section_has_give_an_outline_all_the_same() -> None:
    outline = equivalent_outline(1.0, 1e-6, 1e-6, 1e-6)
    assert outline.shape == "ellipse"
    assert not outline.is_hollow
    assert outline.width > 0.0


# Meshes.


@pytest.mark.parametrize("name", SECTIONS)
def test_swept_section_is_closed_and_has_its_volume(name: str) -> None:
    outline = SECTIONS[name].outline
    mesh = sweep(outline, np.linspace(0.1, 0.8, 5))
    area = (properties(outline.edge()) - properties(outline.hole()))[0]
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(0.7 * area, rel=1e-12)
    # Of the true section 24 corners leave out a little.
    assert mesh.volume == pytest.approx(0.7 * SECTIONS[name].area, rel=0.012)
    moved = mesh.placed(Frame(exp_rotation([0.3, -1.0, 0.2]), np.array([5.0, -3.0, 1.0])))
    assert moved.volume == pytest.approx(mesh.volume, rel=1e-9)


def test_open_and_inside_out_meshes_are_found() -> None:
    ball = unit_ball(1)
    assert not Mesh(ball.vertices, ball.faces[1:]).is_closed
    one_turned = np.concatenate([ball.faces[:1, ::-1], ball.faces[1:]])
    assert not Mesh(ball.vertices, one_turned).is_closed
    inside_out = Mesh(ball.vertices, ball.faces[:, ::-1])
    assert inside_out.is_closed
    assert inside_out.volume == pytest.approx(-ball.volume)


def test_ball_becomes_rounder() -> None:
    volumes = [unit_ball(n).volume for n in range(4)]
    assert all(unit_ball(n).is_closed for n in range(4))
    gaps = 4.0 / 3.0 * np.pi - np.array(volumes)
    assert np.all(gaps > 0.0)
    assert gaps[1:] / gaps[:-1] == pytest.approx(np.full(3, 0.25), abs=0.08)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6])
def test_hull_around_points_is_closed_and_holds_them(n: int) -> None:
    points = np.vstack([np.eye(3), np.zeros((1, 3)), -np.eye(3)])[:n]
    mesh = rounded_hull(points, [0.1, 0.1, 0.05], exp_rotation([0.4, 0.1, -0.7]))
    assert mesh.is_closed
    inside = unit_ball(1).volume * 0.1 * 0.1 * 0.05
    assert mesh.volume > (0.999 if n == 1 else 2.0) * inside
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    normals = np.cross(b - a, c - a)
    assert np.all(np.einsum("fi,fpi->fp", normals, points[None] - a[:, None]) < 1e-12)


def test_thinned_surface_keeps_its_shape_and_knows_its_vertices() -> None:
    fine = unit_ball(6)
    assert len(fine.faces) > 20_000
    mesh, kept = thinned(fine)
    assert 10_000 < len(mesh.faces) <= 20_000
    assert np.array_equal(mesh.vertices, fine.vertices[kept])
    assert mesh.volume == pytest.approx(fine.volume, rel=0.01)
    coarse, all_kept = thinned(unit_ball(2))
    assert coarse is unit_ball(2)
    assert np.array_equal(all_kept, np.arange(162))


# Every robot.


@pytest.mark.parametrize("name", ROBOTS)
def test_solids_are_whole(name: str) -> None:
    anatomy = anatomy_of(name)
    robot = kinematics_of(name).robot
    for solid in anatomy.solids:
        assert solid.mesh.is_closed, solid.name
        assert solid.mesh.volume > 0.0, solid.name
        assert solid.body == BASE or solid.body in robot.links
    names = [solid.name for solid in anatomy.solids]
    assert len(set(names)) == len(names)
    drawn = {solid.body for solid in anatomy.solids if solid.role == "link"}
    assert drawn == set(robot.links)
    driven = [j.name for j in robot.joints.values() if Freedom.DRIVEN in j.freedoms]
    assert {f"drive {joint}" for joint in driven} <= set(names)
    assert names.count("tool") == 1


@pytest.mark.parametrize("name", ROBOTS)
def test_places_are_those_of_the_kernels(name: str) -> None:
    q = home_of(name)
    places, kernels = anatomy_of(name).places(q), KernelPlaces(kinematics_of(name).tree, q)
    for body, frame in kernels.body.items():
        assert places.body[body].position == pytest.approx(frame.position, abs=1e-12)
        assert places.body[body].rotation == pytest.approx(frame.rotation, abs=1e-12)
    assert places.tool.position == pytest.approx(kernels.tool.position, abs=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_neighbouring_bodies_meet_at_their_joints(name: str) -> None:
    kinematics = kinematics_of(name)
    places = anatomy_of(name).places(home_of(name))
    for joint in kinematics.robot.joints.values():
        apart = places.from_side(joint).inverse.point(places.to_side(joint).position)
        for i, axis in enumerate("xyz"):
            if axis not in joint.motions:
                assert apart[i] == pytest.approx(0.0, abs=1e-9 * kinematics.length)


# What is drawn where.


def solid_of(name: str, solid: str) -> tuple[Array, Array]:
    """Lowest and highest coordinates of a solid in its body's frame."""
    (found,) = (s for s in anatomy_of(name).solids if s.name == solid)
    return found.vertices.min(axis=0), found.vertices.max(axis=0)


def test_slide_is_drawn_where_its_carriage_carries_the_leg() -> None:
    robot = load_robot("orthoglide")
    mount = robot.joints["mount_1"].T_from_joint.position
    assert np.linalg.norm(mount) > 0.3
    low, high = solid_of("orthoglide", "drive drive_1")
    assert (low + high) / 2.0 == pytest.approx(mount, abs=1e-12)


def test_guide_reaches_as_far_as_the_postures_do() -> None:
    kinematics = kinematics_of("biglide")
    home = home_of("biglide")
    column = next(t.coordinates.start for t in kinematics.tree.joints if t.joint.name == "slide_2")
    postures = np.tile(home[:, None], 4)
    postures[column] = [-1.3, 0.4, -0.2, np.nan]
    anatomy = Anatomy.of(kinematics.tree, home, postures)
    (guide,) = (s for s in anatomy.solids if s.name == "drive slide_2 guide")
    assert guide.role == "base"
    y = guide.vertices[:, 1]
    assert y.min() < -1.3
    assert y.max() > 0.4
    assert y.max() - y.min() < 1.7 + 0.3


def test_strokes_of_joints_that_close_loops() -> None:
    anatomy = anatomy_of("biglide")
    kinematics = kinematics_of("biglide")
    found = strokes(anatomy._locator, home_of("biglide")[:, None])
    at_home = dict(zip(kinematics.joint_names, kinematics.home.joints[:, 0], strict=True))
    assert set(found) == {"slide_1", "slide_2"}
    for name, (low, high) in found.items():
        assert low == high == pytest.approx(at_home[f"{name}.y"], abs=1e-12)


def test_unknown_shapes_are_flagged() -> None:
    flags = {s.name: (s.elastic, s.is_equivalent) for s in anatomy_of("biglide").solids}
    assert flags["link leg_1"] == (True, True)
    assert flags["link foot_1"] == (True, True)
    flags = {s.name: (s.elastic, s.is_equivalent) for s in anatomy_of("five-bar").solids}
    assert flags["link left_arm"] == (True, False)
    assert flags["tool"] == (False, False)
    flags = {s.name: (s.elastic, s.is_equivalent) for s in anatomy_of("orthoglide").solids}
    assert flags["link bar_left_1"] == (True, True)
    assert flags["link platform"] == (False, False)


def test_link_with_several_ports_is_a_star() -> None:
    ports = {BASE: Frame(), "left": Frame.at(0.2, 0.1), "right": Frame.at(0.2, -0.1)}
    link = Link("fork", ports, compliance=1e-8 * np.eye(12))
    solids = list(link_solids(link, [], None, 0.01))
    assert [solid.name for solid in solids] == ["link fork, left", "link fork, right"]
    for solid, port in zip(solids, ("left", "right"), strict=True):
        tip = ports[port].position
        along = solid.vertices @ tip / np.linalg.norm(tip)
        assert along.max() == pytest.approx(np.linalg.norm(tip))


def test_seats_of_a_robot_without_slides_are_its_joints() -> None:
    seats = Seats.of(load_robot("delta"))
    assert all(not offset.any() for offset in seats.offset.values())
    assert len(seats.of_body["platform"]) == 6


# Motion.


def test_sections_of_a_bent_line_are_exact_for_a_cantilever() -> None:
    along = np.array([1.0, 0.0, 0.0])
    length, x = 2.0, np.array([0.0, 0.5, 1.3, 2.0])
    twists = np.zeros((2, 6, 1))
    twists[1, :, 0] = [0.1, length**3 / 3.0, 0.0, 0.4, 0.0, length**2 / 2.0]
    found = bent_twists(np.array([0.0, length]), twists, along, x / length)[..., 0]
    assert found[:, 1] == pytest.approx(x**2 * (3.0 * length - x) / 6.0)
    assert found[:, 5] == pytest.approx(length * x - x**2 / 2.0)
    assert found[:, 0] == pytest.approx(0.1 * x / length)
    assert found[:, 3] == pytest.approx(0.4 * x / length)


def test_sections_of_a_rigidly_moved_line_move_rigidly() -> None:
    rng = np.random.default_rng(1)
    along = exp_rotation([0.2, -0.5, 1.0])[:, 0]
    t, w = rng.standard_normal((2, 3, 4))
    s = np.array([0.0, 0.2, 0.5, 0.7])
    at = np.linspace(0.0, 0.7, 9)
    twists = np.stack([np.vstack([t + np.cross(w.T, x * along).T, w]) for x in s])
    found = bent_twists(s, twists, along, at / 0.7)
    wanted = np.stack([np.vstack([t + np.cross(w.T, x * along).T, w]) for x in at])
    assert found == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("name", ["five-bar", "orthoglide", "biglide-elastic-tool"])
def test_ends_of_links_move_as_their_ports(name: str) -> None:
    anatomy, moving = anatomy_of(name), moving_at_home(name)
    model, shapes, _ = modes_of(name)
    robot = kinematics_of(name).robot
    moved = anatomy.displacements(model, home_of(name), shapes)
    checked = 0
    for solid, displacements in zip(anatomy.solids, moved, strict=True):
        assert displacements.shape == (3, len(solid.vertices), 3)
        if not solid.elastic:
            continue
        tip = robot.links[solid.body].ports["tip"].position
        if not tip.any():
            continue
        for port in (BASE, "tip"):
            end = robot.links[solid.body].ports[port].position
            near = np.abs((solid.vertices - end) @ tip) < 1e-9
            at = moving.places.body[solid.body].point(end)
            twist = moving.twist(solid.body, port, at)
            arms = moving.places.body[solid.body].rotation @ (solid.vertices[near] - end).T
            wanted = twist[:3].T[:, None] + np.cross(twist[3:].T[:, None], arms.T[None])
            # A section square to the line turns with it, but for what shear adds.
            spread = np.abs(wanted).max()
            assert displacements[:, near].mean(axis=1) == pytest.approx(
                wanted.mean(axis=1), abs=1e-9 * spread
            )
            assert displacements[:, near] == pytest.approx(wanted, abs=0.02 * spread)
            checked += 1
    assert checked >= 4


def test_rigid_platform_and_tool_move_with_the_tool() -> None:
    model, shapes, tool = modes_of("hexapod-cubic")
    anatomy = anatomy_of("hexapod-cubic")
    q = home_of("hexapod-cubic")
    at = anatomy.places(q).tool.position
    moved = anatomy.displacements(model, q, shapes)
    rest = anatomy.vertices(q)
    for solid, vertices, displacements in zip(anatomy.solids, rest, moved, strict=True):
        if solid.body == "platform":
            arms = vertices - at
            wanted = tool[:3].T[:, None] + np.cross(tool[3:].T[:, None], arms[None])
            assert displacements == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())
        if solid.body == BASE:
            assert not displacements.any()


def test_part_follows_its_ports() -> None:
    moving = moving_at_home("five-bar")
    link = moving.model.tree.robot.links["left_rod"]
    assert link.compliance is not None
    tip = link.ports["tip"].position
    # The base stands still in the field of a load, the tip moves as the compliance says.
    field = np.stack([np.zeros((3, 6)), link.compliance[:3]])
    moved = Follow(link, field).moved(moving, "left_rod", np.stack([np.zeros(3), tip]))
    for i, port in enumerate([BASE, "tip"]):
        at = moving.places.body["left_rod"].point(link.ports[port].position)
        assert moved[:, i] == pytest.approx(moving.twist("left_rod", port, at)[:3].T, rel=1e-9)
    riding = Ride(BASE).moved(moving, "left_rod", np.zeros((1, 3)))
    assert moved[:, :1] == pytest.approx(riding, rel=1e-9)


def test_suggested_scale_is_round_and_shows_what_moves() -> None:
    rng = np.random.default_rng(2)
    for exponent in np.linspace(-9.0, 1.0, 41):
        moved = 10.0**exponent * rng.standard_normal((2, 7, 3))
        scale = suggested_scale([moved[:, :3], moved[:, 3:]], 1.7)
        shown = scale * np.linalg.norm(moved, axis=-1).max() / 1.7
        assert 0.05 < shown < 0.13
        assert f"{scale:.0e}"[0] in "125"
        assert scale == pytest.approx(float(f"{scale:.0e}"), rel=1e-12)
    assert suggested_scale([np.zeros((1, 4, 3))], 1.0) == 1.0
    assert suggested_scale([], 1.0) == 1.0


# Ellipsoids.


def axes_of(stiffness: list[float]) -> PrincipalAxes:
    return PrincipalAxes(np.array(stiffness), exp_rotation([0.3, 0.9, -0.4]))


def test_ellipsoid_reaches_as_far_as_the_stiffness() -> None:
    axes = axes_of([1e6, 3e6, 2e7])
    found = ellipsoid(axes, reference=1e7, size=0.1)
    assert found.half_axes == pytest.approx(np.array([0.01, 0.03, 0.2]))
    assert not found.is_cut
    reach = np.abs(found.mesh.vertices @ axes.directions).max(axis=0)
    assert reach == pytest.approx(found.half_axes, rel=0.01)
    mirrored = PrincipalAxes(axes.stiffness, -axes.directions)
    for one in (found, ellipsoid(mirrored, 1e7, 0.1)):
        assert one.mesh.is_closed
        assert one.mesh.volume == pytest.approx(4.0 / 3.0 * np.pi * 6e-5, rel=0.02)


def test_ellipsoid_is_cut_where_it_would_be_a_needle() -> None:
    found = ellipsoid(axes_of([1e6, 2e6, np.inf]), reference=1e6, size=0.1)
    assert found.is_cut
    assert found.half_axes == pytest.approx(np.array([0.1, 0.2, 0.1 * LONGEST]))
    rigid = ellipsoid(axes_of([np.inf] * 3), reference=1e6, size=0.1)
    assert rigid.is_cut
    assert rigid.half_axes == pytest.approx(np.full(3, 0.1))
