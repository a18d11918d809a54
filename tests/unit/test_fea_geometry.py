"""Parts from CAD: facts, units, and files that are no part."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("netgen.occ")

import subprocess
import sys
from pathlib import Path

from fea_parts import SHAPES, part  # type: ignore[import-not-found]

from stiffkit.errors import CadError, FileError
from stiffkit.fea import build_part, read_step
from stiffkit.fea.child import run_child

_WRITE_STEP = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("shapes", sys.argv[1])
module = importlib.util.module_from_spec(spec); spec.loader.exec_module(module)
getattr(module, sys.argv[2])().WriteStep(sys.argv[3])
"""


def step_file(folder: Path, function: str) -> Path:
    """A STEP file of one of the shapes, written by another process."""
    path = folder / f"{function}.step"
    command = [sys.executable, "-c", _WRITE_STEP, str(SHAPES), function, str(path)]
    subprocess.run(command, check=True, capture_output=True)
    return path


def test_facts_are_in_metres() -> None:
    beam = part("beam")
    assert beam.volume == pytest.approx(1e-4, rel=1e-9)
    assert beam.area == pytest.approx(2e-4 + 4e-2, rel=1e-9)
    assert beam.diagonal == pytest.approx(np.sqrt(1.0 + 2e-4), rel=1e-6)
    tip = next(face for face in beam.faces if face.name == "tip")
    np.testing.assert_allclose(tip.centre, [1.0, 0.005, 0.005], atol=1e-9)
    np.testing.assert_allclose(tip.normal, [1.0, 0.0, 0.0], atol=1e-6)
    assert tip.kind == "plane"
    assert tip.colour == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)


def test_mass_centre_and_inertia_are_those_of_a_box() -> None:
    mass, centre, inertia = part("beam").mass_properties(7800.0)
    assert mass == pytest.approx(0.78, rel=1e-9)
    np.testing.assert_allclose(centre, [0.5, 0.005, 0.005], atol=1e-9)
    across = 0.78 / 12.0 * (1.0 + 1e-4)
    wanted = [0.78 / 6.0 * 1e-4, across, across]
    np.testing.assert_allclose(np.diag(inertia), wanted, rtol=1e-9)


def test_inertia_of_two_solids_is_moved_to_the_common_centre() -> None:
    mass, centre, inertia = part("two_materials").mass_properties((1000.0, 1000.0))
    assert mass == pytest.approx(0.01, rel=1e-9)
    np.testing.assert_allclose(centre, [0.05, 0.005, 0.005], atol=1e-9)
    assert inertia[1, 1] == pytest.approx(0.01 / 12.0 * (0.1**2 + 0.01**2), rel=1e-9)


def test_a_hole_is_a_cylinder_with_radius_and_axis() -> None:
    holes = [face for face in part("plate_with_hole").faces if face.kind == "cylinder"]
    assert len(holes) == 1
    hole = holes[0]
    assert hole.radius == pytest.approx(3e-3, rel=1e-9)
    assert hole.axis is not None
    assert hole.axis_point is not None
    np.testing.assert_allclose(np.abs(hole.axis), [0, 0, 1], atol=1e-9)
    np.testing.assert_allclose(hole.axis_point[:2], [0.01, 0.01], atol=1e-9)
    np.testing.assert_allclose(hole.normal, 0.0, atol=1e-9)


def test_normals_point_outwards() -> None:
    plate = part("plate_with_hole")
    for face in plate.faces:
        if face.kind == "plane":
            outward = face.centre - np.array([0.02, 0.01, 0.0025])
            assert face.normal @ outward > 0.0


def test_a_step_file_is_read_with_its_unit(tmp_path: Path) -> None:
    path = step_file(tmp_path, "beam")
    beam = read_step(path)
    assert beam.unit == "millimetre"
    assert beam.volume == pytest.approx(1e-4, rel=1e-9)
    metres = tmp_path / "metres.step"
    text = path.read_text().replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)")
    metres.write_text(text)
    with pytest.raises(CadError, match=r"1e\+06 x 1e\+04 x 1e\+04 mm; the file's unit is metre"):
        read_step(metres)
    assert read_step(metres, scale=1e-3).volume == pytest.approx(1e-4, rel=1e-9)


def test_files_without_a_solid_say_so(tmp_path: Path) -> None:
    with pytest.raises(CadError, match="open shell of 5 faces"):
        read_step(step_file(tmp_path, "shell"))
    with pytest.raises(CadError, match="2 disconnected bodies") as caught:
        read_step(step_file(tmp_path, "apart"))
    assert "one part" in caught.value.mend
    garbage = tmp_path / "garbage.step"
    garbage.write_text("this is no STEP file\n")
    with pytest.raises(CadError, match=r"garbage\.step"):
        read_step(garbage)
    with pytest.raises(FileError, match="cannot be read"):
        read_step(tmp_path / "missing.step")


@pytest.mark.parametrize(
    ("function", "words"),
    [
        ("crash", r"crashed \(SIGABRT\)"),
        ("impossible_fillet", "impossible_fillet"),
        ("nowhere", "has no function nowhere"),
    ],
)
def test_a_failing_kernel_is_an_error_message(function: str, words: str) -> None:
    with pytest.raises(CadError, match=words):
        build_part(SHAPES, function)


def test_a_hanging_kernel_is_stopped(tmp_path: Path) -> None:
    job = {"script": str(SHAPES), "function": "hang", "arguments": {}, "scale": 1.0}
    with pytest.raises(CadError, match="did not end within 2 s"):
        run_child("build", tmp_path, job, doing="building", timeout=2.0)


def test_too_little_memory_is_an_error_message(tmp_path: Path) -> None:
    job = {"script": str(SHAPES), "function": "beam", "arguments": {}, "scale": 1.0}
    with pytest.raises(CadError, match="building failed"):
        run_child("build", tmp_path, job, doing="building", memory=5e7)
