"""A displacement field of the tip of a cantilever, and a specification for it, in a directory."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.unit.identified_beam import CASES, LOADS, POISSON, TIP, beam_compliance, displaced, face

SIGMA = 5e-8

SPEC = """\
identify: Cantilever of the paper
units: {length: mm}
fields: beam.csv
reference: [1000 mm, 0, 0]
loads:
  Fx: {force: [1000 N, 0, 0]}
  Fy: {force: [0, 1 N, 0]}
  Fz: {force: [0, 0, 1 N]}
  Mx: {moment: [1 N m, 0, 0]}
  My: {moment: [0, 1 N m, 0]}
  Mz: {moment: [0, 0, 1 N m]}
outliers: {drop: 10 %}
compare:
  core: {select: {near: 3 mm}}
"""


def write_identification(here: Path) -> Path:
    """Write ``beam.csv``, whose first load case shrinks the face, and return ``beam.yaml``."""
    points = face(15)
    u = displaced(points, beam_compliance(), LOADS, SIGMA, seed=3)
    strain = LOADS[0, 0] / (2e11 * 1e-4)
    u[0, :, 1:] -= POISSON * strain * (points - TIP)[:, 1:]
    heads = ["node", "x", "y", "z", *(f"{case}:u{axis}" for case in CASES for axis in "xyz")]
    table = np.column_stack([np.arange(1, len(points) + 1), 1e3 * points, *(1e3 * u)])
    np.savetxt(here / "beam.csv", table, "%.12g", ",", header=",".join(heads), comments="")
    spec = here / "beam.yaml"
    spec.write_text(SPEC, encoding="utf-8")
    return spec
