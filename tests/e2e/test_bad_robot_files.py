"""Wrong robot files through the command line.

Each gives one message with the file, the line, the key, what is wrong and how to mend it, with
status 2, in bounded time and memory. What the messages say in all cases is tested in the unit tests
of the loader; here are those that a user meets, as a process.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from .commandline import output_of, refusal_of

SOON = 20.0
"""Seconds, with room for a busy machine; the commands take less than one."""

MEMORY = 512 * 1024
"""KiB."""

ROBOT = """\
robot: Planar five-bar
parameters:
  base: 300 mm
  proximal: 200 mm
  distal: 350 mm
links:
  left_arm: {beam: {length: = proximal, section: {tube: [40 mm, 4 mm]}, material: steel}}
  left_rod:
    compliance:
      length: = distal
      matrix:
        - [2e-9, 0, 0, 0, 0, 0]
        - [0, 3e-7, 0, 0, 0, 1e-6]
        - [0, 0, 3e-7, 0, -1e-6, 0]
        - [0, 0, 0, 5e-6, 0, 0]
        - [0, 0, -1e-6, 0, 4e-6, 0]
        - [0, 1e-6, 0, 0, 0, 4e-6]
    inertia: [[1, 0, 0], [0, 2, 0], [0, 0, 2]]
  right_arm: {like: left_arm}
  right_rod: {like: left_rod}
joints:
  motor_left: {revolute: z, from: base, at: [= -base/2, 0, 0], to: left_arm, drive: 2e4 N m/rad}
  motor_right: {revolute: z, from: base, at: [= base/2, 0, 0], to: right_arm, drive: 2e4 N m/rad}
  elbow_left: {revolute: z, from: left_arm.tip, to: left_rod.base}
  elbow_right: {revolute: z, from: right_arm.tip, to: right_rod.base}
  wrist: {revolute: z, from: left_rod.tip, to: right_rod.tip}
tool: {at: left_rod.tip}
home: {x: 0, y: 400 mm, elbow_left: -80 deg, elbow_right: 80 deg}
workspace: {x: [-150 mm, 150 mm], y: [300 mm, 450 mm]}
"""

Slip = tuple[str, str, int, str, str, str]
"""What is replaced by what; line and key of the message, what it says, and how to mend it."""

SLIPS: dict[str, Slip] = {
    "wrong unit": (
        "base: 300 mm",
        "base: 300 mn",
        3,
        "parameters.base",
        "'mn' is no unit known here",
        "did you mean",
    ),
    "unit of something else": (
        "drive: 2e4 N m/rad}\n  motor_right",
        "drive: 2e4 N/m}\n  motor_right",
        22,
        "joints.motor_left.drive",
        "is a translational stiffness, a rotational stiffness is expected",
        "for example",
    ),
    "missing key": (
        ", material: steel",
        "",
        7,
        "links.left_arm.beam",
        "'material' is missing",
        "add it, for example",
    ),
    "unknown key": (
        "elbow_left: {revolute: z",
        "elbow_left: {revolut: z",
        24,
        "joints.elbow_left.revolut",
        "unknown key 'revolut'",
        "did you mean 'revolute'?",
    ),
    "negative length": (
        "proximal: 200 mm",
        "proximal: -200 mm",
        7,
        "links.left_arm.beam.length",
        "must be positive",
        "",
    ),
    "indefinite compliance": (
        "1e-6, 0, 0, 0, 4e-6]",
        "1e-6, 0, 0, 0, 1e-7]",
        11,
        "links.left_rod.compliance.matrix",
        "not positive",
        "repair",
    ),
    "unsymmetric compliance": (
        "[0, 0, -1e-6, 0, 4e-6, 0]",
        "[0, 0, 1e-6, 0, 4e-6, 0]",
        11,
        "links.left_rod.compliance.matrix",
        "not symmetric",
        "symmetrize",
    ),
    "inertia that no body has": (
        "[[1, 0, 0], [0, 2, 0], [0, 0, 2]]",
        "[[1, 0, 0], [0, 2, 0], [0, 0, 5]]",
        18,
        "links.left_rod.inertia",
        "exceeds the sum",
        "repair",
    ),
    "loop that cannot close": (
        "distal: 350 mm",
        "distal: 35 mm",
        28,
        "home",
        "the mechanism cannot be put together at its home posture: the loop",
        "check lengths and joint frames",
    ),
    "home out of reach": (
        "y: 400 mm",
        "y: 900 mm",
        28,
        "home",
        "the mechanism cannot be put together at its home posture",
        "check lengths and joint frames",
    ),
    "missing link": (
        "to: left_rod.base",
        "to: left_rud.base",
        24,
        "joints.elbow_left.to",
        "there is no link 'left_rud'",
        "did you mean 'left_rod'",
    ),
    "missing port": (
        "to: left_rod.base",
        "to: left_rod.end",
        24,
        "joints.elbow_left.to",
        "link 'left_rod' has no port 'end'",
        "known here: base, tip",
    ),
    "name used twice": (
        "  right_arm: {",
        "  left_rod: {",
        19,
        "links",
        "the key 'left_rod' stands here a second time (first in line 8)",
        "rename or remove one of the two",
    ),
    "circular parameter": (
        "base: 300 mm\n  proximal: 200 mm",
        "base: = 2 * proximal\n  proximal: = base / 2",
        3,
        "parameters.base",
        "refers to itself: base -> proximal -> base",
        "give one of them a value of its own",
    ),
    "code for a number": (
        "base: 300 mm",
        "base: = __import__('os').getpid()",
        3,
        "parameters.base",
        "'",
        "",
    ),
    "tag that makes an object": (
        "base: 300 mm",
        "base: !!python/object/apply:os.getpid []",
        3,
        "parameters.base",
        "is not allowed",
        "write the value without a tag",
    ),
    "lost unit": (
        "proximal: 200 mm",
        "proximal: 200",
        28,
        "home",
        "cannot be put together",
        "a number without a unit is in metres",
    ),
    "broken YAML": (
        "tool: {at: left_rod.tip}",
        "tool: {at: left_rod.tip",
        28,
        "",
        "is not valid YAML",
        "check brackets",
    ),
    "tab": ("  base: 300 mm", "\tbase: 300 mm", 3, "", "is not valid YAML", "indent with spaces"),
}


def test_the_robot_without_slips_is_right(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    assert output_of("check", "robot.yaml", cwd=tmp_path).startswith("robot  ")


def test_a_workspace_out_of_reach_is_told(tmp_path: Path) -> None:
    text = ROBOT.replace("y: [300 mm, 450 mm]", "y: [450 mm, 900 mm]")
    (tmp_path / "robot.yaml").write_text(text, encoding="utf-8")
    shown = output_of("check", "robot.yaml", cwd=tmp_path)
    assert "note: workspace: of 35 postures tried, 29 not reached" in shown


@pytest.mark.parametrize("case", SLIPS)
def test_slip(case: str, tmp_path: Path) -> None:
    old, new, line, key, told, mend = SLIPS[case]
    assert ROBOT.count(old) == 1
    (tmp_path / "robot.yaml").write_text(ROBOT.replace(old, new), encoding="utf-8")
    message = refusal_of("check", "robot.yaml", cwd=tmp_path, timeout=SOON)
    place = f"error: robot.yaml:{line}: {key}"
    assert message.startswith(place)
    assert told in message
    assert mend in message


@pytest.mark.parametrize(
    "case", ["wrong unit", "loop that cannot close", "indefinite compliance", "broken YAML"]
)
def test_map_refuses_and_writes_nothing(case: str, tmp_path: Path) -> None:
    old, new, line, key, told, _ = SLIPS[case]
    (tmp_path / "robot.yaml").write_text(ROBOT.replace(old, new), encoding="utf-8")
    message = refusal_of("map", "robot.yaml", cwd=tmp_path, timeout=SOON)
    assert message.startswith(f"error: robot.yaml:{line}: {key}")
    assert told in message
    assert [p.name for p in tmp_path.iterdir()] == ["robot.yaml"]


@pytest.mark.parametrize(
    ("workspace", "place", "told"),
    [
        ("workspace: {z: [0, 1]}", "robot.yaml:29: workspace.z: ", "coordinates are: x, y"),
        ("", "robot.yaml: workspace: ", "has no workspace to map"),
    ],
)
def test_workspace_that_cannot_be_mapped(
    workspace: str, place: str, told: str, tmp_path: Path
) -> None:
    lines = ROBOT.splitlines()[:-1]
    (tmp_path / "robot.yaml").write_text("\n".join([*lines, workspace]), encoding="utf-8")
    message = refusal_of("map", "robot.yaml", cwd=tmp_path, timeout=SOON)
    assert message.startswith(f"error: {place}")
    assert told in message
    assert [p.name for p in tmp_path.iterdir()] == ["robot.yaml"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("at: [= base/2, 0, 0]", "at: [= base/2, 0, 10 mm]"),
        ("y: 400 mm", "y: 400 mm, z: 3 mm"),
        ("y: 400 mm", "y: 400 mm, rx: 5 deg"),
    ],
    ids=["loop is open across its plane", "tool is out of its plane", "tool is tilted"],
)
def test_what_no_joint_can_change_must_fit_too(old: str, new: str, tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(ROBOT.replace(old, new), encoding="utf-8")
    message = refusal_of("check", "robot.yaml", cwd=tmp_path, timeout=SOON)
    assert message.startswith("error: robot.yaml:28: home: ")
    assert "cannot be put together" in message


def bomb(depth: int = 12, width: int = 10) -> str:
    """Return the billion laughs in YAML: each level repeats the one before."""
    lines = ["robot: bomb", "a0: &a0 [" + ", ".join(["laugh"] * width) + "]"]
    for level in range(1, depth):
        aliases = ", ".join([f"*a{level - 1}"] * width)
        lines.append(f"a{level}: &a{level} [{aliases}]")
    return "\n".join(lines)


class TestNoRobotFileAtAll:
    """What is no robot file is refused soon, and with little memory."""

    def told(self, name: str, here: Path) -> str:
        message = refusal_of("check", name, cwd=here, timeout=SOON, limit=f"-d {MEMORY}")
        assert message.startswith(f"error: {name}:")
        return message

    def test_gigabyte(self, tmp_path: Path) -> None:
        path = tmp_path / "large.yaml"
        with path.open("wb") as file:
            file.truncate(1 << 30)
        assert "larger than 1024 KiB mend: files of this kind are small" in self.told(
            path.name, tmp_path
        )

    def test_bomb(self, tmp_path: Path) -> None:
        (tmp_path / "bomb.yaml").write_text(bomb(), encoding="utf-8")
        assert "bomb.yaml:6: a4: holds more than 20000 values" in self.told("bomb.yaml", tmp_path)

    def test_deep_nesting(self, tmp_path: Path) -> None:
        (tmp_path / "deep.yaml").write_text("robot: " + "[" * 100_000, encoding="utf-8")
        assert "nested more than" in self.told("deep.yaml", tmp_path)

    def test_program(self, tmp_path: Path) -> None:
        (tmp_path / "program.yaml").write_bytes(b"\x7fELF\x02\x01\x01\x00\xff\xfe" * 100)
        message = self.told("program.yaml", tmp_path)
        assert "is not UTF-8 text" in message
        assert "mend: save it as plain text in UTF-8" in message

    def test_nul_characters(self, tmp_path: Path) -> None:
        (tmp_path / "nul.yaml").write_bytes(b"robot: a\nlinks: \0\n")
        assert "nul.yaml:2: is not a text file" in self.told("nul.yaml", tmp_path)

    def test_empty(self, tmp_path: Path) -> None:
        (tmp_path / "empty.yaml").touch()
        assert "is empty mend: begin with 'robot: TITLE'" in self.told("empty.yaml", tmp_path)

    def test_directory(self, tmp_path: Path) -> None:
        (tmp_path / "folder.yaml").mkdir()
        assert "this is a directory" in self.told("folder.yaml", tmp_path)

    def test_endless_device(self, tmp_path: Path) -> None:
        assert "this is not an ordinary file" in self.told("/dev/zero", tmp_path)

    def test_pipe_that_nobody_writes(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "pipe.yaml")
        assert "this is not an ordinary file" in self.told("pipe.yaml", tmp_path)

    def test_dangling_link(self, tmp_path: Path) -> None:
        (tmp_path / "link.yaml").symlink_to("nowhere.yaml")
        assert "there is no such file" in self.told("link.yaml", tmp_path)
