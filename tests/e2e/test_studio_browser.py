"""The studio as a person has it: looked at and moved in a real browser."""

from __future__ import annotations

import http.client
import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from playwright.sync_api import Browser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from stiffkit.robot import load_robot
from stiffkit.studio import Studio, open_studio

from .studio_page import StudioPage, browser, studio


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="module")
def five_bar(folder: Path) -> Iterator[Studio]:
    given = {"base": "290 mm"}
    running = open_studio("five-bar", given, folder=folder, points=2000, port=0)
    try:
        yield running
    finally:
        running.close()


@pytest.fixture(scope="module")
def opened(chromium: Browser, five_bar: Studio) -> Iterator[StudioPage]:
    page = StudioPage(chromium, five_bar.address)
    yield page
    page.page.close()
    assert page.errors == []


@pytest.fixture
def page(opened: StudioPage) -> StudioPage:
    """Return the page, with the robot as it is in its file."""
    opened.tab("Robot")
    opened.button("as in the file")
    opened.button("home")
    opened.settled()
    return opened


DEFLECTION = r"deflection\s+([\d.]+) µm"


def test_sliders_begin_where_they_are_told(opened: StudioPage) -> None:
    assert opened.slider_value("base (mm)") == 290.0


def test_the_tool_moves_where_it_is_typed(page: StudioPage) -> None:
    page.expect(DEFLECTION, 240.9)
    page.type("y (mm)", "320")
    page.expect(DEFLECTION, lambda value: value > 300.0)
    page.button("home")
    page.expect(DEFLECTION, 240.9)


def test_the_tool_is_dragged_with_the_mouse(page: StudioPage) -> None:
    page.drag_handle(40, 0)
    page.wait_until(lambda: abs(float(page.value("x (mm)"))) > 5.0)
    assert float(page.value("y (mm)")) == pytest.approx(400.0, abs=1e-6)
    page.settled()


def test_the_keyboard_alone_moves_a_length(page: StudioPage) -> None:
    before = page.number(r"worst ([\d.]+) µm")
    page.slider("proximal (mm)").focus()
    for _ in range(10):
        page.page.keyboard.press("ArrowRight")
    page.wait_until(lambda: page.number(r"worst ([\d.]+) µm") != before)
    page.settled()
    proximal = page.slider_value("proximal (mm)")
    assert proximal > 210.0
    # The map is that of the same robot, computed in the ordinary way.
    robot = load_robot("five-bar", {"proximal": f"{proximal} mm"})
    from stiffkit.study import map_workspace

    worst = float(
        map_workspace(robot, points=2000)
        .deflection_translation.sel(model="refined", load="push")
        .max()
    )
    assert page.number(r"worst ([\d.]+) µm") == pytest.approx(1e6 * worst, rel=5e-4)


def test_quantity_shape_and_motion(page: StudioPage) -> None:
    page.tab("Show")
    page.choose("quantity", "Stiffness, weakest direction")
    page.says(re.compile(r"Stiffness, weakest direction \(N/mm\)"))
    page.choose("shape", "under the load")
    page.says(re.compile(r"deflection drawn \d+ times as large"))
    page.choose("displacements", "true to scale")
    page.says("deflection drawn true to scale")
    page.choose("displacements", "enlarged")
    page.choose("shape", "mode 1")
    page.says(re.compile("motion of the mode"))
    page.field("play the motion").check()
    first, later = page.moments(0.35)
    assert np.abs(first - later).max() > 50
    page.field("play the motion").uncheck()
    page.settled()
    page.choose("shape", "at rest")
    page.choose("quantity", "Deflection")
    page.settled()


def test_a_pinned_variant_is_compared(page: StudioPage) -> None:
    page.button("pin")
    page.says("pinned")
    page.set_slider("distal (mm)", "400")
    page.says(re.compile(r"\d %"))
    page.button("unpin")
    page.wait_until(lambda: "pinned" not in page.text())


def test_saving(page: StudioPage, folder: Path) -> None:
    page.set_slider("base (mm)", "250")
    page.settled()
    page.tab("Save")
    page.save_as("mine")
    page.button("Robot file")
    page.says(re.compile("saved mine.yaml"))
    assert load_robot(folder / "mine.yaml").parameters["base"].value == pytest.approx(0.25)
    page.button("Robot file")
    page.says(re.compile("saved mine-2.yaml"))
    page.button("Picture of the scene")
    page.says(re.compile("saved mine.png"))
    assert picture_spread(folder / "mine.png") > 30.0
    page.button("Report on the whole workspace")
    page.says(re.compile("saved mine-report/report.html"))
    assert (folder / "mine-report" / "report.html").stat().st_size > 100_000
    page.save_as("../mine")
    page.button("Robot file")
    page.says(re.compile("cannot be the name of a file"))
    assert not (folder.parent / "mine.yaml").exists()


def picture_spread(path: Path) -> float:
    from matplotlib.image import imread

    return float(255.0 * np.asarray(imread(BytesIO(path.read_bytes())))[..., :3].std())


def test_what_cannot_be_is_told_and_mended(page: StudioPage) -> None:
    page.type("x (mm)", "1000000")
    page.says(re.compile("this pose is not reached"))
    page.button("home")
    page.wait_until(lambda: "is not reached" not in page.text())
    page.set_slider("base (mm)", "600")
    page.set_slider("distal (mm)", "175")
    page.set_slider("proximal (mm)", "100")
    page.says(re.compile("cannot be put together at its home posture"))
    page.button("as in the file")
    page.expect(DEFLECTION, 240.9)


def test_two_browsers_a_reload_and_a_lost_connection(
    chromium: Browser, five_bar: Studio, page: StudioPage
) -> None:
    other = StudioPage(chromium, five_bar.address)
    page.type("y (mm)", "350")
    other.wait_until(lambda: other.value("y (mm)") == "350")
    page.page.reload()
    page.wait_until(lambda: page.value("y (mm)") == "350")
    five_bar.drop_connections()
    page.type("y (mm)", "360")
    other.wait_until(lambda: other.value("y (mm)") == "360")
    other.page.close()
    assert other.errors == []
    page.button("home")


def test_other_pages_are_refused(five_bar: Studio) -> None:
    address = urlsplit(five_bar.address)
    own = f"{address.hostname}:{address.port}"
    for headers, status in (
        ({"Host": own}, 200),
        ({"Host": own, "Origin": five_bar.address}, 200),
        ({"Host": own, "Origin": "http://example.org"}, 403),
        ({"Host": "example.org"}, 403),
        ({"Host": own, "Origin": "null"}, 403),
    ):
        connection = http.client.HTTPConnection(own, timeout=10)
        connection.request("GET", "/", headers=headers)
        assert connection.getresponse().status == status, headers
        connection.close()
    with pytest.raises(InvalidStatus), connect(f"ws://{own}", origin=Origin("http://example.org")):
        pass


def test_nothing_but_the_page_itself_is_served(five_bar: Studio) -> None:
    address = urlsplit(five_bar.address)
    for path in ("/../../../../etc/passwd", "/%2e%2e/%2e%2e/pyproject.toml", "/mine.yaml"):
        connection = http.client.HTTPConnection(str(address.netloc), timeout=10)
        connection.request("GET", path)
        assert connection.getresponse().status == 404
        connection.close()


def test_the_command_opens_and_closes(tmp_path: Path) -> None:
    with studio("biglide", tmp_path, "--points", "500", "--set", "L1=900mm") as address:
        connection = http.client.HTTPConnection(str(urlsplit(address).netloc), timeout=10)
        connection.request("GET", "/")
        answer = connection.getresponse()
        assert answer.status == 200
        assert b"<script" in answer.read()
        connection.close()
    assert list(tmp_path.iterdir()) == []
