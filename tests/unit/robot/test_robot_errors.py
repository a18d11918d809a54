"""Wrong robot files: each message names the line, the key, what is wrong and how to mend it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from stiffkit.errors import FileError
from stiffkit.robot import Robot, load_robot

Load = Callable[..., Robot]

VALID = """\
robot: Test
parameters: {base: 300 mm, mass: 3 kg}
links:
  arm: {rigid: {length: 200 mm}}
  rod: {beam: {length: 1, section: {tube: [40 mm, 4 mm]}, material: steel}}
joints:
  motor: {revolute: z, from: base, to: arm, drive: 2e4 N m/rad}
  elbow: {universal: [y, z], from: arm.tip, to: rod}
tool: {at: rod.tip, mass: 1.5 kg}
home: {x: 0, motor: 20 deg}
workspace: {x: [-1, 1], y: [0, 1]}
loads:
  push: {force: [0, 1 N, 0]}
"""

Case = tuple[str, str, int, str, str]
"""What is replaced by what, and the line, the key and the words of the message."""


def cases(name: str) -> list[Case]:
    table = yaml.safe_load(Path(__file__).with_name("bad").joinpath(name).read_text("utf-8"))
    return [tuple(case.values()) for case in table]


def told_of(load: Load, text: str) -> str:
    """Load a wrong file and return the message on one line."""
    with pytest.raises(FileError) as caught:
        load(text)
    return " ".join(str(caught.value).replace("mend: ", "").split())


@pytest.mark.parametrize(
    ("old", "new", "line", "key", "told"), cases("shape.yaml") + cases("meaning.yaml")
)
def test_wrong_file(load: Load, old: str, new: str, line: int, key: str, told: str) -> None:
    assert VALID.count(old) == 1
    message = told_of(load, VALID.replace(old, new))
    assert f"robot.yaml:{line}: " in message
    assert f"{key}: " in message
    assert told in message


def test_the_valid_file_is_valid(load: Load) -> None:
    assert load(VALID).notes == ()


COMPLIANCE = """\
robot: Test
links:
  foot:
    compliance:
      matrix:
        - [2, 0, 0, 0, 0, 0]
        - [0, 3, 0, 0, 0, 1]
        - [0, 0, 4, 0, -1, 0]
        - [0, 0, 0, 5, 0, 0]
        - [0, 0, -1, 0, 6, 0]
        - [0, 1, 0, 0, 0, 7]
      length: 1
joints:
  hold: {fixed: true, from: base, to: foot}
tool: {at: foot.tip}
"""


@pytest.mark.parametrize(("old", "new", "line", "key", "told"), cases("compliance.yaml"))
def test_wrong_compliance(load: Load, old: str, new: str, line: int, key: str, told: str) -> None:
    assert COMPLIANCE.count(old) == 1
    message = told_of(load, COMPLIANCE.replace(old, new))
    assert f"robot.yaml:{line}: links.foot.compliance" in message
    assert f"{key}: " in message
    assert told in message


REPEAT = """\
robot: Test
parameters: {p: 1}
links: {arm_7: {rigid: {}}}
repeat:
  - for: {k: [1, 2]}
    links:
      "arm_{k}": {rigid: {length: = k}}
    joints:
      "j_{k}": {revolute: z, from: base, to: "arm_{k}"}
joints: {j: {fixed: true, from: base, to: arm_7}}
tool: {at: arm_1}
"""


@pytest.mark.parametrize(("old", "new", "line", "key", "told"), cases("repeat.yaml"))
def test_wrong_repeat(load: Load, old: str, new: str, line: int, key: str, told: str) -> None:
    message = told_of(load, REPEAT.replace(old, new))
    assert f"robot.yaml:{line}: {key}" in message
    assert told in message


def test_too_many_parts_are_refused(load: Load) -> None:
    values = ", ".join(map(str, range(10, 110)))
    links = "".join(f'      "more{i}_{{k}}": {{rigid: {{}}}}\n' for i in range(6))
    text = REPEAT.replace("[1, 2]", f"[{values}]").replace("    links:\n", f"    links:\n{links}")
    assert "more than 500 links" in told_of(load, text)


def test_several_errors_are_told_at_once(load: Load) -> None:
    text = VALID.replace("200 mm", "0").replace("4 mm]", "90 mm]")
    with pytest.raises(FileError) as caught:
        load(text)
    assert "links.arm.rigid.length" in str(caught.value)
    assert "links.rod.beam.section.tube" in str(caught.value)
    shape = VALID.replace("revolute:", "revolut:").replace("at: rod.tip", "att: rod.tip")
    with pytest.raises(FileError) as caught:
        load(shape)
    assert [error.line for error in (caught.value, *caught.value.others)] == [7, 9, 9]


def test_copies_of_a_wrong_link_are_told_once(load: Load) -> None:
    text = VALID.replace("200 mm", "0").replace("joints:\n", "  copy: {like: arm}\njoints:\n")
    with pytest.raises(FileError) as caught:
        load(text)
    assert caught.value.others == ()


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"bse": "1 m"}, "no parameter 'bse'\n  mend: did you mean 'base'"),
        ({"base": "2 kg"}, "'2 kg' is a mass, parameter base is a length (300 mm)"),
        ({"base": "2 mn"}, "no unit"),
        ({"base": "= mas"}, "did you mean 'mass'"),
        ({"base": float("nan")}, "not finite"),
    ],
)
def test_wrong_overrides(load: Load, parameters: dict[str, str | float], told: str) -> None:
    with pytest.raises(FileError) as caught:
        load(VALID, parameters)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("five-bra", "did you mean 'five-bar'"),
        ("five_bar.yaml", "did you mean 'five-bar'"),
        ("nowhere/robot.yaml", "no such file"),
        (Path("five-bar"), "no such file"),
        ("", "no robot of this name"),
        ("nul\0.yaml", "no such file"),
        ("x" * 5000 + ".yaml", ""),
    ],
)
def test_robot_that_does_not_exist(name: str | Path, told: str) -> None:
    with pytest.raises(FileError) as caught:
        load_robot(name)
    assert told in str(caught.value)
