"""``stiffkit modes``: the table, JSON, and the files that people look at."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import stiffkit

from .commandline import output_of, refusal_of, run
from .test_report_browser import visit

PROBE = """
<script>
addEventListener("load", async () => {
  const settled = () => new Promise((resolve) => setTimeout(resolve, 300));
  const canvas = document.getElementById("shape");
  const look = () => ({
    heading: document.getElementById("shape-heading").textContent,
    view: document.getElementById("view").value,
    picture: canvas.toDataURL(),
    energies: document.querySelectorAll(".share").length,
    play: document.getElementById("play").textContent,
  });
  const seen = {};
  while (document.querySelector("main[aria-busy]")) await settled();
  await settled();
  const play = document.getElementById("play");
  if (play.textContent === "Pause") play.click();
  await settled();
  seen.first = look();
  document.querySelectorAll("#modes button")[1].click();
  await settled();
  seen.second = look();
  canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
  await settled();
  seen.turned = look();
  const amplitude = document.getElementById("amplitude");
  amplitude.value = 0;
  amplitude.dispatchEvent(new Event("input"));
  await settled();
  seen.still = look();
  play.click();
  await settled();
  seen.playing = look();
  seen.requests = performance.getEntriesByType("resource").map((entry) => entry.name);
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
    """Return a directory with the Biglide's modes in ``out``."""
    here = tmp_path_factory.mktemp("modes")
    shown = output_of("modes", "biglide", "-n", "2", "-o", "out", cwd=here)
    assert shown.splitlines()[-1] == "open out/modes.html"
    return here


def modes_of(*arguments: str, cwd: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(output_of("modes", *arguments, "--json", cwd=cwd))
    return found


def test_table(tmp_path: Path) -> None:
    shown = output_of("modes", "biglide", "--at", "x=0.4975,y=0", cwd=tmp_path)
    rows = [line.split() for line in shown.splitlines() if " Hz " in line]
    assert [row[0] for row in rows] == ["1", "2", "3", "4"]
    expected = stiffkit.analyse_modes(stiffkit.load_robot("biglide")).frequencies_hz
    assert [float(row[1]) for row in rows] == pytest.approx(expected, abs=0.005)
    assert "tool moves along z" in shown
    assert "leg_1: 69.705 kg: equivalent beam" in shown
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "n"), [((), 4), (("-n", "2"), 2), (("--model", "lumped", "--elements", "5"), 4)]
)
def test_json(options: tuple[str, ...], n: int, tmp_path: Path) -> None:
    found = modes_of("five-bar", *options, cwd=tmp_path)
    assert found["status"] == "ok"
    assert len(found["frequencies_hz"]) == n
    assert found["frequencies_hz"] == sorted(found["frequencies_hz"])


def test_parameters_are_replaced(tmp_path: Path) -> None:
    drive = ("biglide", "--model", "simplified", "--set")
    slack, stiff = (
        modes_of(*drive, f"drive={value} N/m", cwd=tmp_path)["frequencies_hz"]
        for value in ("1e8", "4e8")
    )
    assert stiff == pytest.approx([2.0 * f for f in slack])


def test_fewer_modes_than_asked_for_is_a_note(tmp_path: Path) -> None:
    found = modes_of("biglide", "--model", "simplified", "-n", "9", cwd=tmp_path)
    assert len(found["frequencies_hz"]) == 2
    assert "9 modes were asked for" in found["notes"][0]


def test_out_of_reach_is_a_status(tmp_path: Path) -> None:
    found = modes_of("biglide", "--at", "x=3", cwd=tmp_path)
    assert found["status"] == "unreachable"
    assert found["frequencies_hz"] == []
    told = refusal_of("modes", "biglide", "--at", "x=3", "-o", "out", cwd=tmp_path)
    assert "no mode to draw" in told
    assert list(tmp_path.iterdir()) == []


def test_free_motions_are_named_apart(small_robot: Path) -> None:
    text = small_robot.read_text(encoding="utf-8")
    loose = text.replace(", drive: 1e4 N m/rad", "")
    assert loose != text
    small_robot.write_text(loose, encoding="utf-8")
    found = modes_of(small_robot.name, cwd=small_robot.parent)
    assert found["status"] == "uncontrolled"
    assert len(found["free_motions"]) == 1
    assert found["frequencies_hz"][0] > 1.0


def test_no_mass_anywhere(small_robot: Path) -> None:
    text = small_robot.read_text(encoding="utf-8")
    for length in ("= arm", "300 mm"):
        start = text.index(f"{{beam: {{length: {length}")
        end = text.index("}}\n", start)
        text = f"{text[:start]}{{rigid: {{length: {length}}}}}{text[end + 2 :]}"
    small_robot.write_text(text, encoding="utf-8")
    told = refusal_of("modes", small_robot.name, cwd=small_robot.parent)
    assert "no mass anywhere" in told
    assert "mend: give links a mass" in told


@pytest.mark.parametrize(
    "options",
    [
        ("-n", "0"),
        ("-n", "two"),
        ("--model", "best"),
        ("--elements", "0"),
        ("--model", "lumped", "--elements", "1"),
        ("--model", "simplified", "--elements", "4"),
        ("--at", "q=1"),
    ],
)
def test_slips_are_told(options: tuple[str, ...], tmp_path: Path) -> None:
    ended = run("modes", "biglide", *options, cwd=tmp_path)
    assert ended.returncode == 2
    assert ended.stdout == ""
    assert "rror: " in ended.stderr
    assert "Traceback" not in ended.stderr


def test_files(here: Path) -> None:
    names = sorted(path.relative_to(here).as_posix() for path in here.rglob("*") if path.is_file())
    assert names == [
        "out/modes.html",
        "out/modes/mode-1.png",
        "out/modes/mode-1.svg",
        "out/modes/mode-2.png",
        "out/modes/mode-2.svg",
    ]


def test_a_map_beside_them_is_kept(here: Path) -> None:
    beside = here / "out" / "map.nc"
    beside.write_bytes(b"somebody's map")
    output_of("modes", "five-bar", "-n", "1", "-o", "out", cwd=here)
    assert beside.read_bytes() == b"somebody's map"
    assert len(list((here / "out" / "modes").iterdir())) == 2
    beside.unlink()
    output_of("modes", "biglide", "-n", "2", "-o", "out", cwd=here)


def test_a_stranger_s_directory_is_kept(tmp_path: Path) -> None:
    mine = tmp_path / "out" / "modes" / "mine.svg"
    mine.parent.mkdir(parents=True)
    mine.touch()
    told = refusal_of("modes", "five-bar", "-o", "out", cwd=tmp_path)
    assert "out/modes is there already" in told
    assert mine.exists()


def test_page_in_a_browser(here: Path, tmp_path: Path) -> None:
    page = (here / "out" / "modes.html").read_text(encoding="utf-8")
    probed = tmp_path / "modes.html"
    probed.write_text(page.replace("</body>", f"{PROBE}</body>"), encoding="utf-8")
    visited = visit(probed, tmp_path / "profile")
    seen = visited.seen
    assert visited.console == []
    assert seen["requests"] == []
    assert seen["first"]["heading"] == "Mode 1: 97.43 Hz"
    assert seen["second"]["heading"] == "Mode 2: 134 Hz"
    # The first mode is seen in space, the second in the plane, until somebody turns it.
    assert [seen[name]["view"] for name in ("first", "second", "turned")] == [
        "space",
        "xy",
        "space",
    ]
    pictures = [seen[name]["picture"] for name in ("first", "second", "turned", "still")]
    assert len(set(pictures)) == 4
    assert seen["first"]["energies"] == 6
    assert seen["still"]["play"] == "Play"
    assert seen["playing"]["play"] == "Pause"
