"""Frames and joint motions in the kernels' scalars."""

from __future__ import annotations

from dataclasses import dataclass

from stiffkit.compiled import Constants
from stiffkit.robot import Joint
from stiffkit.smallmat import (
    Matrix,
    Scalar,
    Vector,
    add,
    cos,
    identity,
    matmul,
    multiply,
    plus,
    scale,
    sin,
    skew,
    sqrt,
    subtract,
    zeros,
)

AXES = "xyz"

_TINY = 1e-30
"""Added to a squared angle, rad^2: keeps quotients finite at zero and changes nothing else."""


@dataclass(frozen=True, eq=False)
class ScalarFrame:
    """`stiffkit.spatial.Frame` with scalars of a kernel as entries."""

    R: Matrix
    p: Vector

    def __matmul__(self, other: ScalarFrame) -> ScalarFrame:
        """Return ``T_A_C`` of ``T_A_B @ T_B_C``."""
        return ScalarFrame(matmul(self.R, other.R), plus(matmul(self.R, other.p), self.p))

    @property
    def inverse(self) -> ScalarFrame:
        """``T_B_A``."""
        return ScalarFrame(self.R.T, scale(-1.0, matmul(self.R.T, self.p)))


def read_frame(constants: Constants, c: Vector, name: str) -> ScalarFrame:
    """Return a constant frame that `add_frame` stored."""
    return ScalarFrame(constants.read(c, f"{name}.rotation"), constants.read(c, f"{name}.position"))


def axis_rotation(axis: str, angle: Scalar) -> Matrix:
    """Return the rotation matrix about an axis "x", "y" or "z"."""
    i = AXES.index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    c, s = cos(angle), sin(angle)
    R = identity(3)
    R[j, j] = R[k, k] = c
    R[k, j] = s
    R[j, k] = -s
    return R


@dataclass(frozen=True)
class _Rodrigues:
    """The coefficients of ``I + a [w] + b [w]^2`` for a rotation and for its rate."""

    W: Matrix
    W2: Matrix
    sinc: Scalar
    versine: Scalar
    """(1 - cos)/angle^2."""
    rest: Scalar
    """(1 - sinc)/angle^2."""

    @staticmethod
    def of(w: Vector) -> _Rodrigues:
        squared = add(add(multiply(w[0], w[0]), multiply(w[1], w[1])), multiply(w[2], w[2]))
        squared = squared + _TINY
        angle = sqrt(squared)
        sinc = sin(angle) / angle
        half = sin(0.5 * angle) / angle
        W = skew(w)
        return _Rodrigues(W, matmul(W, W), sinc, 2.0 * half * half, (1.0 - sinc) / squared)


def exp_rotation(w: Vector) -> Matrix:
    """Return the rotation matrix of a rotation vector (Rodrigues' formula)."""
    r = _Rodrigues.of(w)
    return plus(identity(3), plus(scale(r.sinc, r.W), scale(r.versine, r.W2)))


def exp_rotation_rate(w: Vector) -> Matrix:
    """Return the 3x3 matrix that maps the rate of a rotation vector to the angular velocity.

    It is the left Jacobian of SO(3), in the axes in which ``exp_rotation(w)`` is applied.
    """
    r = _Rodrigues.of(w)
    return plus(identity(3), plus(scale(r.versine, r.W), scale(r.rest, r.W2)))


def joint_motion(joint: Joint, q: Vector) -> ScalarFrame:
    """Return the ``to`` side's joint frame in the ``from`` side's, at the joint's coordinates."""
    p = zeros(3)
    R = identity(3)
    if joint.kind == "spherical":
        return ScalarFrame(exp_rotation(q), p)
    for motion, value in zip(joint.motions, q, strict=True):
        if motion.startswith("r"):
            R = matmul(R, axis_rotation(motion[1], value))
        else:
            p[AXES.index(motion)] = value
    return ScalarFrame(R, p)


def rotation_error(R_actual: Matrix, R_wanted: Matrix) -> Vector:
    """Return the small rotation vector, world axes, that turns ``R_wanted`` into ``R_actual``."""
    error = zeros(3)
    for i in range(3):
        a, b = R_wanted[:, i], R_actual[:, i]
        for n, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
            term = subtract(multiply(a[j], b[k]), multiply(a[k], b[j]))
            error[n] = add(error[n], multiply(0.5, term))
    return error
