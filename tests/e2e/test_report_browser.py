"""The report as a browser shows it: drawn, without errors, and without a word to the network."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiffkit

CHROMIUM_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-logging=stderr",
    "--window-size=1280,1600",
    "--virtual-time-budget=20000",
    "--dump-dom",
)

PROBE = """
<script>
addEventListener("load", async () => {
  const settled = () => new Promise((resolve) => setTimeout(resolve, 1000));
  const plot = document.getElementById("map");
  const numbers = (rows) => (rows.z ?? []).map((row) => Array.from(row));
  const look = () => ({
    quantity: document.getElementById("quantity").value,
    title: plot.layout.coloraxis.colorbar.title.text,
    shownTitle: plot.querySelector(".cbtitle, .cbcoloraxistitle")?.textContent ?? "",
    values: plot.data.filter((trace) => trace.coloraxis).map(numbers),
    x: Array.from(plot.data.find((trace) => trace.coloraxis).x),
    y: Array.from(plot.data.find((trace) => trace.coloraxis).y),
    images: [...plot.querySelectorAll(".heatmaplayer image")].map((i) => i.getAttribute("href")),
    panels: plot.querySelectorAll(".heatmaplayer").length,
    worst: document.querySelectorAll("#worst tr").length,
    lines: document.querySelectorAll("#lines .scatterlayer path.js-line").length,
    branches: document.querySelectorAll("#branches .scatterlayer path.js-line").length,
  });
  const choose = async (id, value) => {
    const control = document.getElementById(id);
    control.value = value;
    control.dispatchEvent(new Event("change"));
    await settled();
  };
  const seen = {};
  while (document.querySelector("main[aria-busy]")) await settled();
  await settled();
  seen.first = look();
  await choose("quantity", "stiffness_rotation_min");
  seen.rotation = look();
  await choose("model", document.getElementById("model").options[2].value);
  seen.both = look();
  await choose("model", "refined");
  await choose("quantity", "deflection_z");
  await choose("load", "f_z");
  seen.z = look();
  await choose("scale", "log");
  const { type, tickvals } = document.getElementById("lines").layout.yaxis;
  seen.logarithmic = { type, ticks: Array.from(tickvals ?? []) };
  seen.requests = performance.getEntriesByType("resource").map((entry) => entry.name.slice(0, 80));
  const note = document.createElement("pre");
  note.id = "probe";
  note.textContent = JSON.stringify(seen);
  document.body.replaceChildren(note);
});
</script>
"""
"""Uses the page as a reader would, and leaves what is seen in the page."""


@dataclass(frozen=True)
class Visit:
    """What a page left behind."""

    seen: dict[str, Any]
    console: list[str]


def visit(page: Path, profile: Path) -> Visit:
    """Open a page with the probe in it, and return what it saw and what the console said."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.fail("there is no 'chromium'; on Debian: apt-get install chromium")
    ended = subprocess.run(
        [chromium, *CHROMIUM_FLAGS, f"--user-data-dir={profile}", page.as_uri()],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    console = [line for line in ended.stderr.splitlines() if "CONSOLE" in line]
    found = re.search(r'<pre id="probe">(.*?)</pre>', ended.stdout, re.DOTALL)
    assert found, f"the page did not come to its end: {console or ended.stderr[-2000:]}"
    return Visit(json.loads(html.unescape(found[1])), console)


@pytest.fixture(scope="module")
def report(biglide_map: Path, tmp_path_factory: pytest.TempPathFactory) -> Visit:
    """Return the visit of the Biglide's report."""
    here = tmp_path_factory.mktemp("browser")
    page = (biglide_map / "report.html").read_text(encoding="utf-8")
    assert page.count("</body>") == 1
    probed = here / "report.html"
    probed.write_text(page.replace("</body>", f"{PROBE}</body>"), encoding="utf-8")
    return visit(probed, here / "profile")


def test_the_console_of_a_wrong_page_is_heard(tmp_path: Path) -> None:
    """Without this, the silence of the other pages would say nothing."""
    page = tmp_path / "page.html"
    page.write_text(
        '<body><pre id="probe">{}</pre><script>nothing.like.this()</script></body>',
        encoding="utf-8",
    )
    assert any("nothing is not defined" in line for line in visit(page, tmp_path / "p").console)


def test_no_errors(report: Visit) -> None:
    assert report.console == []


def test_asks_for_nothing_outside(report: Visit) -> None:
    outside = [name for name in report.seen["requests"] if not name.startswith(("data:", "blob:"))]
    assert outside == []


def test_the_map_is_drawn(report: Visit) -> None:
    first = report.seen["first"]
    assert first["panels"] == 1
    assert any(image.startswith("data:image/png") for image in first["images"])
    assert first["lines"] > 0
    assert first["branches"] == 4
    assert first["worst"] > 3


def test_a_logarithmic_axis_has_labels_enough_to_be_seen_as_one(report: Visit) -> None:
    axis = report.seen["logarithmic"]
    assert axis["type"] == "log"
    assert len(axis["ticks"]) > 3


def test_switching_the_quantity_changes_title_and_values(report: Visit) -> None:
    first, rotation = report.seen["first"], report.seen["rotation"]
    assert rotation["quantity"] == "stiffness_rotation_min"
    assert first["title"].startswith("Deflection")
    assert rotation["title"].startswith("Rotational stiffness")
    assert rotation["title"] == rotation["shownTitle"]
    assert rotation["values"] != first["values"]
    assert rotation["images"] != first["images"]


def test_both_models_stand_side_by_side(report: Visit) -> None:
    assert report.seen["both"]["panels"] == 2


def test_the_values_are_those_of_the_dataset(report: Visit, biglide_map: Path) -> None:
    shown = report.seen["z"]
    dataset = stiffkit.open_map(biglide_map).sel(model="refined", load="f_z")
    values = 1e6 * dataset["deflection_z"].transpose("y", "x").to_numpy()
    assert shown["title"].endswith("(µm)")
    # Shown in millimetres and micrometres, with the digits that can be seen.
    np.testing.assert_allclose(shown["x"], 1e3 * dataset["x"].to_numpy(), rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(shown["y"], 1e3 * dataset["y"].to_numpy(), rtol=1e-4, atol=1e-6)
    (colours,) = (np.array(values, dtype=float) for values in shown["values"])
    inside = values <= colours.max()
    assert inside.mean() > 0.9
    np.testing.assert_allclose(colours[inside], values[inside], rtol=1e-3)


WITHOUT_UNPACKING = "<head>\n<script>delete globalThis.DecompressionStream;</script>"
LAST_PROBE = """
<script>
addEventListener("load", async () => {
  while (document.querySelector("main[aria-busy]")) await new Promise((go) => setTimeout(go, 100));
  const height = (element) => element.getBoundingClientRect().height;
  const images = [...document.querySelectorAll("main img")];
  const seen = {
    failure: height(document.getElementById("failure")),
    scripted: [...document.querySelectorAll(".needs-script")].map(height),
    figures: images.map((image) => [image.naturalWidth, height(image)]),
    tables: [...document.querySelectorAll("main table.figures")].map(height),
  };
  const note = document.createElement("pre");
  note.id = "probe";
  note.textContent = JSON.stringify(seen);
  document.body.replaceChildren(note);
});
</script>
"""
"""Leaves the heights in pixels of what an older browser shows; none are hidden things."""


def test_an_older_browser_says_so_and_shows_figures_and_tables(
    biglide_map: Path, tmp_path: Path
) -> None:
    page = (biglide_map / "report.html").read_text(encoding="utf-8")
    assert page.count("<head>") == 1
    older = page.replace("<head>", WITHOUT_UNPACKING).replace("</body>", f"{LAST_PROBE}</body>")
    (tmp_path / "report.html").write_text(older, encoding="utf-8")
    seen = visit(tmp_path / "report.html", tmp_path / "profile").seen
    assert seen["failure"] > 10
    assert set(seen["scripted"]) == {0}
    assert len(seen["figures"]) > 3
    assert all(width > 100 and height > 50 for width, height in seen["figures"])
    assert min(seen["tables"]) > 50


def test_the_page_has_a_few_megabytes_at_most(biglide_map: Path) -> None:
    assert (biglide_map / "report.html").stat().st_size < 4e6
