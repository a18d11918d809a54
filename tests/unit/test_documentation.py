"""The documentation says what is true: its commands run, its files load, its links lead somewhere.

In a ``console`` block, lines after ``$ command`` are what the command prints, where ``...`` stands
for any lines. A ``yaml`` or ``python`` block whose first line is a comment with a file's name is
that file, for the commands of the same page; every other ``yaml`` block is checked against the
schema.
"""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import pytest
import yaml

from stiffkit.design import SCHEMA_FILE as DESIGN_SCHEMA_FILE
from stiffkit.design.uncertainty import SCHEMA_FILE as UNCERTAINTY_SCHEMA_FILE
from stiffkit.fea.link_spec import SCHEMA_FILE as CAD_SCHEMA_FILE
from stiffkit.files.schema import check_shape
from stiffkit.files.source import Source
from stiffkit.files.tree import Node, read_tree
from stiffkit.identify.spec import SCHEMA_FILE as SPEC_SCHEMA_FILE
from stiffkit.link import MATERIALS
from stiffkit.robot import list_robots, load_robot
from stiffkit.robot.joints import KINDS
from stiffkit.robot.loader import SCHEMA_FILE
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep import SCHEMA_FILE as STUDY_SCHEMA_FILE

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")])
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]
ROOMS = sorted(path.parent.name for path in ROOT.glob("src/stiffkit/*/__init__.py"))

_BLOCK = re.compile(r"^```([^`\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_FILE = re.compile(r"# ([\w-]+\.(?:yaml|py))\n")
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
_HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)


class Block(NamedTuple):
    """A fenced block of a page."""

    language: str
    text: str


def blocks(page: Path, *languages: str) -> list[Block]:
    found = [Block(*match.groups()) for match in _BLOCK.finditer(page.read_text("utf-8"))]
    return [block for block in found if block.language in languages]


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    programs = str(Path(sys.executable).parent)
    return {
        **os.environ,
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "COLUMNS": "100",
        # Matplotlib looks for its fonts anew wherever its own cache is not.
        "MPLCONFIGDIR": matplotlib.get_cachedir(),
        "XDG_CACHE_HOME": str(tmp_path_factory.mktemp("cache")),
    }


def write_files(page: Path, folder: Path) -> None:
    for block in blocks(page, "yaml", "python"):
        if named := _FILE.match(block.text):
            (folder / named[1]).write_text(block.text, encoding="utf-8")


# --- commands -------------------------------------------------------------------------------------


def commands(text: str) -> Iterator[tuple[str, list[str]]]:
    """Yield each command of a console block, and the lines it is said to print."""
    command, printed = "", list[str]()
    for line in text.splitlines():
        if line.startswith("$ "):
            if command:
                yield command, printed
            command, printed = line.removeprefix("$ "), []
        else:
            printed.append(line)
    yield command, printed


def same_word(told: str, actual: str) -> bool:
    """Tell whether two words are alike; numbers may differ in the last digits."""
    try:
        return math.isclose(float(told.strip("(),")), float(actual.strip("(),")), rel_tol=2e-3)
    except ValueError:
        return told == actual


def same_line(told: str, actual: str) -> bool:
    a, b = told.split(), actual.split()
    return len(a) == len(b) and all(map(same_word, a, b))


def first_difference(told: list[str], actual: list[str]) -> str | None:
    """Return the first line that is told and not printed; None if all are, in this order."""
    position, skipping = 0, False
    for line in told:
        if line == "...":
            skipping = True
            continue
        while skipping and position < len(actual) and not same_line(line, actual[position]):
            position += 1
        if position == len(actual) or not same_line(line, actual[position]):
            return line
        position, skipping = position + 1, False
    return None if skipping or position == len(actual) else actual[position]


def run(command: str, folder: Path, environment: dict[str, str]) -> list[str]:
    if command.startswith("make "):
        # What it would do is enough: it would run these tests, or take minutes.
        folder, command = ROOT, f"make --dry-run {command.removeprefix('make ')}"
    done = subprocess.run(
        ["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, f"{command}\n{done.stderr}"
    return [] if command.startswith("make ") else done.stdout.splitlines()


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_commands_run_and_print_what_is_told(
    page: Path, tmp_path: Path, environment: dict[str, str]
) -> None:
    write_files(page, tmp_path)
    for block in blocks(page, "console"):
        for command, told in commands(block.text):
            printed = run(command, tmp_path, environment)
            if told:
                assert first_difference(told, printed) is None, command


def test_commands_in_running_text_work(tmp_path: Path, environment: dict[str, str]) -> None:
    for page in PAGES:
        for command in re.findall(r"`(eval [^`]+|stiffkit \w+ >[^`]+)`", page.read_text("utf-8")):
            run(command, tmp_path, environment)


def test_a_difference_is_found() -> None:
    assert first_difference(["a 1", "...", "d"], ["a 1.0001", "b", "c", "d"]) is None
    assert first_difference(["a 1", "..."], ["a 1.1"]) == "a 1"
    assert first_difference(["a", "c"], ["a", "b", "c"]) == "c"
    assert first_difference(["a"], ["a", "b"]) == "b"


# --- Python ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_python_runs(page: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    code = "\n".join(block.text for block in blocks(page, "python"))
    if not code:
        return
    write_files(page, tmp_path)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


# --- robot files and specifications ---------------------------------------------------------------


def completed(fragment: Node) -> Node:
    """Return a fragment of a robot file with the sections that every file must have."""
    assert isinstance(fragment.value, dict)
    robot = Node("Fragment", 1)
    tool = Node({"at": Node("link", 1)}, 1)
    return Node({"robot": robot, "tool": tool, **fragment.value}, 1)


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_files_load(page: Path, tmp_path: Path) -> None:
    write_files(page, tmp_path)
    for block in blocks(page, "yaml"):
        root = read_tree(Source(page, block.text, ""))
        if root.child("identify") is not None:
            check_shape(root, page, SPEC_SCHEMA_FILE)
        elif root.child("cad") is not None:
            check_shape(root, page, CAD_SCHEMA_FILE)
        elif root.child("design") is not None:
            check_shape(root, page, DESIGN_SCHEMA_FILE)
        elif root.child("uncertainty") is not None:
            check_shape(root, page, UNCERTAINTY_SCHEMA_FILE)
        elif root.child("study") is not None:
            check_shape(root, page, STUDY_SCHEMA_FILE)
        elif named := _FILE.match(block.text):
            assert load_robot(tmp_path / named[1]).links
        else:
            check_shape(completed(root), page, SCHEMA_FILE)


def with_the_rest(fragment: dict[str, Any]) -> dict[str, Any]:
    """Return a fragment with the links and joints that it speaks of, as simple as can be."""
    bodies = {"anchor": {"rigid": {}}, **fragment.get("links", {})}
    joints = {
        f"weld_{name}": {"fixed": True, "from": "base", "to": name}
        for name in bodies
        if "joints" not in fragment or name == "anchor"
    }
    for joint in fragment.get("joints", {}).values():
        for end in (joint["from"], joint["to"]):
            name = end.partition(".")[0]
            if name != "base":
                bodies.setdefault(name, {"rigid": {"length": "300 mm"}})
    joints |= fragment.get("joints", {})
    head = {"robot": "Fragment", "tool": {"at": "anchor"}}
    return {**head, **fragment, "links": bodies, "joints": joints}


def test_sections_of_the_reference_load(tmp_path: Path) -> None:
    """Beyond their shape: quantities, names, matrices and repairs are read too."""
    loaded = 0
    for block in blocks(ROOT / "docs" / "robot-file.md", "yaml"):
        fragment = yaml.safe_load(block.text)
        if {"tool", "home"} & fragment.keys():
            continue
        path = tmp_path / "fragment.yaml"
        path.write_text(yaml.safe_dump(with_the_rest(fragment)), encoding="utf-8")
        assert load_robot(path).links
        loaded += 1
    assert loaded >= 8


# --- nothing is left out --------------------------------------------------------------------------


def text_of(name: str) -> str:
    return (ROOT / name).read_text("utf-8")


def keys_of(node: Any) -> set[str]:
    """Return all keys that a JSON Schema knows."""
    if isinstance(node, list):
        return set().union(*map(keys_of, node)) if node else set()
    if not isinstance(node, dict):
        return set()
    own = set(node["properties"]) if isinstance(node.get("properties"), dict) else set()
    return own.union(*map(keys_of, node.values())) if node else own


def test_the_reference_has_every_key_kind_and_material() -> None:
    text = text_of("docs/robot-file.md")
    keys = keys_of(json.loads(SCHEMA_FILE.read_text("utf-8")))
    for word in keys | set(KINDS) | set(MATERIALS):
        assert re.search(rf"\b{word}\b", text), word


def test_the_reference_of_specifications_has_every_key() -> None:
    text = text_of("docs/identify.md")
    for word in keys_of(json.loads(SPEC_SCHEMA_FILE.read_text("utf-8"))):
        assert re.search(rf"\b{word}\b", text), word


def test_the_reference_of_parts_has_every_key() -> None:
    text = text_of("docs/cad.md")
    for word in keys_of(json.loads(CAD_SCHEMA_FILE.read_text("utf-8"))):
        assert re.search(rf"\b{word}\b", text), word


def test_the_reference_of_studies_has_every_key_and_quantity() -> None:
    text = text_of("docs/studies.md")
    for word in keys_of(json.loads(STUDY_SCHEMA_FILE.read_text("utf-8"))) | set(QUANTITIES):
        assert re.search(rf"\b{word}\b", text), word


def test_the_reference_of_designs_has_every_key() -> None:
    text = text_of("docs/design.md")
    for word in keys_of(json.loads(DESIGN_SCHEMA_FILE.read_text("utf-8"))):
        assert re.search(rf"\b{word}\b", text), word


def test_the_reference_of_uncertainty_has_every_key() -> None:
    text = text_of("docs/uncertainty.md")
    for word in keys_of(json.loads(UNCERTAINTY_SCHEMA_FILE.read_text("utf-8"))):
        assert re.search(rf"\b{word}\b", text), word


def test_the_readme_has_every_robot() -> None:
    for name in list_robots():
        assert name in text_of("README.md"), name


def test_the_architecture_has_every_room_and_dependency() -> None:
    text = text_of("docs/architecture.md")
    for room in ROOMS:
        assert f"`{room}`" in text, room
    project = tomllib.loads(text_of("pyproject.toml"))["project"]
    extras = project["optional-dependencies"].values()
    needed = [*project["dependencies"], *(one for extra in extras for one in extra)]
    for requirement in needed:
        name = re.split(r"[>=<;\s\[]", requirement)[0]
        assert name == "stiffkit" or re.search(rf"\b{name}\b", text), name


# --- links ----------------------------------------------------------------------------------------


def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub gives the headings of a page."""
    headings = _HEADING.findall(_BLOCK.sub("", page.read_text("utf-8")))
    plain = [re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings]
    return {heading.replace(" ", "-") for heading in plain}


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_links_lead_somewhere(page: Path) -> None:
    for target in _LINK.findall(_BLOCK.sub("", page.read_text("utf-8"))):
        if target.startswith("https://"):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.is_file(), target
        assert not anchor or anchor in anchors(file), target


def test_pictures_are_small() -> None:
    for picture in ROOT.glob("docs/figures/*"):
        assert picture.stat().st_size <= 300_000, picture
