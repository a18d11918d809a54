"""The equations that a posture fulfils, their Jacobian, and one Newton step as a kernel.

Unknowns are the coordinates of the spanning tree, and those rotation coordinates of the tool that
follow from the mechanism where others are asked for. Equations are: each chord joint's blocked
directions, and the tool coordinates asked for. Redundant equations (over-constrained loops) and
redundant unknowns (a rod that can spin) are both allowed: the step is the damped least-squares one.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Constants, Kernel
from stiffkit.kinematics.equations import (
    Motion,
    Rows,
    add_chord,
    add_position,
    angular_jacobian,
    motions_along,
)
from stiffkit.kinematics.frames import (
    AXES,
    ScalarFrame,
    exp_rotation,
    exp_rotation_rate,
    rotation_error,
)
from stiffkit.kinematics.locate import Located, add_geometry
from stiffkit.kinematics.tree import SpanningTree
from stiffkit.robot import DIRECTIONS
from stiffkit.smallmat import (
    Factors,
    Matrix,
    Scalar,
    Vector,
    add,
    as_objects,
    dot,
    factor,
    gram,
    is_structural,
    matmul,
    multiply,
    reciprocal,
    scale,
    vector,
    zeros,
)
from stiffkit.spatial import log_rotation

Array = NDArray[np.float64]

DAMPING = 1e-12
"""Added to the diagonal of the normal matrix, whose entries are of order one. It fixes what a loop
leaves undetermined and slows Newton's method only where a singular value is below 1e-6."""


@dataclass(frozen=True, eq=False)
class Equations:
    """Residuals (m,) and their derivatives (m, n) with respect to the unknowns."""

    residuals: Vector
    jacobian: Matrix


class ClosureEquations:
    """The closure of a mechanism, with the tool coordinates that are asked for."""

    def __init__(
        self,
        tree: SpanningTree,
        asked: Sequence[str],
        length: float,
        *,
        any_geometry: bool = False,
    ) -> None:
        """Take the tool coordinates asked for and a length (m) that makes equations unit-free.

        With ``any_geometry`` only those equations are left out that hold identically whatever the
        constants are that are not compiled in, so that kernels serve other geometries too.
        """
        self.tree = tree
        self.asked = tuple(asked)
        self.length = length
        rotations = [d for d in DIRECTIONS if d.startswith("r")]
        asks_rotation = any(d in self.asked for d in rotations)
        self.auxiliary = tuple(d for d in rotations if asks_rotation and d not in self.asked)
        """Rotation coordinates of the tool that are unknowns beside the tree's coordinates."""
        self.constants = Constants()
        add_geometry(self.constants, tree.robot)
        self.constants.add("length", np.array([length]))

        self._kept = self._structure(any_geometry)

    @property
    def translates(self) -> list[bool]:
        """Whether each unknown is a length (m); the others are angles (rad)."""
        motions = self.tree.motions + list(self.auxiliary)
        return [not motion.startswith("r") for motion in motions]

    def _structure(self, any_geometry: bool) -> list[bool]:
        # Arrays are never structural zeros, so what vanishes here vanishes in every posture.
        opaque = vector(np.ones(1) for _ in range(self.n_unknowns + len(self.asked)))
        rows = Rows(self.n_unknowns, None)
        with np.errstate(all="ignore"):
            self._fill(rows, opaque, self._known_constants(any_geometry))
        self.elimination_order = _elimination_order(rows.jacobian)
        """Order of the unknowns in which the normal matrix stays sparse."""
        self._order_of_equations = _elimination_order(rows.jacobian.T)
        return [not trivial for trivial in rows.holds_identically]

    def _known_constants(self, any_geometry: bool) -> Vector:
        values = as_objects(self.constants.values)
        if any_geometry:
            for i in np.flatnonzero(~self.constants.compiled_in):
                values[i] = np.array([values[i]])
        return values

    @property
    def topology(self) -> Hashable:
        """What decides the shape of kernels made of these equations, apart from constants."""
        # Whether an equation holds identically may be due to constants, such as equal angles.
        orders = (tuple(self.elimination_order), tuple(self._order_of_equations))
        return (self.tree.topology, self.asked, tuple(self._kept), *orders)

    @property
    def n_equations(self) -> int:
        """Equations that do not hold identically."""
        return sum(self._kept)

    @property
    def n_unknowns(self) -> int:
        """Coordinates of the tree and auxiliary ones."""
        return self.tree.n_coordinates + len(self.auxiliary)

    def equations(self, inputs: Vector, c: Vector) -> Equations:
        """Return the equations at the unknowns (SI), followed by the values asked for.

        Residual lengths are over `length`; derivatives are with respect to unknowns in SI.
        """
        rows = Rows(self.n_unknowns, self._kept)
        self._fill(rows, inputs, c)
        return Equations(rows.residuals, rows.jacobian)

    def _fill(self, rows: Rows, inputs: Vector, c: Vector) -> None:
        unknowns, asked = inputs[: self.n_unknowns], inputs[self.n_unknowns :]
        located = Located(self.tree, self.constants, unknowns, c)
        inverse_length = reciprocal(self.constants.read(c, "length")[0])
        for chord in self.tree.chords:
            add_chord(rows, located, chord, self.tree.loop(chord), inverse_length)
        if not self.asked:
            return
        motions = motions_along(located, self.tree.path(self.tree.robot.tool.body), located.tool.p)
        wanted = dict(zip(self.asked, asked, strict=True))
        position = {i: wanted[axis] for i, axis in enumerate(AXES) if axis in wanted}
        add_position(rows, motions, located.tool.p, position, inverse_length)
        if any(d.startswith("r") for d in self.asked):
            extra = zip(self.auxiliary, unknowns[self.tree.n_coordinates :], strict=True)
            self._add_orientation(rows, located, motions, wanted | dict(extra))

    def _add_orientation(
        self, rows: Rows, located: Located, motions: list[Motion], rotation: dict[str, Scalar]
    ) -> None:
        w = vector(rotation[f"r{axis}"] for axis in AXES)
        J = angular_jacobian(rows.n, motions)
        rate = exp_rotation_rate(w)
        for offset, name in enumerate(self.auxiliary):
            J[:, self.tree.n_coordinates + offset] = scale(-1.0, rate[:, AXES.index(name[1])])
        rows.add(rotation_error(located.tool.R, exp_rotation(w)), J)

    def tool_twists(self, located: Located) -> Matrix:
        """Return the tool's twist (6, n) for a unit rate of each coordinate of the tree, SI.

        World axes, at the tool point.
        """
        columns = zeros(6, self.tree.n_coordinates)
        point = located.tool.p
        for m in motions_along(located, self.tree.path(self.tree.robot.tool.body), point):
            columns[:3, m.unknown] = m.velocity
            columns[3:, m.unknown] = m.omega
        return columns

    def newton_step(self) -> Kernel:
        """Return the kernel of one step.

        Inputs: unknowns (SI), then the values asked for. Outputs: the improved unknowns (SI); the
        sum of squares of the residuals before the step, and that of the step itself, unit-free;
        and the response (n) of the unknowns to a disturbance of the equations that is always the
        same. It grows without bound towards a posture where branches meet, and comes back from
        infinity with the other sign on the other branch.
        """
        n = self.n_unknowns
        translates = self.translates

        def step(inputs: Vector, c: Vector) -> Vector:
            length = self.constants.read(c, "length")[0]
            eq = self.equations(inputs, c)
            A = zeros(*eq.jacobian.shape)
            for position, j in enumerate(self.elimination_order):
                A[:, position] = scale(length if translates[j] else 1.0, eq.jacobian[:, j])
            factors = _damped(gram(A))
            solution = factors.solve(matmul(A.T, scale(-1.0, eq.residuals)))
            response = factors.solve(matmul(A.T, _disturbance(len(eq.residuals))))
            improved = inputs[:n].copy()
            for j, dx in zip(self.elimination_order, solution, strict=True):
                improved[j] = add(improved[j], multiply(length if translates[j] else 1.0, dx))
            sizes = [dot(eq.residuals, eq.residuals), dot(solution, solution)]
            return vector([*improved, *sizes, *response])

        return Kernel(
            "newton step",
            step,
            n + len(self.asked),
            self.constants,
            self.topology,
        )

    def residuals(self) -> Kernel:
        """Return the kernel of the equations.

        Inputs: unknowns (SI), then the values asked for. Outputs: the residuals, unit-free.
        """

        def residuals(inputs: Vector, c: Vector) -> Vector:
            return self.equations(inputs, c).residuals

        n_inputs = self.n_unknowns + len(self.asked)
        return Kernel("closure", residuals, n_inputs, self.constants, self.topology)

    def multipliers(self) -> Kernel:
        """Return the kernel of how much each equation's violation would change a function.

        Inputs: unknowns (SI), the values asked for, and the derivatives of the function by the
        unknowns. Outputs: its derivatives by the residuals, for unknowns that follow these by the
        smallest step. They are the adjoint's right side in the implicit function theorem.
        """
        n = self.n_unknowns
        n_inputs = n + len(self.asked)
        order = self._order_of_equations

        def multipliers(inputs: Vector, c: Vector) -> Vector:
            length = self.constants.read(c, "length")[0]
            eq = self.equations(inputs[:n_inputs], c)
            units = [length if translates else 1.0 for translates in self.translates]
            A = zeros(*eq.jacobian.shape)
            for position, row in enumerate(order):
                for j in range(n):
                    A[position, j] = multiply(units[j], eq.jacobian[row, j])
            gradient = vector(multiply(u, x) for u, x in zip(units, inputs[n_inputs:], strict=True))
            # By the rows, so that motions that are left free drop out before anything is divided.
            found = _damped(gram(A.T)).solve(matmul(A, gradient))
            multipliers = zeros(len(order))
            for position, row in enumerate(order):
                multipliers[row] = found[position]
            return multipliers

        return Kernel("multipliers", multipliers, n_inputs + n, self.constants, self.topology)

    def observation(self) -> Kernel:
        """Return the kernel that reads a posture.

        Inputs: coordinates of the tree. Outputs: T_world_tool, then for each chord the frame of its
        ``to`` side in that of its ``from`` side; each as 9 entries of R row by row and 3 of p.
        """

        def observe(q: Vector, c: Vector) -> Vector:
            located = Located(self.tree, self.constants, q, c)
            frames = [located.tool]
            for chord in self.tree.chords:
                frames.append(located.from_side(chord).inverse @ located.to_side(chord))
            return vector(x for frame in frames for x in _flatten(frame))

        return Kernel(
            "observation",
            observe,
            self.tree.n_coordinates,
            self.constants,
            (self.tree.topology,),
        )


def _unit(i: int) -> Vector:
    e = zeros(3)
    e[i] = 1.0
    return e


def _flatten(frame: ScalarFrame) -> list[Scalar]:
    return [*frame.R.ravel(), *frame.p]


def tool_jacobian(
    closure: ClosureEquations, q: Array, *, rotation_vector_rates: bool = False
) -> Array:
    """Return the tool's twist (6, n) for a unit rate of each unknown, at one posture.

    World axes, at the tool point; lengths over `ClosureEquations.length`. With
    ``rotation_vector_rates`` the last three rows are the rates of the tool's rotation vector
    instead of its angular velocity.
    """
    located = Located(
        closure.tree, closure.constants, as_objects(q), as_objects(closure.constants.values)
    )
    columns = np.array(closure.tool_twists(located), dtype=float)
    columns[:3] /= closure.length
    if rotation_vector_rates:
        w = log_rotation(np.array(located.tool.R, dtype=float))
        rate = np.array(exp_rotation_rate(as_objects(w)), dtype=float)
        columns[3:] = np.linalg.solve(rate, columns[3:])
    translating = [not motion.startswith("r") for motion in closure.tree.motions]
    columns[:, translating] *= closure.length
    return columns


def _disturbance(n: int) -> Vector:
    """Return residuals (n,) that have a part in any direction: the golden angle never repeats."""
    return vector(math.cos(2.399963 * i) for i in range(n))


def _damped(normal: Matrix) -> Factors:
    """Return the factors of a normal matrix with `DAMPING`."""
    for j in range(len(normal)):
        normal[j, j] = add(normal[j, j], DAMPING)
    return factor(normal)


def _elimination_order(A: Matrix) -> list[int]:
    """Return an order of the columns of A that keeps the factors of ``A^T A`` sparse.

    Minimum degree: legs that hang together only through the platform come out one after another.
    """
    occupied = [
        {j for j in range(A.shape[1]) if not is_structural(A[i, j], 0.0)} for i in range(A.shape[0])
    ]
    neighbours = {
        j: set().union(*(row for row in occupied if j in row)) - {j} for j in range(A.shape[1])
    }
    order: list[int] = []
    while neighbours:
        j = min(neighbours, key=lambda k: (len(neighbours[k]), k))
        clique = neighbours.pop(j)
        for k in clique:
            neighbours[k] = (neighbours[k] | clique) - {j, k}
        order.append(j)
    return order
