"""Pinocchio: rigid pieces joined by springs, the rest by NumPy.

Pinocchio knows rigid bodies only. Who wants elastic links cuts them into rigid pieces and puts a
spring of six directions in the middle of each element of the beam, with the compliance that the
element has there, which makes statics exact. Pinocchio then gives the mass and the Jacobians.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pinocchio as pin  # type: ignore[import-not-found]
from numpy.typing import NDArray
from scipy.linalg import eigh

from benchmarks.peers import case

Array = NDArray[np.float64]

WAY = (
    "model built once, moved by its coordinates; rigid pieces and springs, the hinge at P an"
    " equation; mass and Jacobians by Pinocchio, solved by NumPy and SciPy"
)


def _rod(length: float) -> Any:
    """Return the inertia of a piece of a leg, which begins at the origin and goes along x."""
    mass = case.DENSITY * case.AREA * length
    polar, across = case.DENSITY * (case.I_Y + case.I_Z) * length, mass * length**2 / 12.0
    y, z = (across + case.DENSITY * inertia * length for inertia in (case.I_Y, case.I_Z))
    return pin.Inertia(mass, _along(length / 2.0).translation, np.diag([polar, y, z]))


def _along(x: float) -> Any:
    return pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))


def _spring(length: float) -> list[float]:
    """Return the stiffness of an element of a leg in its middle, where nothing is coupled."""
    E, G = case.E_MODULUS, case.G_MODULUS
    return [
        *(E * case.AREA / length, 12.0 * E * case.I_Z / length**3, 12.0 * E * case.I_Y / length**3),
        *(G * case.TORSION / length, E * case.I_Y / length, E * case.I_Z / length),
    ]


class Chains:
    """Both legs, open at P."""

    def __init__(self, elements: int) -> None:
        """Build them of so many elements each."""
        self.model = pin.Model()
        stiffness: list[float] = []
        for leg in (0, 1):
            stiffness += self._add_leg(leg, elements)
        self.stiffness = np.diag(stiffness)
        self.data = self.model.createData()
        self.tips = [self.model.getFrameId(f"tip {leg}") for leg in (0, 1)]

    def _add_leg(self, leg: int, elements: int) -> list[float]:
        """Add a leg, and return the stiffness of each of its coordinates."""
        model, step = self.model, case.LENGTHS[leg] / elements
        slide = model.addJoint(0, pin.JointModelPY(), _along(leg * case.A), f"slide {leg}")
        body = model.addJoint(slide, pin.JointModelRZ(), pin.SE3.Identity(), f"hinge {leg}")
        length = step / 2.0
        for i in range(elements):
            model.appendBodyToJoint(body, _rod(length), pin.SE3.Identity())
            spring = pin.JointModelFreeFlyer()
            body = model.addJoint(body, spring, _along(length), f"spring {leg} {i}")
            length = step
        end = _along(step / 2.0)
        model.appendBodyToJoint(body, _rod(step / 2.0), pin.SE3.Identity())
        if leg == 0:
            tool = pin.Inertia(case.TOOL_MASS, np.zeros(3), np.zeros((3, 3)))
            model.appendBodyToJoint(body, tool, end)
        model.addFrame(pin.Frame(f"tip {leg}", body, 0, end, pin.FrameType.OP_FRAME))
        return [case.DRIVE, 0.0, *(_spring(step) * elements)]

    def at(self, posture: case.Posture) -> tuple[Array, Array, Array]:
        """Put the legs into a posture, and return what Pinocchio finds there.

        For n coordinates: the mass (n, n), the motion of P (3, n) with leg 1, and what must be zero
        (5, n): the legs' tips stay at one place and turn alike, but about z.
        """
        model, data = self.model, self.data
        q = pin.neutral(model)
        half = model.nq // 2
        for leg, (x, y) in enumerate(posture.sliders):
            q[leg * half : leg * half + 2] = y, math.atan2(posture.y - y, posture.x - x)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        first, second = (
            pin.getFrameJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED) for tip in self.tips
        )
        return pin.crba(model, data, q), first[:3], (first - second)[:5]


def run(n: int) -> case.Answer:
    """Return the answer at n postures."""
    coarse, fine = Chains(1), Chains(case.ELEMENTS)

    def compliance(posture: case.Posture) -> case.Matrix:
        _, motion, gaps = coarse.at(posture)
        size, equations = coarse.model.nv, len(gaps)
        # Stationary energy, with the wrench that closes the loop.
        system = np.block([[coarse.stiffness, gaps.T], [gaps, np.zeros((equations, equations))]])
        loads = np.vstack([motion.T, np.zeros((equations, 3))])
        found: case.Matrix = (motion @ np.linalg.solve(system, loads)[:size]).tolist()
        return found

    def frequencies(posture: case.Posture) -> list[float]:
        mass, _, gaps = fine.at(posture)
        free = np.linalg.qr(gaps.T, mode="complete")[0][:, len(gaps) :]
        lowest = eigh(
            *(free.T @ fine.stiffness @ free, free.T @ mass @ free),
            eigvals_only=True,
            subset_by_index=[0, case.N_MODES - 1],
        )
        return [math.sqrt(value) / (2.0 * math.pi) for value in lowest]

    return case.answer("Pinocchio", pin.__version__, WAY, compliance, frequencies, n)
