"""``stiffkit identify`` and ``stiffkit advise``: the table, JSON, the link file, the report."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from tests.unit.identified_beam import beam_compliance

from .commandline import output_of, refusal_of
from .identification import SIGMA, write_identification
from .test_report_browser import Visit, visit

ROBOT = """\
robot: One beam
links:
  beam: {compliance: out/beam.link.yaml}
joints:
  root: {prismatic: z, from: base, to: beam.base, drive: rigid}
tool: {at: beam.tip}
loads:
  down: {force: [0, 0, -1 N]}
"""

PROBE = """
<script>
addEventListener("load", async () => {
  const settled = () => new Promise((resolve) => setTimeout(resolve, 1000));
  const choose = async (id, value) => {
    const control = document.getElementById(id);
    control.value = value;
    control.dispatchEvent(new Event("change"));
    await settled();
  };
  const field = document.getElementById("field");
  const histogram = document.getElementById("histogram");
  const countOf = (trace) => trace.y.reduce((a, b) => a + b);
  const look = () => ({
    nodes: field.data[0].x.length,
    colours: Array.from(field.data[0].marker.color),
    outliers: field.data[1].x.length,
    panels: histogram.data.filter((trace) => trace.type === "bar").length,
    counts: histogram.data.filter((trace) => trace.type === "bar").map(countOf),
    bars: histogram.querySelectorAll(".bars path").length,
    titles: histogram.layout.annotations.map((note) => note.text),
    verdict: document.getElementById("verdict").textContent,
    hidden: ["compliance-mm", "compliance-si"].map((id) => document.getElementById(id).hidden),
  });
  const seen = {};
  while (document.querySelector("main[aria-busy]")) await settled();
  await settled();
  seen.first = look();
  seen.case = document.getElementById("case").value;
  seen.sure = document.querySelectorAll("#compliance-mm td.sure").length;
  await choose("case", "3");
  await choose("component", "z");
  await choose("units", "si");
  seen.second = look();
  seen.overflow = document.documentElement.scrollWidth > document.documentElement.clientWidth;
  seen.requests = performance.getEntriesByType("resource").map((entry) => entry.name.slice(0, 80));
  const note = document.createElement("pre");
  note.id = "probe";
  note.textContent = JSON.stringify(seen);
  document.body.replaceChildren(note);
});
</script>
"""
"""Uses the page as a reader would, and leaves what is seen in the page."""


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a directory with a specification, and what the command made of it in ``out``."""
    here = tmp_path_factory.mktemp("identify")
    write_identification(here)
    shown = output_of("identify", "beam.yaml", "-o", "out", cwd=here)
    (here / "shown.txt").write_text(shown, encoding="utf-8")
    return here


@pytest.fixture(scope="module")
def report(here: Path, tmp_path_factory: pytest.TempPathFactory) -> Visit:
    """Return the visit of the report."""
    there = tmp_path_factory.mktemp("browser")
    page = (here / "out" / "report.html").read_text(encoding="utf-8")
    assert page.count("</body>") == 1
    probed = there / "report.html"
    probed.write_text(page.replace("</body>", f"{PROBE}</body>"), encoding="utf-8")
    return visit(probed, there / "profile")


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    """Return a specification in a directory of its own."""
    return write_identification(tmp_path)


def found_in(here: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(output_of("identify", "beam.yaml", "--json", cwd=here))
    return found


def test_table(here: Path) -> None:
    shown = (here / "shown.txt").read_text(encoding="utf-8")
    lines = shown.splitlines()
    assert lines[-2:] == ["compliance: out/beam.link.yaml", "open out/report.html"]
    first = lines[lines.index("compliance (m/N, 1/N; 1/N, rad/(N m)) of the tip, link axes") + 1]
    assert float(first.split()[0].removesuffix("*")) == pytest.approx(5e-8, rel=1e-3)
    assert "*" in first.split()[0]
    assert "Poisson contraction" in shown
    assert "intervals are nominal" in " ".join(shown.split())
    assert "doubt:" not in shown


def test_files(here: Path) -> None:
    assert sorted(path.name for path in (here / "out").iterdir()) == [
        "beam.link.yaml",
        "report.html",
    ]
    link = yaml.safe_load((here / "out" / "beam.link.yaml").read_text(encoding="utf-8"))
    assert np.shape(link["covariance"]) == (36, 36)
    assert link["compliance"]["tip"]["at"] == [1.0, 0.0, 0.0]


def test_json(here: Path, tmp_path: Path) -> None:
    found = found_in(here)
    k, error = np.array(found["compliance"]), np.array(found["standard_error"])
    assert k.shape == error.shape == np.shape(found["significant"]) == (6, 6)
    significant = np.array(found["significant"])
    assert significant[beam_compliance() != 0.0].all()
    assert found["sigma"] == pytest.approx(SIGMA, rel=0.2)
    size = np.sqrt(np.diag(beam_compliance()))
    assert (np.abs(k - beam_compliance()) / np.outer(size, size)).max() < 1e-3
    assert [case["structured"] for case in found["load_cases"]] == [True] + [False] * 5
    assert {"exact", "svd+", "with outliers", "core"} <= {a["name"] for a in found["alternatives"]}
    link = yaml.safe_load((here / "out" / "beam.link.yaml").read_text(encoding="utf-8"))
    np.testing.assert_array_equal(link["compliance"]["matrix"], k)
    assert not (here / "stiffkit-beam").exists()


def test_results_go_into_a_directory_of_their_own(spec: Path) -> None:
    output_of("identify", "beam.yaml", cwd=spec.parent)
    assert {path.name for path in (spec.parent / "stiffkit-beam").iterdir()} == {
        "beam.link.yaml",
        "report.html",
    }
    output_of("identify", "beam.yaml", cwd=spec.parent)


def test_a_stranger_s_report_is_kept(spec: Path) -> None:
    mine = spec.parent / "out" / "report.html"
    mine.parent.mkdir()
    mine.write_text("mine", encoding="utf-8")
    told = refusal_of("identify", "beam.yaml", "-o", "out", cwd=spec.parent)
    assert "out/report.html is there already" in told
    assert mine.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("  Mz: {moment: [0, 0, 1 N m]}\n", "", "only 5 load cases"),
        ("[0, 0, 1 N m]", "[0, 1 N m, 0]", "dependent"),
        ("[0, 0, 1 N m]", "[0, 0, -1 N m]", "not the compliance of a body"),
        ("fields: beam.csv", "fields: beam.frd", "there is no file"),
        ("outliers: {drop: 10 %}", "outliers: some", "no treatment of outliers"),
        ("near: 3 mm", "near: 3 um", "beam.yaml:14: compare.core.select"),
    ],
)
def test_nothing_is_half_written(spec: Path, old: str, new: str, what: str) -> None:
    text = spec.read_text(encoding="utf-8")
    assert old in text
    spec.write_text(text.replace(old, new), encoding="utf-8")
    told = refusal_of("identify", "beam.yaml", "-o", "out", cwd=spec.parent)
    assert what in told
    assert "mend: " in told
    assert sorted(path.name for path in spec.parent.iterdir()) == ["beam.csv", "beam.yaml"]


def test_robots_take_the_link_file_by_name(here: Path) -> None:
    (here / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    pose = json.loads(output_of("pose", "robot.yaml", "--json", cwd=here))
    k = np.array(found_in(here)["compliance"])
    np.testing.assert_allclose(pose["compliance"], k, rtol=1e-9, atol=1e-9 * np.abs(k).max())
    down = pose["deflections"]["down"]
    assert down[2] == pytest.approx(-k[2, 2], rel=1e-9)


def test_advice(here: Path) -> None:
    from_spec = output_of("advise", "beam.yaml", cwd=here)
    assert "linear finite-element program" in " ".join(from_spec.split())
    loads = [line.split()[0] for line in from_spec.partition("deg\n")[2].splitlines()[:6]]
    assert loads == ["Fx", "Fy", "Fz", "Mx", "My", "Mz"]
    field = ("--noise", "5e-5mm", "--size", "10mm", "--nodes", "1331")
    advice = json.loads(output_of("advise", "out/beam.link.yaml", *field, "--json", cwd=here))
    found = {one["load"]: one for one in advice["loads"]}
    assert found["Fx"]["highest"] is None
    # The paper's 0.01 to 0.2 degrees for 0.2 %, and what they take on this beam.
    bounds = np.degrees([found["Mz"][key] * 0.006 for key in ("lowest", "highest")])
    assert bounds == pytest.approx([0.01, 0.2], rel=0.2)
    told = refusal_of("advise", "out/beam.link.yaml", cwd=here)
    assert "mend: give the noise" in told


def test_schema(tmp_path: Path) -> None:
    schema = json.loads(output_of("schema", "identify", cwd=tmp_path))
    assert {"identify", "units", "fields", "reference", "loads"} == set(schema["required"])


def test_report_is_drawn_without_a_word_to_the_network(report: Visit) -> None:
    # What a browser without a graphics card says of drawing in space is no fault of the page.
    slow = ("WebGL", "GL Driver", "Canvas2D")
    assert [line for line in report.console if not any(word in line for word in slow)] == []
    assert report.seen["requests"] == []
    assert not report.seen["overflow"]


def test_report_shows_the_field_and_its_histograms(report: Visit, here: Path) -> None:
    first, second = report.seen["first"], report.seen["second"]
    assert first["nodes"] == 225
    assert first["panels"] == 2
    assert first["bars"] > 40
    # The case whose residuals have a shape comes first.
    assert report.seen["case"] == "0"
    assert "Poisson contraction" in first["verdict"]
    assert first["verdict"].startswith("Load case Fx: ")
    cases = found_in(here)["load_cases"]
    dropped = len(cases[0]["outliers"])
    assert first["outliers"] == dropped
    assert first["counts"] == [3 * 225, 3 * (225 - dropped)]
    assert max(first["colours"]) >= 1e6 * cases[0]["largest_residual"]
    assert min(second["colours"]) < 0.0 < max(second["colours"])
    assert second["verdict"].startswith("Load case Mx: no shape is seen")
    assert second["counts"][0] == 225
    assert (first["hidden"], second["hidden"]) == ([False, True], [True, False])
    assert report.seen["sure"] == np.sum(found_in(here)["significant"])
