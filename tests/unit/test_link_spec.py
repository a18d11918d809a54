"""Specifications of links from CAD, and the cache of their solutions; no part is solved here."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from stiffkit.errors import FileError
from stiffkit.fea import Orthotropic, cache, cad_link, read_link_spec
from stiffkit.fea.link_spec import SCHEMA_FILE, LinkSpec
from stiffkit.fea.sources import CadFile
from stiffkit.link import Material
from stiffkit.robot.loader import SCHEMA_FILE as ROBOT_SCHEMA_FILE

SPEC = """\
link: Foot
cad: foot.step
material: aluminium
base: {faces: {near: [0, 5 mm, 5 mm]}, interface: clamped}
tip: {faces: {name: flange}, interface: average, at: [100 mm, 0, 0], rotate: {z: 90 deg}}
tolerance: 0.2 %
"""


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give each test a cache of its own, and a file that is named like a part."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "foot.step").write_text("no part, but nobody reads it here", encoding="utf-8")
    return tmp_path


def spec_of(place: Path, text: str = SPEC) -> LinkSpec:
    path = place / "foot.yaml"
    path.write_text(text, encoding="utf-8")
    return read_link_spec(path)


def test_a_specification_is_read_in_si(place: Path) -> None:
    spec = spec_of(place)
    assert (spec.name, spec.title, spec.cad) == ("foot", "Foot", CadFile(place / "foot.step"))
    assert isinstance(spec.material, Material)
    assert spec.material.E == 70e9
    assert spec.base.picks[0].near == ((0.0, 0.005, 0.005),)
    assert (spec.base.kind, spec.base.point, spec.base.axes) == ("clamped", None, None)
    (_, (name, tip)) = spec.ports
    assert (name, tip.picks[0].names, tip.picks[0].count) == ("tip", ("flange",), 1)
    assert tip.point == (0.1, 0.0, 0.0)
    assert tip.axes is not None
    np.testing.assert_allclose(tip.axes[:, 0], [0.0, 1.0, 0.0], atol=1e-15)
    assert spec.tolerance == pytest.approx(2e-3)
    assert (spec.n_modes, spec.mesh, spec.scale, spec.features) == (6, None, None, None)


def test_small_features_may_be_told_from_others(place: Path) -> None:
    assert spec_of(place, SPEC + "features: 0.5 mm\n").features == pytest.approx(5e-4)


def test_faces_may_be_several_descriptions_with_counts(place: Path) -> None:
    faces = "[{kind: cylinder, count: 4}, {name: 'boss*', count: any}, {number: 7}]"
    picks = spec_of(place, SPEC.replace("{name: flange}", faces)).ports[1][1].picks
    assert [pick.count for pick in picks] == [4, None, 1]
    assert picks[2].indices == (7,)


TIP = SPEC.splitlines()[4] + "\n"
PORTS = """\
ports:
  left: {faces: {name: left}, interface: average}
  right: {faces: {name: right}, interface: rigid, at: [0, 50 mm, 0]}
"""


def test_ports_stand_in_the_place_of_the_tip(place: Path) -> None:
    spec = spec_of(place, SPEC.replace(TIP, PORTS))
    assert [name for name, _ in spec.ports] == ["base", "left", "right"]
    assert spec.ports[0][1] is spec.base
    assert [port.kind for _, port in spec.ports] == ["clamped", "average", "rigid"]
    assert spec.ports[2][1].point == (0.0, 0.05, 0.0)
    swapped = PORTS.splitlines(keepends=True)
    swapped[1:] = swapped[:0:-1]
    other = spec_of(place, SPEC.replace(TIP, "".join(swapped)))
    assert [name for name, _ in other.ports] == ["base", "right", "left"]
    assert key_of(spec) != key_of(other)


@pytest.mark.parametrize(
    ("text", "key", "told"),
    [
        (SPEC + PORTS, "", "'tip' and 'ports' are both given"),
        (SPEC.replace(TIP, ""), "", "neither 'tip' nor 'ports' is given"),
        (SPEC.replace(TIP, PORTS.replace("left:", "base:")), "ports.base", "which is held"),
        (SPEC.replace(TIP, PORTS.replace("right:", "left:")), "ports", "a second time"),
        (SPEC.replace(TIP, PORTS.replace("left:", "le.ft:")), "ports", "not allowed here"),
        (SPEC.replace(TIP, "ports: {}\n"), "ports", "nothing is given"),
    ],
)
def test_ports_that_cannot_be(place: Path, text: str, key: str, told: str) -> None:
    with pytest.raises(FileError, match=told) as caught:
        spec_of(place, text)
    assert caught.value.key.startswith(key)


def test_an_orthotropic_material_is_read(place: Path) -> None:
    material = (
        "{E: [10 GPa, 5 GPa, 4 GPa], nu: [0.3, 0.3, 0.3], G: [3 GPa, 3 GPa, 2 GPa], "
        "density: 1500, axes: {z: 90 deg}}"
    )
    law = spec_of(place, SPEC.replace("aluminium", material)).material
    assert isinstance(law, Orthotropic)
    assert (law.E1, law.nu23, law.G23, law.density) == (10e9, 0.3, 2e9, 1500.0)
    # Axis 1 lies along the part's y.
    assert law.stiffness()[1, 1] > 1.5 * law.stiffness()[0, 0]


@pytest.mark.parametrize(
    ("old", "new", "key", "told"),
    [
        ("foot.step", "none.step", "cad", "there is no file"),
        ("foot.step", "foot.yaml", "cad", "not the name of a CAD file"),
        ("aluminium", "alu", "material", "there is no material 'alu'"),
        ("aluminium", "{E: 70 GPa, nu: 0.5, density: 2700}", "material", "between -1 and 0.5"),
        ("aluminium", "{E: -1 GPa, nu: 0.3, density: 2700}", "material.E", "must be positive"),
        ("aluminium", "{E: 70 GPa, nu: 0.3, density: 2700, G: [1, 1, 1]}", "material.G", "one num"),
        ("average", "loose", "tip.interface", "one of clamped, rigid, average"),
        ("0.2 %", "0 %", "tolerance", "between 0 and 50 %"),
        ("{name: flange}", "{name: flange, count: 1.5}", "tip.faces.count", "whole number"),
        ("{name: flange}", "{nam: flange}", "tip.faces.nam", "unknown key"),
        ("tolerance: 0.2 %", "mesh: {size: 5 mm, order: 9}", "mesh.order", "from 1 to 8"),
        ("tolerance: 0.2 %", "modes: 1000", "modes", "from 0 to 100"),
        ("tolerance: 0.2 %", "features: 0 mm", "features", "positive"),
    ],
)
def test_what_is_wrong_is_told_at_its_key(
    place: Path, old: str, new: str, key: str, told: str
) -> None:
    with pytest.raises(FileError, match=told) as caught:
        spec_of(place, SPEC.replace(old, new))
    assert caught.value.key == key


def test_robot_files_describe_parts_alike() -> None:
    own = json.loads(SCHEMA_FILE.read_text("utf-8"))
    robot = json.loads(ROBOT_SCHEMA_FILE.read_text("utf-8"))["$defs"]
    for name in (
        "cad_material",
        "interface",
        "faces",
        "face",
        "mesh",
        "beam_chain",
        "beam_piece",
        "section",
    ):
        assert robot[name] == own["$defs"][name], name
    inline = dict(robot["cad"]["properties"])
    # A file that stands alone has no parameters to follow.
    assert all(inline.pop(key) for key in ("file", "part", "dimensions", "between"))
    assert inline == {k: v for k, v in own["properties"].items() if k not in ("link", "cad")}


# --- cache ----------------------------------------------------------------------------------------


def key_of(spec: LinkSpec) -> str:
    return cad_link._key(spec, "hash of the part")


def test_whatever_changes_the_result_changes_the_key(place: Path) -> None:
    first = key_of(spec_of(place))
    assert key_of(spec_of(place, SPEC.replace("link: Foot", "link: Same foot"))) == first
    assert key_of(spec_of(place, SPEC.replace("aluminium", MATERIAL))) != first
    changes = [
        ("material: aluminium", "material: steel"),
        ("clamped", "average"),
        ("[0, 5 mm, 5 mm]", "[0, 5 mm, 6 mm]"),
        ("at: [100 mm", "at: [101 mm"),
        ("90 deg", "91 deg"),
        ("0.2 %", "0.1 %"),
        ("tolerance", "modes: 4\ntolerance"),
        ("tolerance", "scale: 2\ntolerance"),
        ("tolerance", "features: 1 mm\ntolerance"),
        ("tolerance", "up: [0, 1, 0]\ntolerance"),
    ]
    keys = {key_of(spec_of(place, SPEC.replace(old, new))) for old, new in changes}
    assert len(keys | {first}) == len(changes) + 1
    assert cad_link._key(spec_of(place), "another part") != first


MATERIAL = "{E: 70 GPa, nu: 0.3, density: 2701}"


def test_what_is_kept_comes_back(place: Path) -> None:
    matrix = np.random.default_rng(1).standard_normal((6, 6))
    assert cache.keep("abc", {"mass": 0.1, "why": None}, {"k": matrix}) == ""
    found = cache.load("abc")
    assert found is not None
    assert found[0] == {"mass": 0.1, "why": None}
    np.testing.assert_array_equal(found[1]["k"], matrix)
    assert cache.load("abd") is None


def test_a_part_of_a_file_is_no_result(place: Path) -> None:
    cache.keep("abc", {}, {"k": np.eye(6)})
    (path,) = (place / "cache" / "stiffkit" / "links").iterdir()
    whole = path.read_bytes()
    for size in (0, 10, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:size])
        assert cache.load("abc") is None, size


def test_an_interrupted_write_leaves_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "savez_compressed", interrupted)
    with pytest.raises(KeyboardInterrupt):
        cache.keep("abc", {}, {"k": np.eye(6)})
    assert list((place / "cache" / "stiffkit" / "links").iterdir()) == []


def test_a_cache_that_cannot_be_written_is_told(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (place / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("XDG_CACHE_HOME", str(place / "file"))
    assert "cannot be written" in cache.keep("abc", {}, {})
    assert cache.load("abc") is None
