"""Link files: what is written comes back, what is wrong is told with its place."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.errors import FileError
from stiffkit.link import MATERIALS, beam_compliance, beam_line, rectangle
from stiffkit.link.file import SCHEMA_FILE, LinkFile, read_link_file, write_link_file
from stiffkit.link.superelement import Superelement, consistent_superelement
from stiffkit.robot import Robot, load_robot
from stiffkit.spatial import Frame, axis_rotation
from stiffkit.study import analyse_modes

Array = NDArray[np.float64]
Load = Callable[..., Robot]

LENGTH, SECTION, STEEL = 0.4, rectangle(0.02, 0.03), MATERIALS["steel"]
MASS = LENGTH * SECTION.area * STEEL.density
COMPLIANCE = beam_compliance(LENGTH, SECTION, STEEL)


@pytest.fixture
def element() -> Superelement:
    return consistent_superelement(beam_line(LENGTH, SECTION, STEEL, MASS), 8, 6)


def link_with(element: Superelement | None = None) -> LinkFile:
    return LinkFile("beam", {"tip": Frame.at(LENGTH)}, COMPLIANCE, superelement=element)


def message_of(path: Path) -> str:
    with pytest.raises(FileError) as error:
        read_link_file(path)
    assert str(error.value.path).startswith(str(path.parent))
    return str(error.value)


# --- round trips ----------------------------------------------------------------------------------


def test_everything_comes_back(tmp_path: Path, element: Superelement) -> None:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(36, 36))
    tip = Frame(axis_rotation("z", 0.4) @ axis_rotation("x", -1.1), np.array([0.4, 0.0, 0.0]))
    written = LinkFile(
        "a beam: with a colon",
        {"tip": tip},
        COMPLIANCE,
        covariance=1e-20 * root @ root.T,
        superelement=element,
        provenance={"program": "CalculiX 2.20", "nodes": 12345, "tolerance": 1e-3},
    )
    path = tmp_path / "beam.link.yaml"
    write_link_file(written, path)
    found = read_link_file(path)
    assert found.title == written.title
    np.testing.assert_array_equal(found.compliance, COMPLIANCE)
    assert written.covariance is not None
    assert found.covariance is not None
    np.testing.assert_array_equal(found.covariance, written.covariance)
    np.testing.assert_allclose(found.ports["tip"].rotation, tip.rotation, atol=1e-15)
    assert found.provenance == written.provenance
    assert found.notes == ()
    assert [p.name for p in tmp_path.iterdir()] == ["beam.link.yaml"]


def test_mass_without_a_superelement(tmp_path: Path) -> None:
    inertia = np.diag([1e-4, 2e-3, 2e-3])
    center = np.array([0.2, 0.01, 0.0])
    link = replace(link_with(), mass=1.5, center_of_mass=center, inertia=inertia)
    write_link_file(link, tmp_path / "beam.link.yaml")
    found = read_link_file(tmp_path / "beam.link.yaml")
    assert found.mass == 1.5
    assert found.center_of_mass is not None
    assert found.inertia is not None
    np.testing.assert_array_equal(found.center_of_mass, center)
    np.testing.assert_array_equal(found.inertia, inertia)


def test_the_superelement_has_its_own_mass(tmp_path: Path, element: Superelement) -> None:
    write_link_file(link_with(element), tmp_path / "beam.link.yaml")
    found = read_link_file(tmp_path / "beam.link.yaml")
    assert found.mass == pytest.approx(MASS, rel=1e-12)
    assert found.center_of_mass is not None
    assert found.inertia is not None
    np.testing.assert_allclose(found.center_of_mass, [LENGTH / 2.0, 0, 0], atol=1e-12)
    about_z = MASS * LENGTH**2 / 12.0 + STEEL.density * SECTION.Iz * LENGTH
    assert found.inertia[2, 2] == pytest.approx(about_z, rel=1e-9)


@pytest.mark.parametrize("form", ["inline", "csv", "mtx", "mm"])
def test_matrices_from_outside(tmp_path: Path, element: Superelement, form: str) -> None:
    """Coordinates inside are any: here they are mixed by a random matrix."""
    from scipy.io import mmwrite

    tip = np.array([LENGTH, 0.0, 0.0])
    K, M = element.stiffness(tip), element.mass
    mix = np.eye(len(K))
    mix[12:] = np.random.default_rng(0).normal(size=(len(K) - 12, len(K)))
    K, M = mix.T @ K @ mix, mix.T @ M @ mix
    K, M = (K + K.T) / 2.0, (M + M.T) / 2.0
    units = ""
    if form == "mm":
        scale = np.ones(len(K))
        scale[[0, 1, 2, 6, 7, 8]] = 1e-3
        K, M = (1e3 * A * np.outer(scale, scale) for A in (K, M))
        units = ", units: mm"
    names = json.dumps(K.tolist()), json.dumps(M.tolist())
    if form == "csv":
        for name, A in (("K.csv", K), ("M.csv", M)):
            np.savetxt(tmp_path / name, A, delimiter=",")
        names = "K.csv", "M.csv"
    if form == "mtx":
        for name, A in (("K.mtx", K), ("M.mtx", M)):
            mmwrite(tmp_path / name, A, precision=17)
        names = "K.mtx", "M.mtx"
    path = tmp_path / "beam.link.yaml"
    given = f"stiffness: {names[0]}, mass: {names[1]}, length: 400 mm{units}"
    path.write_text(f"link: beam\nsuperelement: {{{given}}}\n")
    found = read_link_file(path)
    assert found.superelement is not None
    size = np.sqrt(np.diag(COMPLIANCE))
    np.testing.assert_allclose(found.compliance / size, COMPLIANCE / size, atol=1e-9 * size.max())
    np.testing.assert_allclose(
        np.sort(found.superelement.mode_stiffness), np.sort(element.mode_stiffness), rtol=1e-7
    )
    assert found.mass == pytest.approx(MASS, rel=1e-9)


# --- in robots ------------------------------------------------------------------------------------


def five_bar(tmp_path: Path, link: str) -> Robot:
    source = load_robot("five-bar").source
    assert source is not None
    text = source.read_text("utf-8")
    line = next(line for line in text.splitlines() if line.strip().startswith("right_rod:"))
    path = tmp_path / "five-bar.yaml"
    path.write_text(text.replace(line, f"  right_rod: {link}"))
    return load_robot(path)


def test_a_robot_with_a_link_file_vibrates_like_the_beam(tmp_path: Path) -> None:
    beam = load_robot("five-bar").links["left_rod"]
    assert beam.line is not None
    assert beam.compliance is not None
    element = consistent_superelement(beam.line, 8, 6)
    link = LinkFile("rod", {"tip": beam.ports["tip"]}, beam.compliance, superelement=element)
    write_link_file(link, tmp_path / "rod.link.yaml")
    robot = five_bar(tmp_path, "{compliance: rod.link.yaml}")
    found = analyse_modes(robot, n=6)
    expected = analyse_modes(load_robot("five-bar"), n=6)
    np.testing.assert_allclose(found.frequencies_hz, expected.frequencies_hz, rtol=1e-9)
    assert "given superelement" in found.rules["right_rod"]
    assert robot.content_hash != load_robot("five-bar").content_hash


def test_the_robot_changes_with_the_link_file(tmp_path: Path) -> None:
    write_link_file(link_with(), tmp_path / "rod.link.yaml")
    before = five_bar(tmp_path, "{compliance: rod.link.yaml}").content_hash
    write_link_file(replace(link_with(), mass=2.0), tmp_path / "rod.link.yaml")
    assert five_bar(tmp_path, "{compliance: rod.link.yaml}").content_hash != before


@pytest.mark.parametrize(
    ("link", "words"),
    [
        ("{compliance: rods.link.yaml}", "there is no link file"),
        ("{compliance: rod.step}", "is not the name of a link file"),
        ("{compliance: heavy.link.yaml, mass: 3 kg}", "has a mass of its own"),
    ],
)
def test_what_robots_cannot_take(
    tmp_path: Path, element: Superelement, link: str, words: str
) -> None:
    write_link_file(link_with(element), tmp_path / "heavy.link.yaml")
    with pytest.raises(FileError, match=words) as error:
        five_bar(tmp_path, link)
    assert error.value.path.name == "five-bar.yaml"
    assert error.value.line
    assert "links.right_rod" in error.value.key


# --- bad files ------------------------------------------------------------------------------------

GOOD = "{matrix: " + json.dumps(COMPLIANCE.tolist()) + ", length: 400 mm}"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "begin with 'link: TITLE'"),
        ("link: x\n", "no elasticity"),
        (f"link: x\ncomplaince: {GOOD}\n", "did you mean 'compliance'"),
        ("link: x\ncompliance: {matrix: [[1]], length: 1}\n", "1 values, at least 6 are expected"),
        (f"link: x\ncompliance: {GOOD}\ncovariance: [[1, 2]]\n", "1 values, 36 are expected"),
        (f"link: x\ncompliance: {GOOD}\nmass: -1 kg\n", "must not be negative"),
        (f"link: x\ncompliance: {GOOD}\nmass: 1 m\n", "length"),
        (
            f"link: x\ncompliance: {GOOD}\nmass: 1\ninertia: [[1, 0, 0], [0, 1, 0], [0, 0, 9]]\n",
            "exceeds the sum",
        ),
        ("link: x\nsuperelement: {stiffness: K.mtx, mass: K.mtx, length: 1}\n", "cannot be read"),
        ("link: x\nsuperelement: {stiffness: no.csv, mass: no.csv, length: 1}\n", "as a matrix"),
        (f"link: x\ncompliance: {GOOD.replace(', length: 400 mm', '')}\n", "where the tip is"),
    ],
)
def test_bad_files(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "no.csv").write_text("these, are, words\n")
    path = tmp_path / "bad.link.yaml"
    path.write_text(text)
    assert words in message_of(path)


def write_matrices(folder: Path, K: Array, M: Array) -> Path:
    np.savetxt(folder / "K.csv", K)
    np.savetxt(folder / "M.csv", M)
    path = folder / "bad.link.yaml"
    path.write_text("link: x\nsuperelement: {stiffness: K.csv, mass: M.csv, length: 400 mm}\n")
    return path


def test_superelements_that_no_link_has(tmp_path: Path, element: Superelement) -> None:
    K, M = element.stiffness(np.array([LENGTH, 0, 0])), element.mass
    grounded = K.copy()
    grounded[0, 0] *= 1.5
    assert "resists a rigid motion" in message_of(write_matrices(tmp_path, grounded, M))
    order = np.r_[3:6, 0:3, 6 : len(K)]
    mixed = K[np.ix_(order, order)]
    assert "the order must be" in message_of(write_matrices(tmp_path, mixed, M))
    negative = M.copy()
    negative[13, 13] *= -1.0
    assert "is negative" in message_of(write_matrices(tmp_path, K, negative))
    skewed = K.copy()
    skewed[1, 5] *= 1.01
    assert "not symmetric" in message_of(write_matrices(tmp_path, skewed, M))
    loose = np.zeros_like(K)
    loose[12:, 12:] = K[12:, 12:]
    assert "does not hold its tip" in message_of(write_matrices(tmp_path, loose, M))
    assert "12" in message_of(write_matrices(tmp_path, K[:6, :6], M[:6, :6]))
    assert "entry 3,3 is nan" in message_of(
        write_matrices(tmp_path, np.where(np.eye(len(K)) * np.arange(len(K)) == 2, np.nan, K), M)
    )


def test_the_schema_is_the_robot_schema_where_they_say_the_same() -> None:
    from stiffkit.robot.loader import SCHEMA_FILE as ROBOT_SCHEMA

    link = json.loads(SCHEMA_FILE.read_text("utf-8"))["$defs"]
    robot = json.loads(ROBOT_SCHEMA.read_text("utf-8"))["$defs"]
    for name in ("quantity", "vector", "turn", "rotate", "frame", "repair", "entry"):
        assert link[name] == robot[name], name
