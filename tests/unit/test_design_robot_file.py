"""Robot files of designs: the text that was, and exactly the robot that was meant."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffkit.design.robot_file import write_robot_file
from stiffkit.errors import FileError, OutputError
from stiffkit.files import read_source, read_tree
from stiffkit.files.edit import replace_values
from stiffkit.robot import RobotFile, describe_robots, load_robot
from stiffkit.robot.catalogue import find_robot
from stiffkit.units import Value

TEXT = """\
# yaml-language-server: of no interest here
robot: Arm "with" é    # a title
parameters:
  L: 310 mm            # length
  α: 30 °
  twice: = 2 * L       # derived
  quoted: "= min(L, 400 mm)"
  flow: {flow}
  drive: 2e4 N m/rad
links:
  arm: {beam: {length: = twice, section: {round: 20 mm}, material: steel}}
joints:
  motor: {revolute: z, from: base, to: arm.base, drive: = drive}
tool: {at: arm.tip}
home: {motor: = α}
"""


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    path = tmp_path / "arm.yaml"
    path.write_text(TEXT.replace("{flow}", "0.25"), encoding="utf-8")
    return path


def assert_same(first: Any, second: Any, place: str = "robot") -> None:
    """Assert that two robots have the same numbers everywhere, to the last bit."""
    assert type(first) is type(second), place
    if dataclasses.is_dataclass(first):
        for field in dataclasses.fields(first):
            name = field.name
            if name not in ("source", "content_hash", "lines", "notes", "name", "origin", "unit"):
                assert_same(getattr(first, name), getattr(second, name), f"{place}.{name}")
    elif isinstance(first, dict):
        assert list(first) == list(second), place
        for key in first:
            assert_same(first[key], second[key], f"{place}[{key!r}]")
    elif isinstance(first, list | tuple):
        assert len(first) == len(second), place
        for number, (one, other) in enumerate(zip(first, second, strict=True)):
            assert_same(one, other, f"{place}[{number}]")
    elif isinstance(first, np.ndarray):
        assert np.array_equal(first, second, equal_nan=True), place
    else:
        assert first == second, place


def odd_values(path_or_name: str | Path) -> dict[str, float]:
    """Return values of all plain parameters of a robot file that no decimal unit makes round."""
    root = read_tree(read_source(find_robot(path_or_name))).child("parameters")
    assert root is not None
    plain = root.plain()
    assert isinstance(plain, dict)
    robot = RobotFile(path_or_name)
    return {
        name: value * (1.0 + 1e-3 / (3.0 + number))
        for number, (name, value) in enumerate(sorted(values_of(robot).items()))
        if not str(plain[name]).startswith("=")
    }


def with_dimensions(name: str, values: dict[str, float]) -> dict[str, Value]:
    """Return values of parameters with the dimensions that they have in the robot file."""
    found = RobotFile(name)._parameters.values
    return {one: Value(value, found[one].dims) for one, value in values.items()}


def values_of(file: RobotFile) -> dict[str, float]:
    """Return the parameters of a file, SI, without solving its parts from CAD."""
    return {name: value.si for name, value in file._parameters.values.items()}


@pytest.mark.parametrize("name", [one.name for one in describe_robots() if not one.from_cad])
def test_a_robot_of_the_catalogue_is_read_back_to_the_last_bit(name: str, tmp_path: Path) -> None:
    values = odd_values(name)
    assert values
    write_robot_file(name, values, tmp_path / "new.yaml")
    assert_same(load_robot(tmp_path / "new.yaml"), load_robot(name, with_dimensions(name, values)))


@pytest.mark.parametrize("name", [one.name for one in describe_robots() if one.from_cad])
def test_a_robot_with_parts_from_cad_has_the_same_parameters(name: str, tmp_path: Path) -> None:
    # Its parts depend on the text and on these alone, and take minutes to solve.
    values = odd_values(name)
    write_robot_file(name, values, tmp_path / "new.yaml")
    new = RobotFile(tmp_path / "new.yaml")
    expected = RobotFile(name)._parameters.replaced(with_dimensions(name, values))[0]
    assert values_of(new) == {one: value.si for one, value in expected.items()}
    for section in ("links", "joints", "repeat", "tool", "home", "workspace", "loads"):
        old, found = (read_tree(r.source).child(section) for r in (RobotFile(name), new))
        assert (old is None) == (found is None)
        assert old is None or found is None or old.plain() == found.plain()


def test_only_the_values_change(arm: Path, tmp_path: Path) -> None:
    target = tmp_path / "new.yaml"
    values = {"L": 0.35, "α": 0.5, "twice": 0.5, "flow": 0.1 + 0.2, "drive": 3e7}
    write_robot_file(arm, values, target)
    text = target.read_text(encoding="utf-8")
    comment = text[: text.index("# yaml-language-server")]
    assert "from arm.yaml, with other values of:\n" in comment
    assert "#   L: 350 mm, before: 310 mm\n" in comment
    assert "#   twice: 0.5 m, before: = 2 * L\n" in comment
    assert f"# SHA-256 of that file: {read_source(arm).content_hash}\n" in comment
    assert text.removeprefix(comment) == (
        TEXT.replace("{flow}", "0.30000000000000004")
        .replace("L: 310 mm ", "L: 350 mm ")
        .replace("30 °", "28.64788975654116 °")
        .replace("= 2 * L       #", "0.5 m         #")
        .replace("2e4 N", "3e7 N")
    )
    assert_same(load_robot(target), load_robot(arm, values))


def test_expressions_are_written_as_they_are(arm: Path, tmp_path: Path) -> None:
    target = tmp_path / "new.yaml"
    values: dict[str, str | float] = {
        "L": "= flow * 1 m",
        "quoted": "= max(L, 1 mm)",
        "flow": 0.5,
        "drive": "3 kN m/rad",
    }
    write_robot_file(arm, values, target)
    text = target.read_text(encoding="utf-8")
    assert "  L: = flow * 1 m      # length\n" in text
    assert "  quoted: '= max(L, 1 mm)'\n" in text
    assert_same(load_robot(target), load_robot(arm, values))


def test_a_value_that_stays_keeps_its_text(arm: Path, tmp_path: Path) -> None:
    target = tmp_path / "new.yaml"
    write_robot_file(arm, {"L": 0.31, "drive": 2e4}, target)
    text = target.read_text(encoding="utf-8")
    assert "with the same values of its parameters." in text
    assert text.endswith(arm.read_text(encoding="utf-8"))


def test_quotes_line_ends_and_flow_mappings(tmp_path: Path) -> None:
    path, target = tmp_path / "arm.yaml", tmp_path / "new.yaml"
    head, tail = TEXT.replace("\n", "\r\n").split("parameters:")
    links = tail[tail.index("links:") :]
    flow = "{L: '310 mm', α: 30 °, twice: = 2*L, drive: \"2e4 N m/rad\", e: 1}\r\n"
    path.write_bytes(f"{head}parameters: {flow}{links}".encode())
    values = {"L": 0.2, "α": -0.1, "drive": 1e-3, "e": -2.0}
    write_robot_file(path, values, target)
    text = target.read_bytes().decode()
    assert "\n" not in text.replace("\r\n", "")
    assert "L: '200 mm', α: -5.729577951308233 °, twice: = 2*L, drive: \"0.001 N m/rad\"" in text
    assert_same(load_robot(target), load_robot(path, values))


def test_files_that_a_robot_takes_are_found_from_the_new_place(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there, too"
    (here / "links").mkdir(parents=True)
    there.mkdir()
    matrix = "\n".join(
        f"    - [{', '.join('1e-7' if i == j else '0' for j in range(6))}]" for i in range(6)
    )
    (here / "links" / "rod.link.yaml").write_text(
        f"link: Rod\ncompliance:\n  length: 0.3\n  matrix:\n{matrix}\nmass: 1 kg\n"
    )
    link = "{compliance: links/rod.link.yaml}"
    (here / "arm.yaml").write_text(
        "robot: Arm\nparameters: {drive: 1e4 N m/rad}\n"
        f"links: {{arm: {link}}}\n"
        f"repeat: [{{for: {{k: [1, 2]}}, links: {{'arm_{{k}}': {link}}}, joints: "
        "{'j_{k}': {fixed: true, from: arm.tip, to: 'arm_{k}.base'}}}]\n"
        "joints: {motor: {revolute: z, from: base, to: arm.base, drive: = drive}}\n"
        "tool: {at: arm.tip}\n"
    )
    write_robot_file(here / "arm.yaml", {"drive": 2e4}, there / "new.yaml")
    assert_same(load_robot(there / "new.yaml"), load_robot(here / "arm.yaml", {"drive": 2e4}))
    # Back again, by way of a folder that the file does not stay in.
    work = here / "work"
    work.mkdir()
    write_robot_file(there / "new.yaml", {"drive": 3e4}, work / "back.yaml", folder=here)
    text = (work / "back.yaml").read_text()
    assert text.count("links/rod.link.yaml") == 2
    (work / "back.yaml").rename(here / "back.yaml")
    assert_same(load_robot(here / "back.yaml"), load_robot(here / "arm.yaml", {"drive": 3e4}))


def test_what_cannot_be_written_is_told_and_leaves_nothing(arm: Path, tmp_path: Path) -> None:
    target = tmp_path / "new.yaml"
    with pytest.raises(FileError, match="no parameter 'l'") as unknown:
        write_robot_file(arm, {"l": 0.3}, target)
    assert "did you mean 'L'" in unknown.value.mend
    with pytest.raises(OutputError, match="parameter L has no value"):
        write_robot_file(arm, {"L": float("nan")}, target)
    with pytest.raises(OutputError, match="is the robot file itself"):
        write_robot_file(arm, {"L": 0.3}, tmp_path / "." / "arm.yaml")
    with pytest.raises(OutputError, match="cannot write"):
        write_robot_file(arm, {"L": 0.3}, tmp_path / "nowhere" / "new.yaml")
    assert [path.name for path in tmp_path.iterdir()] == ["arm.yaml"]


def test_a_value_behind_an_anchor_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    text = TEXT.replace("L: 310 mm ", "L: &L 310 mm").replace("{flow}", "*L")
    path.write_text(text, encoding="utf-8")
    for name in ("L", "flow"):
        with pytest.raises(FileError, match=f"parameters.{name}: there is no value here") as error:
            write_robot_file(path, {name: 0.2}, tmp_path / "new.yaml")
        assert "without anchors" in error.value.mend
    write_robot_file(path, {"drive": 1.0}, tmp_path / "new.yaml")
    assert load_robot(tmp_path / "new.yaml").parameters["drive"].value == 1.0


def test_a_unit_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    path.write_text(
        TEXT.replace("{flow}", "= sqrt(L)"),
        encoding="utf-8",
    )
    with pytest.raises(OutputError, match="parameter flow cannot be written"):
        write_robot_file(path, {"flow": 0.5}, tmp_path / "new.yaml")


def test_replaced_texts_are_quoted_where_they_need_it(tmp_path: Path) -> None:
    path = tmp_path / "any.yaml"
    path.write_text("a: [x.step, {b: 1}]   # here\nc: >\n  folded\n  text\nd: 2\n")
    source = read_source(path)
    text = replace_values(
        source, {("a", 0): "it's, #1.step", ("a", 1, "b"): "2.5 mm", ("c",): "3", ("d",): "4"}
    )
    path.write_text(text)
    assert read_tree(read_source(path)).plain() == {
        "a": ["it's, #1.step", {"b": "2.5 mm"}],
        "c": 3,
        "d": 4,
    }
    assert text.splitlines()[0].endswith("]   # here")
