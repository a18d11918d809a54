"""The simplified model: Jacobian and drives only, as a posture kernel.

``k = J K^-1 J^T`` (Briot et al. 2009, eqs 1 and 2), where J maps the rates of the drives to the
twist of the tool and K holds the stiffnesses of the drives.
"""

from __future__ import annotations

import numpy as np

from stiffkit.compiled import Kernel
from stiffkit.kinematics import ClosureEquations
from stiffkit.kinematics.closure import DAMPING
from stiffkit.kinematics.locate import Located
from stiffkit.robot import DIRECTIONS, Freedom
from stiffkit.smallmat import (
    Matrix,
    Scalar,
    Vector,
    add,
    dot,
    factor,
    gram,
    lower_triangle,
    matmul,
    minus,
    multiply,
    outer_sum,
    reciprocal,
    scale,
    vector,
    zeros,
)

_REFINEMENTS = 2
"""Steps of iterative refinement, which take the damping out of the solution again."""


class SimplifiedModel:
    """The Jacobian of a robot with as many drives as degrees of freedom."""

    def __init__(self, loops: ClosureEquations) -> None:
        """Take the closure without any tool coordinates asked for."""
        self.loops = loops
        tree = loops.tree
        self.driven: list[int] = []
        self.drive_names: list[str] = []
        compliances: list[float] = []
        for t in tree.joints:
            for offset, motion in enumerate(t.joint.motions):
                i = DIRECTIONS.index(motion)
                if t.joint.freedoms[i] is Freedom.DRIVEN:
                    self.driven.append(t.coordinates.start + offset)
                    self.drive_names.append(f"{t.joint.name}.{motion}")
                    compliances.append(1.0 / t.joint.stiffness[i])
        self.passive = [j for j in loops.elimination_order if j not in self.driven]
        self.constants = loops.constants.extended("drives", np.array(compliances))

    def kernel(self) -> Kernel:
        """Return the kernel of the tool's compliance.

        Inputs: coordinates of the tree. Outputs: the lower triangle of the compliance (21, SI,
        world axes, at the tool point); the leverage of the passive joints on the tool, which
        grows without bound towards a posture where the tool moves with the drives locked;
        and the Jacobian (6 n_drives, row by row, SI).
        """
        loops = self.loops

        def compliance(q: Vector, c: Vector) -> Vector:
            located = Located(loops.tree, self.constants, q, c)
            length = self.constants.read(c, "length")[0]
            A = _unit_free(loops.equations(q, c).jacobian, loops.translates, length)
            T = _unit_free(loops.tool_twists(located), loops.translates, length)
            T[:3] = scale(reciprocal(length), T[:3])
            J, leverage = _jacobian(
                A[:, self.passive], A[:, self.driven], T[:, self.passive], T[:, self.driven]
            )
            J[:3] = scale(length, J[:3])
            for column, j in enumerate(self.driven):
                if loops.translates[j]:
                    J[:, column] = scale(reciprocal(length), J[:, column])
            k = zeros(6, 6)
            for column, drive in enumerate(self.constants.read(c, "drives")):
                k = outer_sum(k, J[:, column], drive)
            return vector([*lower_triangle(k), leverage, *J.ravel()])

        topology = (loops.topology, tuple(self.drive_names))
        return Kernel("jacobian", compliance, loops.n_unknowns, self.constants, topology)


def _unit_free(A: Matrix, translates: list[bool], length: Scalar) -> Matrix:
    scaled = A.copy()
    for j, translating in enumerate(translates):
        if translating:
            scaled[:, j] = scale(length, A[:, j])
    return scaled


def _jacobian(A_p: Matrix, A_a: Matrix, T_p: Matrix, T_a: Matrix) -> tuple[Matrix, Scalar]:
    """Return J = T_a - T_p A_p^+ A_a, and the sum over the rows of |T_p A_p^+|^2."""
    normal = gram(A_p)
    for j in range(normal.shape[0]):
        normal[j, j] = add(normal[j, j], DAMPING)
    factors = factor(normal)
    J = zeros(6, A_a.shape[1])
    for column in range(A_a.shape[1]):
        p = zeros(normal.shape[0])
        for _ in range(1 + _REFINEMENTS):
            residual = matmul(A_p, p)
            residual = vector(add(r, a) for r, a in zip(residual, A_a[:, column], strict=True))
            p = minus(p, factors.solve(matmul(A_p.T, residual)))
        moved = matmul(T_p, p)
        J[:, column] = vector(add(x, y) for x, y in zip(moved, T_a[:, column], strict=True))
    leverage: Scalar = 0.0
    for row in T_p:
        half = factors.solve_half(row)
        weighted = vector(multiply(d, x) for d, x in zip(factors.inverse_pivots, half, strict=True))
        leverage = add(leverage, dot(half, weighted))
    return J, leverage
