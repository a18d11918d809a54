from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.unit.page_reader import unpacked

from stiffkit.errors import OutputError
from stiffkit.plots import mode_figure, write_mode_figures
from stiffkit.report import write_modes_page
from stiffkit.robot import load_robot
from stiffkit.spatial import exp_rotation
from stiffkit.study import ModesResult, analyse_modes
from stiffkit.vibration import SHOWN, ModesDrawing
from stiffkit.vibration.curve import bent_line, outline

Array = NDArray[np.float64]


def result_of(name: str) -> ModesResult:
    return analyse_modes(load_robot(name), n=3)


@pytest.fixture(scope="module")
def biglide() -> ModesResult:
    return result_of("biglide")


@pytest.fixture(scope="module")
def hexapod() -> ModesResult:
    return result_of("hexapod-cubic")


def drawing_of(result: ModesResult) -> ModesDrawing:
    assert result.drawing is not None
    return result.drawing


def all_moved(drawing: ModesDrawing) -> Array:
    """Return displacements (n_modes, m, 3) of all points."""
    paths = [path for link in drawing.links for path in link.paths]
    paths += [joint.guide for joint in drawing.joints if joint.guide is not None]
    marks = np.stack([*[joint.moved for joint in drawing.joints], drawing.tool_moved], axis=1)
    return np.concatenate([*[path.moved for path in paths], marks], axis=1)


# Geometry.


@pytest.mark.parametrize("which", ["biglide", "hexapod"])
def test_largest_displacement_is_the_stated_one(which: str, request: pytest.FixtureRequest) -> None:
    drawing = drawing_of(request.getfixturevalue(which))
    largest = np.linalg.norm(all_moved(drawing), axis=2).max(axis=1)
    assert largest == pytest.approx(np.full(3, SHOWN * drawing.size))


def test_links_meet_at_their_joints_in_every_mode(biglide: ModesResult) -> None:
    drawing = drawing_of(biglide)
    legs = {link.name: link.paths[0] for link in drawing.links if link.name.startswith("leg")}
    joints = {joint.name: joint for joint in drawing.joints}
    for leg, path in legs.items():
        hinge = joints[f"hinge_{leg[-1]}"]
        assert path.rest[0] == pytest.approx(hinge.position, abs=1e-9)
        assert path.moved[:, 0] == pytest.approx(hinge.moved, abs=1e-9)
        assert path.rest[-1] == pytest.approx(drawing.tool, abs=1e-9)
        assert path.moved[:, -1] == pytest.approx(drawing.tool_moved, abs=1e-9)


def test_tool_moves_as_the_modes_say(biglide: ModesResult) -> None:
    for moved, mode in zip(drawing_of(biglide).tool_moved, biglide.modes, strict=True):
        along = mode.tool[:3] / np.linalg.norm(mode.tool[:3])
        assert moved / np.linalg.norm(moved) == pytest.approx(along, abs=1e-9)


def test_plane_of_a_flat_robot(biglide: ModesResult) -> None:
    drawing = drawing_of(biglide)
    assert drawing.normal is not None
    assert drawing.normal.tolist() == [0.0, 0.0, 1.0]
    # The first mode leaves the plane, the second one does not.
    assert drawing.plane(0) is None
    assert drawing.plane(1) == (0, 1)
    assert drawing.out_of_plane[0] == pytest.approx(1.0, abs=1e-3)


def test_robot_in_space_has_no_plane(hexapod: ModesResult) -> None:
    drawing = drawing_of(hexapod)
    assert drawing.normal is None
    assert drawing.plane(0) is None
    assert not drawing.out_of_plane.any()


def test_rigid_platform_stays_rigid(hexapod: ModesResult) -> None:
    drawing = drawing_of(hexapod)
    platform = next(link for link in drawing.links if link.name == "platform")
    assert not platform.elastic
    rim = platform.paths[0]
    assert len(rim.rest) == 4  # a closed triangle: the ball joints meet in pairs
    for moved in rim.moved:
        # Small displacements keep each side's length to first order.
        sides, change = np.diff(rim.rest, axis=0), np.diff(moved, axis=0)
        assert np.abs((sides * change).sum(axis=1)).max() < 1e-9


def test_links_are_drawn_bent_as_their_own_modes_bend_them() -> None:
    """The drawn motion has the modes' modal mass of one, in high modes too."""
    robot = load_robot("five-bar")
    result = analyse_modes(robot, n=6)
    drawing = drawing_of(result)
    for i, mode in enumerate(result.modes):
        if drawing.tool_shares[i] < 0.05:
            continue  # the tool stands still and tells no scale
        scale = np.linalg.norm(drawing.tool_moved[i]) / np.linalg.norm(mode.tool[:3])
        momentum = (robot.tool.mass or 0.0) * np.sum(drawing.tool_moved[i] ** 2)
        for link in drawing.links:
            squares = np.sum(link.paths[0].moved[i] ** 2, axis=1)
            momentum += (robot.links[link.name].mass or 0.0) * np.trapezoid(squares, dx=1 / 24)
        # What is left is that of turning sections.
        assert momentum == pytest.approx(scale**2, rel=0.04)


def test_drawing_turns_with_the_robot(tmp_path: Path) -> None:
    text = (Path(load_robot("five-bar").source or "")).read_text(encoding="utf-8")
    turned_text = text.replace("at: [= -base/2, 0, 0]", "at: [0, = -base/2, 0]").replace(
        "at: [= base/2, 0, 0]", "at: [0, = base/2, 0]"
    )
    turned_text = turned_text.replace(
        "home: {x: 0, y: 400 mm,", "home: {x: -400 mm, y: 0,"
    ).replace(
        "workspace: {x: [-150 mm, 150 mm], y: [300 mm, 450 mm]}",
        "workspace: {x: [-450 mm, -300 mm], y: [-150 mm, 150 mm]}",
    )
    path = tmp_path / "turned.yaml"
    path.write_text(turned_text, encoding="utf-8")
    plain, turned = (
        drawing_of(result_of("five-bar")),
        drawing_of(analyse_modes(load_robot(path), n=3)),
    )
    R = exp_rotation([0.0, 0.0, np.pi / 2])
    assert turned.tool == pytest.approx(R @ plain.tool, abs=1e-9)
    assert turned.size == pytest.approx(plain.size)
    assert turned.tool_shares == pytest.approx(plain.tool_shares, abs=1e-9)


def test_bent_line_is_exact_for_a_cubic() -> None:
    along = np.array([1.0, 0.0, 0.0])
    s = np.array([0.0, 0.3, 1.0])
    # y = s^3, z = s^2, and a stretch of 0.1 s: turns are about z for y, about -y for z.
    twists = np.stack([0.1 * s, s**3, s**2, np.zeros(3), -2.0 * s, 3.0 * s**2], axis=1)[..., None]
    shares, moved = bent_line(s, twists, along)
    assert moved[0] == pytest.approx(
        np.stack([0.1 * shares, shares**3, shares**2], axis=1), abs=1e-12
    )


def test_outline_of_points() -> None:
    a, b, c, d = (np.array(p, dtype=float) for p in ((0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)))
    assert outline([a, a + 1e-9], 1e-6) == []
    assert outline([a, b], 1e-6)[0].shape == (2, 3)
    (square,) = outline([a, b, c, d], 1e-6)
    assert np.linalg.norm(np.diff(square, axis=0), axis=1) == pytest.approx(np.ones(4))
    (line,) = outline([a, 3 * b, b], 1e-6)
    assert sorted([line.tolist(), line[::-1].tolist()])[0] == [[0, 0, 0], [1, 1, 0], [3, 3, 0]]


# Stills.


def test_flat_modes_are_drawn_flat_and_others_in_space(biglide: ModesResult) -> None:
    drawing = drawing_of(biglide)
    space, plane = (mode_figure(drawing, i, 100.0, "words") for i in (0, 1))
    assert space.axes[0].name == "3d"
    assert plane.axes[0].name == "rectilinear"
    assert plane.axes[0].get_aspect() == 1.0
    assert plane.axes[0].get_xlabel() == "x (mm)"


def test_still_tells_frequency_and_words_as_plain_text(biglide: ModesResult) -> None:
    figure = mode_figure(drawing_of(biglide), 1, 134.01, "tool moves along $x^2$")
    assert figure.get_suptitle() == "Mode 2, 134 Hz\ntool moves along $x^2$"
    figure.canvas.draw()


def test_stills_are_the_same_in_every_run(biglide: ModesResult, tmp_path: Path) -> None:
    words = [mode.description for mode in biglide.modes]
    runs = [
        write_mode_figures(drawing_of(biglide), biglide.frequencies_hz, words, tmp_path / name)
        for name in "ab"
    ]
    assert [path.name for path in runs[0]] == [
        f"mode-{i}.{kind}" for i in (1, 2, 3) for kind in ("svg", "png")
    ]
    for first, second in zip(*runs, strict=True):
        assert first.read_bytes() == second.read_bytes()


# The page.


class Reader(HTMLParser):
    """Collects what a page asks for, and the data in it."""

    def __init__(self) -> None:
        super().__init__()
        self.outside: list[str] = []
        self.policy = ""
        self.data = ""
        self._is_data = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.outside += [str(given[name]) for name in ("src", "href") if name in given]
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = str(given["content"])
        self._is_data = given.get("id") == "data"

    def handle_data(self, data: str) -> None:
        if self._is_data:
            self.data += data
            self._is_data = False


def page_of(result: ModesResult, tmp_path: Path) -> str:
    path = tmp_path / "modes.html"
    write_modes_page(result, path)
    return path.read_text(encoding="utf-8")


def test_page_is_self_contained(biglide: ModesResult, tmp_path: Path) -> None:
    page = page_of(biglide, tmp_path)
    reader = Reader()
    reader.feed(page)
    assert reader.outside == []
    assert "default-src 'none'" in reader.policy
    assert "unsafe-eval" not in reader.policy
    assert re.findall(r"https?://", page) == []
    assert len(page) < 100_000


def test_page_holds_the_drawing(biglide: ModesResult, tmp_path: Path) -> None:
    reader = Reader()
    reader.feed(page_of(biglide, tmp_path))
    data = json.loads(unpacked(reader.data))
    drawing = drawing_of(biglide)
    assert [mode["frequency"] for mode in data["modes"]] == ["97.43", "134", "176"]
    assert [mode["view"] for mode in data["modes"]] == ["space", "xy", "space"]
    assert data["modes"][0]["energy"][0][0] == "foot_2"
    assert data["tool"]["at"] == pytest.approx(drawing.tool.tolist(), abs=1e-6)
    for line in data["lines"]:
        assert np.shape(line["moved"]) == (3, *np.shape(line["rest"]))
    assert len(data["joints"]) == 5


def test_page_escapes_what_the_robot_file_says(biglide: ModesResult, tmp_path: Path) -> None:
    evil = "</script><img src=x onerror=alert(1)>"
    mode = replace(biglide.modes[0], description=evil, energy_shares={evil: 1.0})
    page = page_of(
        replace(
            biglide,
            title=evil,
            rules={evil: evil},
            notes=(evil,),
            free_motions=(evil,),
            modes=(mode, *biglide.modes[1:]),
        ),
        tmp_path,
    )
    assert evil not in page
    assert "<img" not in page
    assert page.count("</script>") == 2


def test_no_modes_no_page(tmp_path: Path) -> None:
    nowhere = analyse_modes(load_robot("biglide"), {"x": 3.0})
    with pytest.raises(OutputError, match="no mode"):
        write_modes_page(nowhere, tmp_path / "modes.html")
    assert list(tmp_path.iterdir()) == []


def test_page_that_cannot_be_written(biglide: ModesResult, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot write"):
        write_modes_page(biglide, tmp_path / "missing" / "modes.html")
