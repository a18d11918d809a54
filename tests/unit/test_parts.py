"""Parametric parts: what they are made of, what they refuse, and how files name them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from stiffkit.cli.commands import main
from stiffkit.errors import CadError, FileError
from stiffkit.fea import (
    CadFile,
    PythonPart,
    RegisteredPart,
    link_from_cad,
    read_link_spec,
    read_step,
)
from stiffkit.fea.cad_link import _key
from stiffkit.fea.parts import PARTS, find_part

SPEC = """\
link: Foot
cad: {part: orthoglide-foot, dimensions: {length: 160 mm}}
material: {E: 70 GPa, nu: 0.346, density: 2700}
base: {faces: {name: carriage}, interface: clamped}
tip: {faces: {name: bearing}, interface: rigid}
"""


def spec_file(folder: Path, text: str = SPEC) -> Path:
    path = folder / "foot.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", PARTS)
def test_a_part_is_one_solid_with_its_named_faces(name: str) -> None:
    part = RegisteredPart(name).read(None)
    assert len(part.solids) == 1
    assert {face.name for face in part.faces} == {"", *find_part(name).faces}
    # No slivers: the shortest edge is not much shorter than the smallest dimension.
    smallest = min(RegisteredPart(name).dimensions.values())
    assert part.shortest_edges[0] > 0.3 * smallest


def volume(name: str, **dimensions: float) -> float:
    return RegisteredPart(name, dimensions).read(None).volume


def test_volumes_grow_as_the_sections_say() -> None:
    longer = volume("orthoglide-axle", length=0.060) - volume("orthoglide-axle")
    assert longer == pytest.approx(np.pi * 0.013**2 * 0.010, rel=1e-6)
    longer = volume("orthoglide-bar", length=0.330) - volume("orthoglide-bar")
    hollow = 16.4 * 10.0 - (16.4 - 5.7) * (10.0 - 5.7)
    assert longer == pytest.approx(hollow * 1e-6 * 0.020, rel=1e-6)
    longer = volume("orthoglide-foot", length=0.160) - volume("orthoglide-foot")
    assert longer == pytest.approx(16e-3 * 26e-3 * 0.010, rel=1e-6)


def test_pins_and_bearings_lie_where_the_dimensions_say() -> None:
    foot = RegisteredPart("orthoglide-foot", {"length": 0.160}).read(None)
    (bearing,) = (face for face in foot.faces if face.name == "bearing")
    np.testing.assert_allclose(bearing.centre, [0.160 / 2**0.5, 0, 0.160 / 2**0.5], atol=1e-9)
    assert bearing.radius == pytest.approx(0.012)
    bar = RegisteredPart("orthoglide-bar").read(None)
    tips = [face for face in bar.faces if face.name == "tip"]
    assert len(tips) == 2
    np.testing.assert_allclose(
        np.mean([face.centre for face in tips], axis=0), [0.31, 0, 0], atol=1e-9
    )


@pytest.mark.parametrize(
    ("name", "dimensions", "told"),
    [
        ("orthoglide-foo", {}, "no parametric part"),
        ("orthoglide-foot", {"lenth": 0.1}, "no dimension 'lenth'"),
        ("orthoglide-foot", {"length": -0.1}, "must be positive"),
        ("orthoglide-foot", {"length": float("nan")}, "must be positive"),
        ("orthoglide-foot", {"bore": 0.033}, "leaves less than 2 mm"),
        ("orthoglide-foot", {"width": 0.05}, "thicker than the ring"),
        ("orthoglide-foot", {"length": 0.03}, "no arm"),
        ("orthoglide-foot", {"plate_length": 0.05}, "do not fit onto a plate"),
        ("orthoglide-axle", {"journal": 0.025}, "no step"),
        ("orthoglide-axle", {"bore": 0.02}, "too little"),
        ("orthoglide-axle", {"overhang": 0.005}, "breaks out"),
        ("orthoglide-axle", {"seat": 0.045}, "meet"),
        ("orthoglide-end-effector", {"bore": 0.033}, "leaves less than 2 mm"),
        ("orthoglide-end-effector", {"seat": 0.03}, "meet"),
        ("orthoglide-end-effector", {"block": 0.028}, "does not hold"),
        ("orthoglide-end-effector", {"flange": 0.035}, "wider"),
        ("orthoglide-bar", {"wall": 0.005}, "no hole"),
        ("orthoglide-bar", {"bore": 0.021}, "does not fit into ends"),
        ("orthoglide-bar", {"reach": 0.006}, "does not fit into a reach"),
        ("orthoglide-bar", {"length": 0.06}, "no room for a tube"),
        ("orthoglide-bar", {"rounding": 0.014}, "do not fit into the fork"),
    ],
)
def test_impossible_dimensions_are_refused(
    name: str, dimensions: dict[str, float], told: str
) -> None:
    with pytest.raises(CadError, match=told) as caught:
        RegisteredPart(name, dimensions)
    assert caught.value.mend or "positive" in told


# --- in files -------------------------------------------------------------------------------------


def test_a_specification_names_a_part(tmp_path: Path) -> None:
    spec = read_link_spec(spec_file(tmp_path))
    assert isinstance(spec.cad, RegisteredPart)
    assert spec.cad.dimensions["length"] == pytest.approx(0.160)
    assert spec.cad.dimensions["bore"] == pytest.approx(0.024)


@pytest.mark.parametrize(
    ("old", "new", "key", "told"),
    [
        ("orthoglide-foot", "orthoglide-fot", "cad.part", "no parametric part"),
        ("length", "lenght", "cad.dimensions.lenght", "no dimension"),
        ("160 mm", "160 kg", "cad.dimensions.length", "length"),
        ("160 mm", "0", "cad.dimensions.length", "must be positive"),
        ("160 mm", "30 mm", "cad.dimensions", "no arm"),
        ("material:", "scale: 2\nmaterial:", "cad", "scale"),
    ],
)
def test_what_is_wrong_with_a_part_is_told_at_its_key(
    tmp_path: Path, old: str, new: str, key: str, told: str
) -> None:
    with pytest.raises(FileError, match=told) as caught:
        link_from_cad(spec_file(tmp_path, SPEC.replace(old, new, 1)))
    assert caught.value.key == key


def test_the_key_of_a_solution_holds_what_the_shape_depends_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def key_of(text: str) -> str:
        spec = read_link_spec(spec_file(tmp_path, text))
        return _key(spec, spec.cad.digest())

    first = key_of(SPEC)
    assert key_of(SPEC.replace("160 mm", "16 cm")) == first
    assert key_of(SPEC.replace("160 mm", "161 mm")) != first
    # The default, written out, is the default.
    named = SPEC.replace("{length: 160 mm}", "{length: 160 mm, bore: 24 mm}")
    assert key_of(named) == first
    newer = replace(PARTS["orthoglide-foot"], edition=2)
    monkeypatch.setitem(PARTS, "orthoglide-foot", newer)
    assert key_of(SPEC) != first


# --- a user's own function ------------------------------------------------------------------------

SCRIPT = """\
from netgen.occ import Box


def block(length):
    body = Box((0, 0, 0), (length, 10, 10))
    for face in body.faces:
        if face.center.x < 1e-6 or face.center.x > length - 1e-6:
            face.name = "base" if face.center.x < 1.0 else "tip"
    return body
"""

BLOCK = """\
link: Block
cad: block.step
material: steel
base: {faces: {name: base}, interface: clamped}
tip: {faces: {name: tip}, interface: average}
tolerance: 5 %
modes: 0
"""


def test_a_function_of_the_user_takes_the_place_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    script = tmp_path / "shapes.py"
    script.write_text(SCRIPT, encoding="utf-8")
    short, long = (
        link_from_cad(
            spec_file(tmp_path, BLOCK), part=PythonPart(script, "block", {"length": length})
        )
        for length in (50.0, 100.0)
    )
    assert short.solved.ports["tip"].position[0] == pytest.approx(0.05)
    # Bending is that of a beam, within a stubby beam's shear and the tolerance.
    ratio = long.compliance[1, 1] / short.compliance[1, 1]
    assert 7.0 < ratio < 8.0
    assert short.key != long.key
    again = link_from_cad(
        spec_file(tmp_path, BLOCK), part=PythonPart(script, "block", {"length": 50.0})
    )
    assert again.from_cache


# --- the command ----------------------------------------------------------------------------------


def run(*arguments: str) -> str:
    done = CliRunner().invoke(main, ["parts", *arguments])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


def test_the_command_lists_parts_and_dimensions() -> None:
    listed = run()
    assert [line.split()[0] for line in listed.splitlines()] == list(PARTS)
    shown = run("orthoglide-bar", "--set", "length=300mm")
    assert "300 mm  from pin to pin" in shown
    assert "inferred" in shown
    plain = json.loads(run("orthoglide-bar", "--json"))
    assert plain["dimensions"][0]["value"] == pytest.approx(0.31)
    assert set(plain["faces"]) == {"base", "tip"}


def test_the_command_writes_step(tmp_path: Path) -> None:
    path = tmp_path / "axle.step"
    run("orthoglide-axle", "--set", "length=60mm", "-o", str(path))
    part, same = read_step(path), RegisteredPart("orthoglide-axle", {"length": 0.06}).read(None)
    assert part.volume == pytest.approx(same.volume, rel=1e-9)
    assert {face.name for face in part.faces} == {face.name for face in same.faces}
    assert CadFile(path).digest() != same.digest


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--set", "length=1mm"], "no part is named"),
        (["orthoglide-ax"], "no parametric part"),
        (["orthoglide-axle", "--set", "lngth=1mm"], "no dimension"),
        (["orthoglide-axle", "--set", "length=1kg"], "length"),
    ],
)
def test_the_command_tells_what_is_wrong(arguments: list[str], told: str) -> None:
    with pytest.raises(Exception, match=told):
        run(*arguments)
