"""A robot whose best dimensions are known: a cantilever on a slide.

Its tip yields by ``4 F L^3 / (E w h^3)`` under a force F across, and it weighs ``rho L w h``.
"""

from __future__ import annotations

from pathlib import Path

from stiffkit.design import DesignSpec, read_design
from stiffkit.link import MATERIALS

ROBOT = """\
robot: Cantilever on a slide
parameters:
  length: 1 m
  width: 40 mm
  height: 40 mm
  travel: 100 mm
  teeth: 12
  tooth: 1e5 N/m
  twice: = 2 * width
links:
  arm:
    beam:
      length: = length
      section:
        given:
          area: = width * height
          Iy: = width * height^3 / 12
          Iz: = height * width^3 / 12
          torsion: = width * height^3 / 12
      material: steel
joints:
  slide: {prismatic: y, from: base, to: arm.base, drive: = tooth * teeth}
tool: {at: arm.tip, mass: 5 kg}
home: {y: 0}
workspace: {y: [= -travel, = travel]}
loads:
  weight: {force: [0, 0, -100 N]}
  push: {force: [0, 100 N, 0]}
"""

E = MATERIALS["steel"].E
DENSITY = MATERIALS["steel"].density or 0.0
TOOL = 5.0


def sag(width: float, height: float, length: float = 1.0, force: float = 100.0) -> float:
    """Return the deflection of the tip under its weight, m."""
    return 4.0 * force * length**3 / (E * width * height**3)


def mass(width: float, height: float, length: float = 1.0) -> float:
    """Return the mass of arm and tool, kg."""
    return TOOL + DENSITY * length * width * height


def design(folder: Path, text: str, name: str = "study.yaml") -> DesignSpec:
    """Return a study of the cantilever; ``text`` is what follows title and robot."""
    (folder / "cantilever.yaml").write_text(ROBOT, encoding="utf-8")
    path = folder / name
    path.write_text(f"design: Arm\nrobot: cantilever.yaml\n{text}", encoding="utf-8")
    return read_design(path)
