"""Files that are hostile, broken, or not robot files at all."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
import yaml

from stiffkit.errors import FileError
from stiffkit.files import tree
from stiffkit.files.source import LARGEST_FILE, Source, read_source
from stiffkit.files.tree import read_tree
from stiffkit.robot import load_robot


@pytest.fixture(params=["CSafeLoader", "SafeLoader"])
def _loader(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a test with libyaml, where there is one, and with PyYAML's own parser."""
    if not hasattr(yaml, request.param):
        pytest.skip("PyYAML without libyaml")
    monkeypatch.setattr(tree, "_Loader", getattr(yaml, request.param))


def plain(text: str) -> tree.Plain:
    return read_tree(Source(Path("robot.yaml"), text, "")).plain()


def error_of(text: str) -> str:
    with pytest.raises(FileError) as caught:
        plain(text)
    return str(caught.value)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"\x89PNG\r\n\x1a\n", "is not UTF-8 text (byte 1)"),
        (b"robot: caf\xe9\n", "robot.yaml:1: is not UTF-8 text (byte 11)"),
        ("robot: x".encode("utf-16"), "is not UTF-8 text"),
        (b"robot: a\nx: \0", "robot.yaml:2: is not a text file (it holds NUL"),
        (b"", "is empty"),
        (b"# only a comment\n", "is empty"),
        (b"just text", "a mapping is expected"),
        (b"- a\n- b", "a mapping is expected"),
        (b"a" * (LARGEST_FILE + 1), "is larger than 1024 KiB"),
    ],
)
def test_files_that_are_no_robot_files(tmp_path: Path, content: bytes, told: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_bytes(content)
    with pytest.raises(FileError) as caught:
        load_robot(path)
    assert told in str(caught.value)


def test_what_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="this is a directory"):
        load_robot(tmp_path)
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    with pytest.raises(FileError, match="not an ordinary file"):
        load_robot(pipe)
    link = tmp_path / "link.yaml"
    link.symlink_to(tmp_path / "gone.yaml")
    with pytest.raises(FileError, match="no such file"):
        load_robot(link)
    loop = tmp_path / "loop.yaml"
    loop.symlink_to(loop)
    with pytest.raises(FileError, match="cannot be read"):
        load_robot(loop)


def test_byte_order_mark_is_no_part_of_the_text(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_bytes(b"\xef\xbb\xbfrobot: a")
    assert read_source(path).text == "robot: a"


@pytest.mark.usefixtures("_loader")
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e5", 1e5),
        ("1e-5", 1e-5),
        ("+3", 3),
        ("010", 10),
        (".5", 0.5),
        ("5.", 5.0),
        ("yes", "yes"),
        ("on", "on"),
        ("No", "No"),
        ("true", True),
        ("False", False),
        ("1:30", "1:30"),
        ("2020-01-01", "2020-01-01"),
        ("0x10", "0x10"),
        ("1_000", "1_000"),
        (".nan", ".nan"),
        (".inf", ".inf"),
        ("=", "="),
        ("= a/2", "= a/2"),
        ("<<", "<<"),
        ("~", None),
        ("", None),
        ("'5'", "5"),
        ('"true"', "true"),
        ("30 mm # thick", "30 mm"),
        ("9" * 5000, "9" * 5000),
    ],
)
def test_values_are_what_was_typed(text: str, value: object) -> None:
    assert plain(f"a: {text}") == {"a": value}
    assert type(plain(f"a: {text}")["a"]) is type(value)  # type: ignore[index, call-overload]


@pytest.mark.usefixtures("_loader")
def test_keys_are_text() -> None:
    assert plain("on: 1\n1: 2\n6,6: 3\n~: 4\nn: 5") == {"on": 1, "1": 2, "6,6": 3, "~": 4, "n": 5}


@pytest.mark.usefixtures("_loader")
def test_lines_are_those_of_the_keys() -> None:
    root = read_tree(Source(Path("f"), "a:\n  b:\n    c: 1\n  d:\n    - 1\n    -\n      2\n", ""))
    a = root.child("a")
    assert a is not None
    b, d = a.child("b"), a.child("d")
    assert b is not None
    assert d is not None
    c, first = b.child("c"), d.child(0)
    assert c is not None
    assert first is not None
    assert [root.line, a.line, b.line, c.line, d.line, first.line] == [1, 1, 2, 3, 4, 5]


@pytest.mark.usefixtures("_loader")
@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a: 1\nb:\n  c: 1\n  c: 2", "robot.yaml:4: b: the key 'c' stands here a second time"),
        ("a: 1\nb:\n  c: 1\n  c: 2", "(first in line 3)"),
        ("a:\n\t- 3", "robot.yaml:2: is not valid YAML"),
        ("a:\n\t- 3", "indent with spaces"),
        ("a: b: c", "robot.yaml:1: is not valid YAML: mapping values are not allowed"),
        ("a: [1, 2\nb: 3", "is not valid YAML"),
        ("a: 'x", "is not valid YAML"),
        ("a: !!python/object/apply:os.system [ls]", "robot.yaml:1: a: the tag"),
        ("a: !x 1", "the tag '!x' is not allowed"),
        ("a: 1\n---\nb: 2", "robot.yaml:2: a second document begins here"),
        ("a: *b", "the alias '*b' stands for nothing"),
        ("a: &b [*b]", "the alias '*b' lies in what it stands for"),
        ("a: &b {c: *b}", "the alias '*b' lies in what it stands for"),
        ("{[a]: 1}", "a key is a list or a mapping"),
        ("a_{k}: {{k}: 1}", "a key is a list or a mapping"),
        ("b: &b [1]\n*b : 1", "a key is a list or a mapping"),
        ('a: "\\e[31m"', "a text holds a control character"),
        ('"a\\nb": 1', "a key holds a line break"),
        ("a: \x01", "is not valid YAML"),
    ],
)
def test_yaml_that_is_refused(text: str, told: str) -> None:
    assert told in error_of(text)


@pytest.mark.usefixtures("_loader")
@pytest.mark.parametrize("text", ["[" * 100_000, "{a: " * 50_000, "- " * 50_000, "? " * 50_000])
def test_deep_nesting_is_refused_at_once(text: str) -> None:
    begin = time.perf_counter()
    message = error_of(text)
    assert time.perf_counter() - begin < 5.0
    assert "levels deep" in message or "a key is a list" in message


@pytest.mark.usefixtures("_loader")
def test_nesting_by_aliases_counts() -> None:
    lines = ["a0: &a0 [1]"] + [f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 40)]
    assert "levels deep" in error_of("\n".join(lines))


@pytest.mark.usefixtures("_loader")
def test_a_bomb_of_aliases_is_refused_unexploded() -> None:
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 20)]
    assert "holds more than 20000 values" in error_of("\n".join(lines))


@pytest.mark.usefixtures("_loader")
def test_aliases_are_copies() -> None:
    assert plain("a: &x {b: [1, 2]}\nc: *x") == {"a": {"b": [1, 2]}, "c": {"b": [1, 2]}}
