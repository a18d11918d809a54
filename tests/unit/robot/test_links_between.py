"""CAD links that are interpolated over ranges of parameters, in robot files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffkit.errors import FileError
from stiffkit.robot import RobotFile, load_robot

pytest.importorskip("ngsolve")

ROBOT = """
robot: One bar on a slide
parameters: {span: 310 mm, drive: 1e7 N/m}
links:
  bar:
    cad:
      part: orthoglide-bar
      dimensions: {length: = span}
      BETWEEN
      material: aluminium
      base: {faces: {name: base, count: any}, interface: clamped}
      tip: {faces: {name: tip, count: any}, interface: average}
      mesh: {size: 30 mm, order: 2}
      tolerance: 20 %
joints:
  slide: {prismatic: x, from: base, to: bar.base, drive: = drive}
tool: {at: bar.tip, mass: 1 kg}
home: {x: = span}
workspace: {x: [= span, = span + 50 mm]}
"""


@pytest.fixture(autouse=True, scope="module")
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


def written(folder: Path, between: str) -> Path:
    path = folder / "bar.yaml"
    path.write_text(ROBOT.replace("BETWEEN", between), encoding="utf-8")
    return path


def test_between_solutions(tmp_path: Path) -> None:
    file = RobotFile(written(tmp_path, "between: {span: [300 mm, 320 mm]}"))
    ends = [file.robot({"span": span}).links["bar"] for span in ("300 mm", "320 mm")]
    middle = file.robot({"span": "310 mm"}).links["bar"]
    own = load_robot(written(tmp_path, ""), {"span": "310 mm"}).links["bar"]
    # The middle is one of the points that are solved.
    assert own.compliance is not None
    assert middle.compliance is not None
    np.testing.assert_allclose(middle.compliance, own.compliance, rtol=1e-6, atol=1e-12)
    assert middle.ports["tip"].position[0] == pytest.approx(0.310)
    assert middle.mass == pytest.approx(own.mass)
    off = file.robot({"span": "304 mm"})
    soft = [float(link.compliance[2, 2]) for link in ends if link.compliance is not None]
    between = off.links["bar"].compliance
    assert between is not None
    assert soft[0] < between[2, 2] < soft[1]
    assert off.links["bar"].cad is None
    assert any("solutions of the part" in note for note in off.notes)


@pytest.mark.parametrize(
    ("between", "said"),
    [
        ("between: {spam: [300 mm, 320 mm]}", "there is no parameter 'spam'"),
        ("between: {span: [320 mm, 300 mm]}", "the range is empty"),
        ("between: {span: [300 kg, 320 kg]}", "'300 kg' is a mass"),
        ("between: {span: [100 mm, 120 mm]}", "span is 0.31"),
        ("between: {}", "between"),
    ],
)
def test_what_cannot_be(tmp_path: Path, between: str, said: str) -> None:
    with pytest.raises(FileError) as raised:
        load_robot(written(tmp_path, between))
    assert said in str(raised.value)
