"""Every feature of a robot file, against numbers worked out by hand."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from stiffkit.link.beam import beam_compliance, beam_inertia
from stiffkit.link.materials import MATERIALS
from stiffkit.link.sections import round_bar
from stiffkit.robot import Freedom, Robot, describe_robots, load_robot

Load = Callable[..., Robot]


def close(actual: ArrayLike | None, expected: object) -> None:
    assert actual is not None
    np.testing.assert_allclose(np.asarray(actual), np.asarray(expected), atol=1e-15)


FRAME = """
robot: Test
links: {{rod: {{rigid: {{length: 1}}}}}}
joints: {{slide: {{prismatic: x, from: base, to: rod{joint}}}}}
tool: {{at: rod.tip{tool}}}
{rest}
"""


def robot_text(joint: str = "", tool: str = "", rest: str = "") -> str:
    return FRAME.format(
        joint=f", {joint}" if joint else "", tool=f", {tool}" if tool else "", rest=rest
    )


def with_link(link: str, rest: str = "") -> str:
    return f"""
robot: Test
parameters: {{L: 300 mm, E: 70 GPa}}
links: {{part: {link}}}
joints: {{hold: {{fixed: true, from: base, to: part}}}}
tool: {{at: part}}
{rest}
"""


DIAGONAL = "[[2,0,0,0,0,0],[0,3,0,0,0,1],[0,0,4,0,-1,0],[0,0,0,5,0,0],[0,0,-1,0,6,0],[0,1,0,0,0,7]]"


def test_beam_link(load: Load) -> None:
    robot = load(with_link("{beam: {length: = 2*L, section: {round: 20 mm}, material: steel}}"))
    part = robot.links["part"]
    steel, section = MATERIALS["steel"], round_bar(0.02)
    mass, center, inertia = beam_inertia(0.6, section, steel)
    assert part.origin == "beam"
    assert list(part.ports) == ["base", "tip"]
    close(part.ports["tip"].position, [0.6, 0, 0])
    close(part.compliance, beam_compliance(0.6, section, steel))
    assert part.mass == pytest.approx(math.pi * 0.01**2 * 0.6 * 7850)
    assert part.mass == pytest.approx(mass)
    close(part.center_of_mass, center)
    close(part.inertia, inertia)


def test_beam_with_a_mass_of_its_own_keeps_its_shape(load: Load) -> None:
    beam = "beam: {length: 1 m, section: {round: 20 mm}, material: steel}"
    plain = load(with_link("{" + beam + "}")).links["part"]
    robot = load(with_link("{" + beam + ", mass: 1 kg, center_of_mass: [0.4, 0, 0]}"))
    heavy = robot.links["part"]
    assert plain.mass is not None
    assert plain.inertia is not None
    assert heavy.mass == 1.0
    close(heavy.center_of_mass, [0.4, 0, 0])
    close(heavy.inertia, plain.inertia / plain.mass)
    assert robot.notes == ("links.part: the beam's inertia is scaled to the given mass, "
                           f"{plain.mass:.6g} -> 1 kg",)  # fmt: skip


@pytest.mark.parametrize(
    ("section", "area", "Iy"),
    [
        ("{round: 20 mm}", math.pi * 1e-4, math.pi * 0.02**4 / 64),
        ("{tube: [40 mm, 4 mm]}", math.pi * (0.02**2 - 0.016**2), None),
        ("{rectangle: [10 mm, 20 mm]}", 2e-4, 0.01 * 0.02**3 / 12),
        ("{box: [40 mm, 60 mm, 5 mm]}", 40e-3 * 60e-3 - 30e-3 * 50e-3, None),
        ("{given: {area: 2 cm^2, Iy: 3e-8 m^4, Iz: 4e-8, torsion: 5e-8}}", 2e-4, 3e-8),
    ],
)
def test_sections(load: Load, section: str, area: float, Iy: float | None) -> None:
    link = f"{{beam: {{length: 1, section: {section}, material: aluminium}}}}"
    k = load(with_link(link)).links["part"].compliance
    assert k is not None
    assert k[0, 0] == pytest.approx(1 / (70e9 * area))
    if Iy is not None:
        # A force along z bends about y.
        assert k[4, 4] == pytest.approx(1 / (70e9 * Iy))


def test_given_section_bends_without_shear_unless_told(load: Load) -> None:
    given = "area: 2e-4, Iy: 3e-8, Iz: 4e-8, torsion: 5e-8"
    beam = "{{beam: {{length: 1, section: {{given: {{{}}}}}, material: aluminium}}}}"
    stiff = load(with_link(beam.format(given))).links["part"].compliance
    soft = load(with_link(beam.format(given + ", shear_y: 0.5"))).links["part"].compliance
    assert stiff is not None
    assert soft is not None
    G = MATERIALS["aluminium"].G
    assert stiff[1, 1] == pytest.approx(1 / (3 * 70e9 * 4e-8))
    assert soft[1, 1] - stiff[1, 1] == pytest.approx(1 / (0.5 * G * 2e-4))
    assert soft[2, 2] == stiff[2, 2]


def test_material_of_the_file(load: Load) -> None:
    robot = load(
        with_link(
            "{beam: {length: 2, section: {rectangle: [10 mm, 10 mm]}, material: wood}}",
            "materials: {wood: {E: = E / 7, nu: 0.3, density: 500 kg/m^3}}",
        )
    )
    part = robot.links["part"]
    assert part.compliance is not None
    assert part.compliance[0, 0] == pytest.approx(2 / (10e9 * 1e-4))
    assert part.mass == pytest.approx(0.1)


def test_rigid_link_with_ports_and_inertia(load: Load) -> None:
    part = load(
        with_link(
            "{rigid: {ports: {a: {at: [100 mm, 0, 0], rotate: {z: 90 deg}}, b: {}}}, mass: 3 kg,"
            " center_of_mass: [0, 0, 10 mm], inertia: [[3,0,0],[0,4,0],[0,0,5 kg m^2]]}"
        )
    ).links["part"]
    assert part.compliance is None
    assert list(part.ports) == ["base", "a", "b"]
    close(part.ports["a"].point([1, 0, 0]), [0.1, 1, 0])
    close(part.ports["b"].rotation, np.eye(3))
    close(part.inertia, np.diag([3, 4, 5]))
    close(part.center_of_mass, [0, 0, 0.01])


def test_rigid_link_may_place_its_base_port(load: Load) -> None:
    part = load(with_link("{rigid: {length: 1, ports: {base: {at: [0, 0, 50 mm]}}}}")).links["part"]
    close(part.ports["base"].position, [0, 0, 0.05])
    close(part.ports["tip"].position, [1, 0, 0])


def test_inertia_without_mass_is_allowed(load: Load) -> None:
    inertia = "[[3,0,0],[0,4,0],[0,0,5]]"
    part = load(with_link(f"{{rigid: {{length: 1}}, inertia: {inertia}}}")).links["part"]
    assert part.mass is None
    assert part.inertia is not None


def test_given_compliance_in_millimetres(load: Load) -> None:
    rows = "[[2e-5,0,0,0,0,0],[0,3e-5,0,0,0,1e-7],[0,0,4e-5,0,-1e-7,0],[0,0,0,5e-9,0,0]," \
        "[0,0,-1e-7,0,6e-9,0],[0,1e-7,0,0,0,7e-9]]"  # fmt: skip
    robot = load(with_link(f"{{compliance: {{matrix: {rows}, units: mm, length: = L}}}}"))
    k = robot.links["part"].compliance
    assert k is not None
    # mm/N, 1/N, rad/(N mm)
    assert k[1, 1] == pytest.approx(3e-8)
    assert k[1, 5] == k[5, 1] == pytest.approx(1e-7)
    assert k[5, 5] == pytest.approx(7e-6)
    close(robot.links["part"].ports["tip"].position, [0.3, 0, 0])
    assert robot.notes == ()


def test_entries_with_a_unit_and_expressions_keep_theirs(load: Load) -> None:
    matrix = DIAGONAL.replace("[[2,", "[[= L/(E*1e-4 m^2),").replace("7]]", "7 rad/(N mm)]]")
    k = load(with_link(f"{{compliance: {{matrix: {matrix}, length: 1}}}}")).links["part"].compliance
    assert k is not None
    assert k[0, 0] == pytest.approx(0.3 / 7e6)
    assert k[1, 1] == 3.0
    assert k[5, 5] == pytest.approx(7000)


def test_repairs_are_made_and_told(load: Load) -> None:
    broken = DIAGONAL.replace("[0,0,-1,0,6,0]", "[0,0,-1.5,0,6,0]").replace("0,7]]", "0,0.001]]")
    repair = 'repair: {symmetrize: true, entries: {"6,6": 8, "1,2": 0.5}}'
    robot = load(with_link(f"{{compliance: {{matrix: {broken}, length: 1, {repair}}}}}"))
    k = robot.links["part"].compliance
    assert k is not None
    assert k[5, 5] == 8.0
    assert k[0, 1] == k[1, 0] == 0.5
    assert k[2, 4] == k[4, 2] == -1.25
    assert robot.notes[:3] == (
        "links.part: compliance entry (6,6) replaced: 0.001 -> 8",
        "links.part: compliance entry (1,2) replaced: 0 -> 0.5",
        "links.part: compliance made symmetric: entries (3,5) = -1 and (5,3) = -1.5 differed most, "
        "their mean is -1.25",
    )


def test_repair_notes_are_in_the_units_of_the_file(load: Load) -> None:
    link = f"{{compliance: {{matrix: {DIAGONAL}, units: mm, length: 1, REPAIR}}}}"
    repaired = load(with_link(link.replace("REPAIR", 'repair: {entries: {"6,6": 9}}')))
    assert "links.part: compliance entry (6,6) replaced: 7 -> 9" in repaired.notes


def test_an_unlikely_unit_is_noted(load: Load) -> None:
    robot = load(with_link(f"{{compliance: {{matrix: {DIAGONAL}, length: 1}}}}"))
    assert any("another unit was probably meant" in note for note in robot.notes)


def test_compliance_with_a_turned_tip(load: Load) -> None:
    tip = "tip: {at: [= L, 0, 10 mm], rotate: {y: 90 deg}}"
    part = load(with_link(f"{{compliance: {{matrix: {DIAGONAL}, {tip}}}}}")).links["part"]
    close(part.ports["tip"].point([0, 0, 1]), [1.3, 0, 0.01])


def test_like_copies_and_further_keys_override(load: Load) -> None:
    robot = load(
        """
robot: Test
links:
  c: {like: b}
  b: {like: a, mass: 2 kg}
  d: {like: b, rigid: {length: 3}}
  a: {rigid: {length: 1}, mass: 1 kg, center_of_mass: [0.5, 0, 0]}
joints:
  j1: {revolute: z, from: base, to: a}
  j2: {revolute: z, from: a.tip, to: b}
  j3: {revolute: z, from: b.tip, to: c}
  j4: {revolute: z, from: c.tip, to: d}
tool: {at: d.tip}
"""
    )
    assert list(robot.links) == ["c", "b", "d", "a"]
    assert [link.mass for link in robot.links.values()] == [2, 2, 2, 1]
    assert robot.links["d"].ports["tip"].position[0] == 3
    assert robot.links["c"].ports["tip"].position[0] == 1
    close(robot.links["d"].center_of_mass, [0.5, 0, 0])


def test_frames_of_a_joint(load: Load) -> None:
    joint = load(
        robot_text(
            joint="at: [1, 2, 3 mm], rotate: [{z: 90 deg}, {x: 90 deg}], to_at: [0, 5 mm, 0],"
            " to_rotate: {y: 1 rad}"
        )
    ).joints["slide"]
    close(joint.T_from_joint.position, [1, 2, 0.003])
    # Turned by 90 deg about z, then about the turned x: the joint's y is the base's z.
    close(joint.T_from_joint.rotation, [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    close(joint.T_to_joint.position, [0, 0.005, 0])
    assert joint.T_to_joint.rotation[0, 2] == pytest.approx(math.sin(1))


def test_joint_frame_stands_in_the_port(load: Load) -> None:
    joint = load(
        """
robot: Test
links:
  a: {rigid: {ports: {p: {at: [1, 0, 0], rotate: {z: 90 deg}}}}}
  b: {rigid: {length: 1}}
joints:
  hold: {fixed: true, from: base, to: a}
  turn: {revolute: z, from: a.p, at: [1, 0, 0], to: b.tip}
tool: {at: b, offset: [0, 0, -50 mm], rotate: {x: 180 deg}, mass: 1.5 kg}
"""
    )
    turn = joint.joints["turn"]
    close(turn.T_from_joint.position, [1, 1, 0])
    close(turn.T_to_joint.position, [1, 0, 0])
    assert (turn.from_body, turn.from_port, turn.to_body, turn.to_port) == ("a", "p", "b", "tip")
    tool = joint.tool
    assert (tool.body, tool.port, tool.mass) == ("b", "base", 1.5)
    close(tool.T_body_tool.point([0, 1, 0]), [0, -1, -0.05])


@pytest.mark.parametrize(
    ("at", "towards", "axis"),
    [
        ([0, 0, 0], [0, 0, 2], [0, 0, 1]),
        ([1, 1, 1], [2, 1, 1], [1, 0, 0]),
        ([1, 1, 1], [-2, 1, 1], [-1, 0, 0]),
        ([1, 0, 0], [4, 4, 0], [0.6, 0.8, 0]),
    ],
)
def test_towards_points_the_x_axis(
    load: Load, at: list[int], towards: list[int], axis: list[float]
) -> None:
    joint = load(robot_text(joint=f"at: {at}, towards: {towards}")).joints["slide"]
    R = joint.T_from_joint.rotation
    close(R[:, 0], axis)
    close(R @ R.T, np.eye(3))
    assert np.linalg.det(R) == pytest.approx(1)


@pytest.mark.parametrize(
    ("kind", "motions"),
    [
        ("fixed: true", ()),
        ("revolute: y", ("ry",)),
        ("prismatic: z", ("z",)),
        ("cylindrical: x", ("x", "rx")),
        ("universal: [z, x]", ("rz", "rx")),
        ("spherical: true", ("rx", "ry", "rz")),
        ("planar: y", ("x", "z", "ry")),
    ],
)
def test_kinds_of_joints(load: Load, kind: str, motions: tuple[str, ...]) -> None:
    joint = load(robot_text().replace("prismatic: x", kind)).joints["slide"]
    assert joint.motions == motions
    for direction, freedom, stiffness in zip(
        ("x", "y", "z", "rx", "ry", "rz"), joint.freedoms, joint.stiffness, strict=True
    ):
        is_free = direction in motions
        assert freedom is (Freedom.PASSIVE if is_free else Freedom.BLOCKED)
        assert stiffness == (0.0 if is_free else math.inf)


def test_drives_and_bearings(load: Load) -> None:
    text = robot_text(joint="drive: {rx: rigid, x: 1e3 N/mm}, elastic: {ry: 2e5 N m/rad, z: 1e7}")
    joint = load(text.replace("prismatic", "cylindrical")).joints["slide"]
    P, B, D, E = Freedom.PASSIVE, Freedom.BLOCKED, Freedom.DRIVEN, Freedom.ELASTIC
    assert joint.freedoms == (D, B, E, D, E, B)
    np.testing.assert_array_equal(joint.stiffness, [1e6, math.inf, 1e7, math.inf, 2e5, math.inf])
    flexure = load(robot_text(joint="elastic: {x: 5 N/m}")).joints["slide"]
    assert flexure.freedoms == (E, B, B, B, B, B)
    single = load(robot_text(joint="drive: rigid")).joints["slide"]
    assert single.freedoms[0] is D
    assert single.stiffness[0] == math.inf
    assert P not in single.freedoms


def test_repeat_writes_sections_out(load: Load) -> None:
    robot = load(
        """
robot: Delta
parameters: {radius: 200 mm}
links:
  platform: {rigid: {ports: {p0: {}, p1: {}, p2: {}}}}
repeat:
  - for: {k: [0, 1, 2], phi: [0 deg, 120 deg, = 4*pi/3], side: [left, right, back]}
    links:
      "arm_{k}": {rigid: {length: = radius + k * 10 mm}}
      "{side}_rod": {like: "arm_{k}", mass: = k + 1}
    joints:
      "motor_{k}": {revolute: y, from: base, rotate: {z: = phi}, to: "arm_{k}", drive: rigid}
      "elbow_{k}": {spherical: true, from: "arm_{k}.tip", to: "{side}_rod"}
      "wrist_{k}": {spherical: true, from: "{side}_rod.tip", to: "platform.p{k}"}
tool: {at: platform}
"""
    )
    assert list(robot.links) == [
        "platform", "arm_0", "left_rod", "arm_1", "right_rod", "arm_2", "back_rod",
    ]  # fmt: skip
    assert list(robot.joints)[:4] == ["motor_0", "elbow_0", "wrist_0", "motor_1"]
    assert robot.links["arm_2"].ports["tip"].position[0] == pytest.approx(0.22)
    assert robot.links["right_rod"].mass == 2.0
    assert robot.links["right_rod"].ports["tip"].position[0] == pytest.approx(0.21)
    x_axis = robot.joints["motor_2"].T_from_joint.rotation[:, 0]
    close(x_axis, [-0.5, -math.sqrt(0.75), 0])
    assert robot.joints["wrist_1"].to_port == "p1"


def test_parameters_and_their_overrides(load: Load) -> None:
    text = robot_text(
        rest="parameters: {half: = base/2, base: 300 mm, n: 2}\nworkspace: {x: [0, = half]}"
    )
    robot = load(text)
    assert robot.parameters["base"].value == 0.3
    assert robot.parameters["base"].unit == "mm"
    assert robot.parameters["half"].unit == "m"
    assert robot.parameters["n"].unit == ""
    assert robot.workspace.ranges["x"] == (0.0, 0.15)
    wider = load(text, {"base": "0.4 m", "n": 3})
    assert wider.workspace.ranges["x"] == (0.0, 0.2)
    assert wider.notes == (
        "parameters.base: 300 mm replaced by 0.4 m",
        "parameters.n: 2 replaced by 3",
    )
    assert wider.content_hash == robot.content_hash


def test_home_workspace_and_loads(load: Load) -> None:
    robot = load(
        robot_text(
            rest="""
home: {x: 100 mm, rz: 30 deg, slide: 20 mm}
workspace: {z: [0, 1 m, 5], x: [-150 mm, 150 mm], polygon: [[0, 0], [1, 0], [0, 500 mm]]}
loads:
  push: {force: [0, 100 N, 0]}
  both: {force: [1, 0, 0], moment: [0, 0, 5 N m]}
"""
        )
    )
    assert robot.home.tool == pytest.approx({"x": 0.1, "rz": math.pi / 6})
    assert robot.home.joints == {"slide": (0.02,)}
    assert robot.workspace.ranges == {"x": (-0.15, 0.15), "y": (0.0, 0.5), "z": (0.0, 1.0)}
    assert robot.workspace.counts == {"z": 5}
    close(robot.workspace.polygon, [[0, 0], [1, 0], [0, 0.5]])
    close(robot.loads["push"].wrench, [0, 100, 0, 0, 0, 0])
    close(robot.loads["both"].wrench, [1, 0, 0, 0, 0, 5])


def test_home_of_a_joint_with_several_coordinates(load: Load) -> None:
    text = robot_text(rest="home: {slide: [10 mm, 20 deg]}")
    robot = load(text.replace("prismatic", "cylindrical"))
    assert robot.home.joints["slide"] == pytest.approx((0.01, math.radians(20)))


def test_workspace_of_points(load: Load) -> None:
    workspace = load(
        robot_text(rest="workspace: {points: {y: [1, 2, 3 mm], x: [0, 0, 1]}}")
    ).workspace
    assert workspace.point_axes == ("x", "y")
    close(workspace.points, [[0, 1], [0, 2], [1, 0.003]])


def test_file_is_known_by_its_hash(tmp_path: Path) -> None:
    path = tmp_path / "my-robot.yaml"
    path.write_text(robot_text())
    robot = load_robot(path)
    assert robot.name == "my-robot"
    assert robot.title == "Test"
    assert robot.source == path
    assert robot.content_hash == hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize("name", [robot.name for robot in describe_robots() if not robot.from_cad])
def test_robots_of_the_catalogue_load(name: str) -> None:
    robot = load_robot(name)
    assert robot.name == name
    assert robot.workspace.ranges or robot.workspace.points is not None


def test_five_bar() -> None:
    robot = load_robot("five-bar")
    assert len(robot.links) == 4
    assert len(robot.joints) == 5
    close(robot.joints["motor_left"].T_from_joint.position, [-0.15, 0, 0])
    left, right = robot.links["left_arm"], robot.links["right_arm"]
    np.testing.assert_array_equal(left.compliance, right.compliance)


def test_a_path_that_exists_wins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "five-bar.yaml").write_text(robot_text())
    (tmp_path / "mine").write_text(robot_text())
    monkeypatch.chdir(tmp_path)
    assert load_robot("five-bar.yaml").title == "Test"
    assert load_robot("./five-bar.yaml").title == "Test"
    assert load_robot(Path("mine")).title == "Test"
    assert load_robot("mine").title == "Test"
    assert load_robot("five-bar").title == "Planar five-bar"
