"""The equations of single joints and of the tool, with their derivatives.

Velocities are linear in the rates of the unknowns, so a row of the Jacobian is collected from what
a unit rate of each unknown does to the bodies on the two sides of an equation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from stiffkit.kinematics.frames import AXES, ScalarFrame, rotation_error
from stiffkit.kinematics.locate import Located
from stiffkit.kinematics.tree import TreeJoint
from stiffkit.robot import Joint
from stiffkit.smallmat import (
    Matrix,
    Scalar,
    Vector,
    add,
    cross,
    dot,
    identity,
    is_structural,
    matmul,
    minus,
    multiply,
    scale,
    subtract,
    vector,
    zeros,
)


@dataclass(frozen=True, eq=False)
class Motion:
    """What a unit rate of one unknown does to a body, at one of its points; world axes."""

    unknown: int
    velocity: Vector
    omega: Vector


def motions_along(located: Located, path: Sequence[TreeJoint], point: Vector) -> list[Motion]:
    """Return what each coordinate along a path from the base does to the body at its end."""
    motions = []
    for tree_joint in path:
        screws = located.screws(tree_joint)
        arm = minus(point, screws.point)
        for offset, (kind, axis) in enumerate(screws.axes):
            index = tree_joint.coordinates.start + offset
            if kind == "t":
                motions.append(Motion(index, axis, zeros(3)))
            else:
                motions.append(Motion(index, cross(axis, arm), axis))
    return motions


Effect = Callable[[Motion], Vector]
"""What a motion of one side does to some residuals."""


@dataclass(frozen=True, eq=False)
class Sides:
    """The motions of the two sides of a joint."""

    left: list[Motion]
    """Of the ``from`` side."""
    right: list[Motion]
    """Of the ``to`` side."""

    def jacobian(self, shape: tuple[int, int], on_left: Effect, on_right: Effect) -> Matrix:
        """Return the derivatives (m, n) of m residuals from the effects on them."""
        J = zeros(*shape)
        for side, effect in ((self.left, on_left), (self.right, on_right)):
            for motion in side:
                for i, value in enumerate(effect(motion)):
                    J[i, motion.unknown] = add(J[i, motion.unknown], value)
        return J


class Rows:
    """Collects equations and leaves out those that hold identically."""

    def __init__(self, n: int, kept: Sequence[bool] | None) -> None:
        """Take the number of unknowns and, if known, which equations to keep."""
        self.n = n
        self.holds_identically: list[bool] = []
        self._kept = kept
        self._residuals: list[Scalar] = []
        self._rows: list[Vector] = []

    def add(self, residuals: Sequence[Scalar] | Vector, jacobian: Matrix) -> None:
        """Add equations ``residuals = 0`` with their derivatives (m, n)."""
        for residual, row in zip(residuals, jacobian, strict=True):
            trivial = all(is_structural(x, 0.0) for x in row)
            keep = not trivial if self._kept is None else self._kept[len(self.holds_identically)]
            self.holds_identically.append(trivial)
            if keep:
                self._residuals.append(residual)
                self._rows.append(row)

    @property
    def residuals(self) -> Vector:
        """All residuals, (m,)."""
        return vector(self._residuals)

    @property
    def jacobian(self) -> Matrix:
        """All derivatives, (m, n)."""
        jacobian = zeros(len(self._rows), self.n)
        for i, row in enumerate(self._rows):
            jacobian[i] = row
        return jacobian


def add_chord(
    rows: Rows,
    located: Located,
    chord: Joint,
    loop: tuple[list[TreeJoint], list[TreeJoint]],
    inverse_length: Scalar,
) -> None:
    """Add the directions that a chord joint blocks; lengths are multiplied by `inverse_length`."""
    left, right = located.from_side(chord), located.to_side(chord)
    sides = Sides(motions_along(located, loop[0], left.p), motions_along(located, loop[1], right.p))
    _add_gap(rows, sides, chord, left, right, inverse_length)
    turning = [AXES.index(m[1]) for m in chord.motions if m.startswith("r")]
    if len(turning) == 0:
        J = sides.jacobian((3, rows.n), lambda m: scale(-1.0, m.omega), lambda m: m.omega)
        rows.add(rotation_error(right.R, left.R), J)
    elif len(turning) == 1:
        a, b = left.R[:, turning[0]], right.R[:, turning[0]]
        J = sides.jacobian(
            (3, rows.n),
            lambda m: cross(cross(m.omega, a), b),
            lambda m: cross(a, cross(m.omega, b)),
        )
        rows.add(cross(a, b), J)
    elif len(turning) == 2:
        a, b = left.R[:, turning[0]], right.R[:, turning[1]]
        normal = cross(a, b)
        J = sides.jacobian(
            (1, rows.n),
            lambda m: vector([dot(normal, m.omega)]),
            lambda m: vector([multiply(-1.0, dot(normal, m.omega))]),
        )
        rows.add([dot(a, b)], J)


def _add_gap(
    rows: Rows,
    sides: Sides,
    chord: Joint,
    left: ScalarFrame,
    right: ScalarFrame,
    inverse_length: Scalar,
) -> None:
    """Add that the origins of both sides meet, but for the directions in which the joint slides."""
    gap = minus(right.p, left.p)
    sliding = [m for m in chord.motions if not m.startswith("r")]
    if not sliding:
        J = sides.jacobian((3, rows.n), lambda m: scale(-1.0, m.velocity), lambda m: m.velocity)
        rows.add(scale(inverse_length, gap), scale(inverse_length, J))
        return
    # Where the joint slides, the gap is measured along axes that turn with its ``from`` side.
    axes = left.R.T[[i for i, axis in enumerate(AXES) if axis not in sliding]]
    J = sides.jacobian(
        (len(axes), rows.n),
        lambda m: vector(subtract(dot(cross(m.omega, n), gap), dot(n, m.velocity)) for n in axes),
        lambda m: matmul(axes, m.velocity),
    )
    rows.add(scale(inverse_length, matmul(axes, gap)), scale(inverse_length, J))


def add_position(
    rows: Rows,
    motions: list[Motion],
    position: Vector,
    wanted: dict[int, Scalar],
    inverse_length: Scalar,
) -> None:
    """Add that some coordinates of a position have the values wanted."""
    axes = identity(3)[list(wanted)]
    J = Sides(motions, []).jacobian(
        (len(wanted), rows.n), lambda m: matmul(axes, m.velocity), lambda _m: zeros(len(wanted))
    )
    residuals = vector(position[i] - value for i, value in wanted.items())
    rows.add(scale(inverse_length, residuals), scale(inverse_length, J))


def angular_jacobian(n: int, motions: list[Motion]) -> Matrix:
    """Return the angular velocity (3, n) of a body for a unit rate of each unknown."""
    return Sides(motions, []).jacobian((3, n), lambda m: m.omega, lambda _m: zeros(3))
