"""stiffkit at the same task: the robot as a file, postures in batches."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.measure import median_cost
from benchmarks.peers import case
from stiffkit import __version__
from stiffkit.robot import Robot, load_robot
from stiffkit.stiffness import full_matrices
from stiffkit.study import Analysis
from stiffkit.vibration import FastModes, ModalModel

BATCH = 20_000
WAY = "robot file; home posture found before; postures in batches of 20 000"


def robot() -> Robot:
    """Return the robot of the task."""
    section = (
        f"{{given: {{area: {case.AREA}, Iy: {case.I_Y}, Iz: {case.I_Z}, torsion: {case.TORSION}}}}}"
    )
    legs = [
        f"  leg_{i + 1}: {{beam: {{length: {length}, section: {section}, material: leg_steel}}}}"
        for i, length in enumerate(case.LENGTHS)
    ]
    text = "\n".join(
        [
            "robot: Biglide with beam legs",
            f"materials: {{leg_steel: {{E: {case.E_MODULUS}, nu: {case.NU},"
            f" density: {case.DENSITY}}}}}",
            "links:",
            "  slider_1: {rigid: {}}",
            "  slider_2: {rigid: {}}",
            *legs,
            "joints:",
            f"  slide_1: {{prismatic: y, from: base, to: slider_1.base, drive: {case.DRIVE}}}",
            f"  slide_2: {{prismatic: y, from: base, at: [{case.A}, 0, 0], to: slider_2.base,"
            f" drive: {case.DRIVE}}}",
            "  hinge_1: {revolute: z, from: slider_1.base, to: leg_1.base}",
            "  hinge_2: {revolute: z, from: slider_2.base, to: leg_2.base}",
            "  hinge_P: {revolute: z, from: leg_1.tip, to: leg_2.tip}",
            f"tool: {{at: leg_1.tip, mass: {case.TOOL_MASS}}}",
            "home: {x: 0.5, y: 0, hinge_1: 55 deg, hinge_2: 125 deg}",
            "workspace: {x: [0.25, 0.75], y: [-0.1, 0.1]}",
        ]
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "biglide-beams.yaml")
        path.write_text(text, encoding="utf-8")
        return load_robot(str(path))


def run(n: int) -> case.Answer:
    """Return the answer at n postures."""
    analysis = Analysis(robot())
    kinematics = analysis.kinematics
    wanted = np.array([[p.x, p.y] for p in case.postures(n)]).T
    many = np.resize(wanted.T, (BATCH, 2)).T
    one = wanted[:, :1]

    def compliance(asked: np.ndarray) -> np.ndarray:
        lower = analysis.refined.at(kinematics.solve(asked)).lower
        return full_matrices(lower)[:3, :3].transpose(2, 0, 1)

    start = time.process_time()
    compliance(one)
    first_static = time.process_time() - start
    static = compliance(wanted)
    static_seconds = median_cost(lambda: compliance(many), 3).cpu

    full = ModalModel(kinematics.tree, kinematics.length)

    def first() -> object:
        return full.at(kinematics.solve(one).coordinates[:, 0], case.N_MODES)

    first_modes = median_cost(first, 3).cpu
    fast = FastModes(full, kinematics.solve(wanted).coordinates, case.N_MODES)

    def frequencies(asked: np.ndarray) -> np.ndarray:
        return np.asarray(fast.frequencies(kinematics.solve(asked).coordinates))

    return case.Answer(
        *("stiffkit", __version__, WAY),
        static.tolist(),
        frequencies(wanted).T.tolist(),
        *(first_static, first_modes),
        *(BATCH / static_seconds, BATCH / median_cost(lambda: frequencies(many), 3).cpu),
    )
