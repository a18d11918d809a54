"""Whatever is done to a valid file, it gives a robot or an error that a person can read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stiffkit.errors import FileError
from stiffkit.robot import load_robot

TEXT = """\
robot: Test
parameters: {base: 300 mm, half: = base/2, alpha: 1.5}
materials: {wood: {E: 10 GPa, nu: 0.3, density: 500 kg/m^3}}
links:
  arm: {beam: {length: = half, section: {tube: [40 mm, 4 mm]}, material: wood}, mass: 1 kg}
  copy: {like: arm}
  plate: {rigid: {ports: {p: {at: [1, 0, 0], rotate: {z: 30 deg}}}}, inertia: [[1,0,0],[0,1,0],[0,0,1]]}
  foot:
    compliance:
      matrix: [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,1]]
      units: mm
      length: 1
      repair: {symmetrize: true, entries: {"6,6": 2}}
repeat:
  - for: {k: [0, 1], phi: [0 deg, 180 deg]}
    links: {"rod_{k}": {rigid: {length: = base + k}}}
    joints: {"r_{k}": {revolute: y, from: arm.tip, rotate: {z: = phi}, to: "rod_{k}"}}
joints:
  motor: {revolute: z, from: base, at: [= -half, 0, 0], to: arm, drive: 2e4 N m/rad}
  a: {universal: [x, y], from: arm.tip, towards: [0, 0, 1], to: copy, drive: {rx: rigid}}
  b: {spherical: true, from: copy.tip, to: plate.p, elastic: {x: 1e7 N/m}}
  c: {planar: z, from: plate, to: foot.tip, to_at: [0, 1 mm, 0]}
tool: {at: plate.p, offset: [0, 0, -50 mm], mass: 1.5 kg}
home: {x: 0, a: [10 deg, 0], motor: -60 deg}
workspace: {polygon: [[0, 0], [1, 0], [0, 1]], z: [0, 1, 5]}
loads: {push: {force: [0, 100 N, 0], moment: [0, 0, 5 N m]}}
"""  # noqa: E501

SNIPPETS = (
    *("{", "}", "[", "]", ":", ",", "=", "-", "\n", " ", "\t", "#", "&a ", "*a", "!", '"', "'"),
    *("{k}", "1e400", "-1", "0", "nan", "1e-300", "99999999", "kg", "base", "rod_1", "~", "true"),
    *("\0", "\N{SUPERSCRIPT TWO}", "\ud7ff", "- ", "? ", "1e19", "1e-39"),
)
VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 1e300, 1e-300, 1e19, 1e-39, "", "x", "= base", "= 1/0", "base", "rod_0"),
    *("{k}", "1 kg", "rigid", "z", [], {}, [1], [1, 2, 3], {"x": 1}, {"like": "arm"}, "arm.tip"),
)


def load_or_refuse(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
    try:
        load_robot(path)
    except FileError as error:
        message = str(error)
    else:
        return
    assert 0 < len(message) < 10_000


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz") / "robot.yaml"


def test_the_file_itself_is_valid(path: Path) -> None:
    path.write_text(TEXT)
    assert len(load_robot(path).links) == 6


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    edits=st.lists(
        st.tuples(
            st.integers(0, len(TEXT)), st.integers(0, 8), st.sampled_from(SNIPPETS) | st.text()
        ),
        min_size=1,
        max_size=3,
    )
)
def test_edits_of_the_text(path: Path, edits: list[tuple[int, int, str]]) -> None:
    text = TEXT
    for start, length, new in edits:
        text = text[:start] + new + text[start + length :]
    load_or_refuse(path, text.encode("utf-8", "replace").decode("utf-8"))


Keys = tuple[str | int, ...]


def children(value: Any) -> list[tuple[str | int, Any]]:
    if isinstance(value, dict):
        return list(value.items())
    return list(enumerate(value)) if isinstance(value, list) else []


def places(value: Any, keys: Keys = ()) -> Iterator[Keys]:
    for key, child in children(value):
        yield (*keys, key)
        yield from places(child, (*keys, key))


PLACES = list(places(yaml.safe_load(TEXT)))


def change(value: Any, keys: Keys, new: object) -> Any:
    """Return the data with another value at a place, if the place is still there."""
    if not keys:
        return new
    for key, child in children(value):
        if key == keys[0]:
            value[key] = change(child, keys[1:], new)
    return value


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    changes=st.lists(
        st.tuples(st.sampled_from(PLACES), st.sampled_from(VALUES)), min_size=1, max_size=2
    )
)
def test_changes_of_values(path: Path, changes: list[tuple[Keys, object]]) -> None:
    data = yaml.safe_load(TEXT)
    for keys, new in changes:
        data = change(data, keys, new)
    load_or_refuse(path, yaml.safe_dump(data, sort_keys=False))
