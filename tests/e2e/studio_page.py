"""A studio of the test's own, and a browser that looks at it."""

from __future__ import annotations

import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from queue import Empty, Queue

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Browser, Locator, Page, sync_playwright

from .commandline import STIFFKIT

Picture = NDArray[np.int64]

CHROMIUM = "/usr/bin/chromium"
FLAGS = (
    "--no-sandbox",
    "--disable-quic",
    "--disable-background-networking",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
"""Debian's browser draws in space without a graphics card so."""

_RED = ((195, 35, 80), (255, 90, 130))
"""Colours of the handle's arrow along x, before what is behind it."""

PATIENCE_MS = 60_000
"""A page that takes longer hangs."""


@contextmanager
def studio(robot: str | Path, folder: Path, *options: str) -> Iterator[str]:
    """Run ``stiffkit studio`` and give its address; it must end without a word when interrupted."""
    command = [STIFFKIT, "studio", str(robot), "--no-open", "--port", "0", *options]
    running = subprocess.Popen(
        [*command, "--folder", str(folder)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
    )
    try:
        yield _address(running)
    finally:
        running.send_signal(signal.SIGINT)
        try:
            _, errors = running.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            running.kill()
            raise
    assert errors == ""
    assert running.returncode == 0


def _address(running: subprocess.Popen[str]) -> str:
    """Return the address that the studio prints when it is ready."""
    lines: Queue[str] = Queue()
    assert running.stdout is not None
    stdout = running.stdout

    def read() -> None:
        for line in stdout:
            lines.put(line)

    threading.Thread(target=read, daemon=True).start()
    told = ""
    while not (found := re.search(r"http://\S+", told)):
        try:
            told += lines.get(timeout=PATIENCE_MS / 1e3)
        except Empty:
            running.kill()
            raise AssertionError(f"no address: {told}{running.communicate()[1]}") from None
    return found[0]


@contextmanager
def browser() -> Iterator[Browser]:
    """Give a browser."""
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        try:
            yield opened
        finally:
            opened.close()


class StudioPage:
    """The studio as a person at the browser has it."""

    def __init__(self, browser: Browser, address: str) -> None:
        self.errors: list[str] = []
        # Half as many pixels each way: without a graphics card every one of them takes its time.
        self.page: Page = browser.new_page(
            viewport={"width": 1280, "height": 720}, device_scale_factor=0.5
        )
        self.page.set_default_timeout(PATIENCE_MS)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.goto(address)
        self.settled()

    def settled(self) -> None:
        """Wait until what was asked for is shown."""
        self.says(re.compile("up to date"))

    def says(self, text: str | re.Pattern[str]) -> None:
        """Wait until something is said on the page."""
        self.page.get_by_text(text).first.wait_for()

    def wait_until(self, is_so: Callable[[], bool]) -> None:
        """Wait until something is true of the page."""
        ends = time.monotonic() + PATIENCE_MS / 1e3
        while not is_so():
            assert time.monotonic() < ends, self.text()
            self.page.wait_for_timeout(50)

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name, exact=True).click()

    def field(self, label: str) -> Locator:
        return self.page.get_by_label(label, exact=True).first

    def value(self, label: str) -> str:
        return self.field(label).input_value()

    def type(self, label: str, text: str) -> None:
        self.field(label).fill(text)
        self.field(label).press("Enter")

    def save_as(self, name: str) -> None:
        """Type the name of what is saved, the only text on its tab."""
        field = self.page.get_by_role("textbox")
        field.fill(name)
        field.press("Enter")

    def button(self, label: str) -> None:
        self.page.get_by_role("button", name=label, exact=True).first.click()

    def choose(self, label: str, option: str) -> None:
        """Choose an option of a list."""
        self.field(label).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def slider(self, label: str) -> Locator:
        """Return the part of a slider that is moved."""
        return self._row(label).get_by_role("slider")

    def slider_value(self, label: str) -> float:
        return float(self._row(label).get_by_role("textbox").input_value())

    def set_slider(self, label: str, text: str) -> None:
        """Type a slider's value."""
        field = self._row(label).get_by_role("textbox")
        field.fill(text)
        field.press("Enter")

    def _row(self, label: str) -> Locator:
        """Return the smallest part of the page with this label and a slider."""
        return (
            self.page.locator("div")
            .filter(has=self.page.get_by_text(label, exact=True))
            .filter(has=self.page.get_by_role("slider"))
            .last
        )

    def text(self) -> str:
        return self.page.locator("body").inner_text()

    def number(self, pattern: str) -> float:
        """Return the number in the first match of a pattern's group in what the page says."""
        found = re.search(pattern, self.text())
        return float(found[1]) if found else float("nan")

    def expect(self, pattern: str, value: float | Callable[[float], bool]) -> None:
        """Wait until a number that the page says is ``value``, or is as it says."""
        is_so = value if callable(value) else lambda number: number == value
        self.wait_until(lambda: is_so(self.number(pattern)))

    def moments(self, apart_s: float) -> tuple[Picture, Picture]:
        """Return two pictures of the scene."""
        first = self.picture()
        self.page.wait_for_timeout(1e3 * apart_s)
        return first, self.picture()

    def picture(self) -> Picture:
        """Return what is seen (H, W, 3), 0 to 255."""
        from matplotlib.image import imread

        seen = imread(BytesIO(self.page.locator("canvas").first.screenshot()))
        return np.asarray(np.round(255.0 * seen[..., :3]), dtype=np.int64)

    def drag_handle(self, right: float, up: float) -> None:
        """Take the arrow along x by its tip, the rightmost of its red, and move it by pixels."""
        seen = self.picture()
        rows, columns = np.nonzero(((seen >= _RED[0]) & (seen <= _RED[1])).all(axis=-1))
        assert rows.size, "no red arrow is seen"
        tip = int(np.argmax(columns))
        box = self.page.locator("canvas").first.bounding_box()
        assert box is not None
        pixel = box["width"] / seen.shape[1]
        x, y = box["x"] + pixel * (float(columns[tip]) - 1.0), box["y"] + pixel * float(rows[tip])
        mouse = self.page.mouse
        mouse.move(x, y)
        mouse.down()
        for step in range(1, 9):
            mouse.move(x + right * step / 8, y - up * step / 8)
            self.page.wait_for_timeout(40)
        mouse.up()
