"""How soon a slider's new colours are in the browser, measured there.

What the page and its background worker, which holds the connection, tell each other is watched:
from the slider's new value to the arrival of the colours of all poses, unpacked, ready to be drawn.
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Page, sync_playwright
from tests.e2e.studio_page import CHROMIUM, FLAGS

from benchmarks.machine import Machine
from benchmarks.studio import MOVED
from benchmarks.table import show
from stiffkit.studio import open_studio

EVENTS = 30
ROBOTS = ("five-bar", "biglide")

_WATCH = """
window.watched = [];
const longest = (data) => {
  if (ArrayBuffer.isView(data)) return data.length;
  if (data === null || typeof data !== "object") return 0;
  return Math.max(0, ...Object.values(data).map(longest));
};
const Background = window.Worker;
window.Worker = class extends Background {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", (event) => {
      const at = performance.now();
      window.watched.push(["in", at, longest(event.data)]);
    });
  }
  postMessage(message, ...others) {
    window.watched.push(["out", performance.now(), 0]);
    super.postMessage(message, ...others);
  }
};
"""


@dataclass(frozen=True)
class Latency:
    """From a slider's event to the colours of all poses, as the browser sees it."""

    robot: str
    parameter: str
    poses: int
    median_ms: float
    worst_ms: float


def measure(robot: str, parameter: str, points: int = 10_000) -> Latency:
    """Press a slider's key `EVENTS` times, each when the colours of the one before have come."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        studio = open_studio(robot, folder=Path(folder), points=points, port=0)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        try:
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            page.add_init_script(_WATCH)
            page.goto(studio.address)
            page.get_by_text("up to date").first.wait_for(timeout=120_000)
            times = _times(page, parameter, 3 * studio.n_poses)
        finally:
            browser.close()
            studio.close()
    return Latency(robot, parameter, studio.n_poses, float(np.median(times)), max(times))


def _times(page: Page, parameter: str, colours: int) -> list[float]:
    """Return milliseconds of each event; ``colours`` are the bytes that bring an answer."""
    label = page.get_by_text(re.compile(rf"^{re.escape(parameter)} \("))
    row = page.locator("div").filter(has=label)
    slider = row.filter(has=page.get_by_role("slider")).last.get_by_role("slider")
    slider.focus()
    times = []
    for _ in range(EVENTS):
        page.evaluate("window.watched = []")
        page.keyboard.press("ArrowRight")
        page.wait_for_function(
            "(size) => window.watched.some(([way, , bytes]) => way == 'in' && bytes >= size)",
            arg=colours,
        )
        watched = page.evaluate("window.watched")
        sent = next(at for way, at, _ in watched if way == "out")
        came = next(at for way, at, size in watched if way == "in" and size >= colours)
        times.append(float(came - sent))
        page.wait_for_timeout(400)
    return times


def run_studio_page(_this: Machine) -> list[Any]:
    """Table of what the browser waits for."""
    rows = [measure(robot, MOVED[robot]) for robot in ROBOTS]
    show(
        f"Studio: from a slider's event to the colours in the browser, {EVENTS} events",
        ("robot", "parameter", "poses", "median, ms", "slowest, ms"),
        [(r.robot, r.parameter, r.poses, r.median_ms, r.worst_ms) for r in rows],
    )
    return rows
