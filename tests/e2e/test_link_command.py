"""``stiffkit link``: faces, the table, JSON, the link file, the report, the cache; robot files."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest

from stiffkit.link import MATERIALS, beam_compliance, rectangle
from stiffkit.link.file import read_link_file

from .commandline import output_of, refusal_of

SHAPES = Path(__file__).parents[1] / "unit"

SPEC = """\
link: Beam
cad: beam.step
material: steel
base: {faces: {near: [0, 5 mm, 5 mm]}, interface: clamped}
tip: {faces: {name: tip}, interface: average}
tolerance: 1 %
modes: 2
"""

ROBOT = """\
robot: One beam
parameters: {thick: 10 mm}
links:
  beam:
    cad:
      file: beam.step
      material: steel
      base: {faces: {near: [0, = thick / 2, 5 mm]}, interface: clamped}
      tip: {faces: {name: tip}, interface: average}
      tolerance: 1 %
      modes: 2
  same: {cad: beam.yaml}
joints:
  root: {prismatic: z, from: base, to: beam.base, drive: rigid}
  weld: {fixed: true, from: beam.tip, to: same.base}
tool: {at: same.tip}
loads:
  down: {force: [0, 0, -1 N]}
"""


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return a directory with a part, its specification and a robot, and a cache of its own."""
    here = tmp_path_factory.mktemp("link")
    make = (
        f"import sys; sys.path.insert(0, {str(SHAPES)!r}); import fea_shapes as shapes; "
        "shapes.beam(100.0, 10.0).WriteStep('beam.step')"
    )
    subprocess.run([sys.executable, "-c", make], cwd=here, check=True, capture_output=True)
    step = (here / "beam.step").read_text("utf-8")
    metres = step.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)")
    assert metres != step
    (here / "metres.step").write_text(metres, encoding="utf-8")
    (here / "beam.yaml").write_text(SPEC, encoding="utf-8")
    (here / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        # Matplotlib looks for its fonts anew wherever its own cache is not.
        patch.setenv("MPLCONFIGDIR", matplotlib.get_cachedir())
        patch.setenv("XDG_CACHE_HOME", str(here / "cache"))
        yield here


@pytest.fixture(scope="module")
def shown(here: Path) -> str:
    """Return what the command says of the beam, whose files are in ``out``."""
    return output_of("link", "beam.yaml", "-o", "out", cwd=here)


def kept(here: Path) -> list[Path]:
    return sorted((here / "cache" / "stiffkit" / "links").iterdir())


def test_faces_are_listed(here: Path) -> None:
    text = output_of("link", "beam.step", "--faces", "-o", "faces", cwd=here)
    lines = [line.split() for line in text.splitlines()]
    assert ["1", "plane", "100", "(100,", "5,", "5)", "(1,", "0,", "0)", "tip"] in [
        line[:10] for line in lines
    ]
    assert sum(line[1:2] == ["plane"] for line in lines) == 6
    assert (here / "faces" / "faces.png").read_bytes().startswith(b"\x89PNG")


def test_the_link_is_that_of_a_beam(here: Path, shown: str) -> None:
    link = read_link_file(here / "out" / "beam.link.yaml")
    assert link.notes == ()
    expected = beam_compliance(0.1, rectangle(0.01, 0.01), MATERIALS["steel"])
    scale = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(
        link.compliance / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.01
    )
    assert link.mass == pytest.approx(0.0785, rel=1e-6)
    np.testing.assert_allclose(link.ports["tip"].position, [0.1, 0.0, 0.0], atol=1e-9)
    assert link.superelement is not None
    # Both ends held, Euler and Bernoulli: a little above, for shear lets it yield.
    first = np.sqrt(link.superelement.mode_stiffness[0]) / (2.0 * np.pi)
    assert first == pytest.approx(5317.0, rel=0.08)
    assert first < 5317.0
    assert "estimated error" in shown


def test_the_link_file_says_where_it_comes_from(here: Path, shown: str) -> None:
    told = read_link_file(here / "out" / "beam.link.yaml").provenance
    assert told["cad"]["file"] == "beam.step"
    assert len(told["cad"]["sha256"]) == 64
    assert told["interfaces"]["base"]["interface"] == "clamped"
    assert told["interfaces"]["tip"]["numbers"] == [1]
    assert told["materials"]["solid1"]["E"] == 210e9
    assert 0.0 < told["estimated_error"] < 0.01
    assert told["unknowns"] > 1000


def test_the_report_needs_nothing_else(here: Path, shown: str) -> None:
    page = (here / "out" / "report.html").read_text("utf-8")
    assert page.count("<img ") == 3
    assert "http://" not in page
    assert "https://" not in page
    assert "nearest to (0, 5, 5) mm" in page


def test_the_same_part_is_never_solved_twice(here: Path, shown: str) -> None:
    before = kept(here)
    found = answer(here, "beam.yaml")
    assert found["from_cache"] is True
    assert kept(here) == before
    assert "taken from the cache" not in shown


def answer(here: Path, spec: str) -> dict[str, Any]:
    found = json.loads(output_of("link", spec, "--json", cwd=here))
    assert isinstance(found, dict)
    return found


def test_a_robot_takes_parts_by_name_and_in_place(here: Path, shown: str) -> None:
    before = kept(here)
    pose = json.loads(output_of("pose", "robot.yaml", "--json", cwd=here))
    assert kept(here) == before
    # Two beams of 100 mm in a row are one of 200 mm.
    expected = beam_compliance(0.2, rectangle(0.01, 0.01), MATERIALS["steel"])
    assert pose["compliance"][1][1] == pytest.approx(expected[1, 1], rel=0.01)


def test_a_mesh_may_be_asked_for(here: Path) -> None:
    text = SPEC.replace("tolerance: 1 %", "mesh: {size: 20 mm, order: 1}")
    (here / "linear.yaml").write_text(text, encoding="utf-8")
    found = answer(here, "linear.yaml")
    assert found["estimated_error"] is None
    assert (found["part"]["order"], len(found["history"])) == (1, 1)
    # Linear tetrahedra are far too stiff.
    exact = beam_compliance(0.1, rectangle(0.01, 0.01), MATERIALS["steel"])
    assert 0.0 < found["compliance"][1][1] < 0.9 * exact[1, 1]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("{name: tip}", "{kind: plane}", "6 faces have kind plane, and it must be 1"),
        ("beam.step", "metres.step", "measures 1e+05 x 1e+04 x 1e+04 mm"),
    ],
)
def test_bad_input_is_refused(here: Path, old: str, new: str, told: str) -> None:
    (here / "bad.yaml").write_text(SPEC.replace(old, new), encoding="utf-8")
    assert told in refusal_of("link", "bad.yaml", "-o", "bad", cwd=here)
    assert not (here / "bad").exists()


def test_a_part_alone_is_no_link(here: Path) -> None:
    assert "two interfaces" in refusal_of("link", "beam.step", cwd=here)
    assert "there is no such file" in refusal_of("link", "none.yaml", cwd=here)
