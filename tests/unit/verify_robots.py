"""Robots of CAD parts that the verification's tests share; the parts are solid bars."""

from __future__ import annotations

import subprocess
import sys
import zlib
from pathlib import Path

from stiffkit.robot import Robot, load_robot

_MAKE = """
from netgen.occ import Box, X
for name, length, width, height in (("arm", 200, 20, 12), ("rod", 350, 16, 10)):
    bar = Box((0, -width / 2, -height / 2), (length, width / 2, height / 2))
    bar.faces.Min(X).name, bar.faces.Max(X).name = "a", "b"
    bar.WriteStep(f"{name}.step")
"""

_BAR = (
    "{{cad: {{file: {part}.step, material: steel, base: {{faces: {{name: a}}, interface: {base}}}, "
    "tip: {{faces: {{name: b}}, interface: {tip}}}, mesh: {{size: 20 mm, order: {order}}}}}}}"
)

FIVE_BAR = """\
robot: Five-bar of parts
links:
  left_arm: {arm}
  left_rod: {rod}
  right_arm: {{like: left_arm}}
  right_rod: {{like: left_rod}}
joints:
  motor_left: {{revolute: z, from: base, at: [-150 mm, 0, 0], to: left_arm.base, drive: 2e4}}
  elbow_left: {{revolute: z, from: left_arm.tip, to: left_rod.base}}
  motor_right: {{revolute: z, from: base, at: [150 mm, 0, 0], to: right_arm.base, drive: 2e4}}
  elbow_right: {{revolute: z, from: right_arm.tip, to: right_rod.base}}
  wrist: {{revolute: z, from: left_rod.tip, to: right_rod.tip}}
tool: {{at: left_rod.tip, mass: 1.5 kg}}
home: {{x: 0, y: 400 mm, motor_left: 120 deg, motor_right: 60 deg}}
"""
"""Over-constrained: both sides hold the wrist in its plane."""

SLIDE = """\
robot: Slide on a rod
links:
  mast: {rod}
  rod: {arm}
  table:
    rigid: {{ports: {{side: {{at: [0, 101.9 mm, 50 mm]}}}}}}
    mass: 2 kg
    center_of_mass: [0, 0, 20 mm]
    inertia: [[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.02]]
joints:
  root: {{fixed: true, from: base, to: mast.base}}
  slide:
    prismatic: z
    from: mast.tip
    to: table
    drive: 1e6 N/m
    elastic: {{rx: 1e5 N m/rad, y: 2e7 N/m}}
  low: {{{low}, from: base, at: [350 mm, 250 mm, 100 mm], to: rod.base}}
  high: {{spherical: true, from: rod.tip, to: table.side}}
tool: {{at: table, mass: 1 kg}}
home: {{slide: 10 mm}}
"""
"""A rigid body, elastic bearings, a fixed joint, and a rod that can spin if `low` is spherical."""


def make_parts(folder: Path) -> None:
    """Write the STEP files of the bars."""
    subprocess.run([sys.executable, "-c", _MAKE], cwd=folder, check=True, capture_output=True)


def write_robot(
    folder: Path, text: str, base: str, tip: str, *, order: int = 2, **words: str
) -> Path:
    """Write the file of a robot with bars of these interfaces into the folder of their parts."""
    bars = {
        part: _BAR.format(part=part, base=base, tip=tip, order=order) for part in ("arm", "rod")
    }
    text = text.format(**bars, **words)
    path = folder / f"{base}-{tip}-{zlib.crc32(text.encode()):x}.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def robot(folder: Path, text: str, base: str, tip: str, *, order: int = 2, **words: str) -> Robot:
    """Return a robot with bars of these interfaces; its file is in the folder."""
    return load_robot(write_robot(folder, text, base, tip, order=order, **words))
