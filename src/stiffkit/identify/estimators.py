"""The rigid motion that fits a displacement field best: LIN, SVD with three angle rules, and exact.

A. Pashkevich, A. Klimchik, D. Chablat, P. Wenger, "Accuracy improvement for stiffness modeling of
parallel manipulators", 2009, section 3, with two misprints corrected: the sign of equation 12 (a
node at p moves by t + phi x p), and equation 17, whose t belongs to the field's centre and is
shifted to the reference point here.

Which one to take: a linear finite-element program moves nodes by exactly t + phi x p, however large
phi is, and LIN reads that back. Measured fields, and those of geometrically nonlinear programs,
turn; for them ``exact`` has no linearisation error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.errors import FieldError
from stiffkit.identify.field import Field
from stiffkit.identify.moments import (
    Moments,
    axial,
    gyration,
    moments,
    skew_matrices,
    small_rotations,
)
from stiffkit.spatial import exp_rotation, log_rotation, skew
from stiffkit.spatial.rotation import Array

Estimator = Literal["LIN", "SVD+", "SVD-", "SVD+-", "exact"]

REFINEMENTS = 2
"""Newton steps from the SVD's rotation: the first makes its absolute accuracy a relative one."""


@dataclass(frozen=True, eq=False)
class RigidFit:
    """The rigid motion of each of m load cases: nodes move by mean + gradient (p - centre)."""

    estimator: Estimator
    reference: Array
    """(3,), m, the point that `translation` is of."""
    translation: Array
    """(m, 3), m, of the reference point."""
    rotation: Array
    """(m, 3), rad; by `exact` a rotation vector."""
    centre: Array
    """(3,), m, the weighted mean of the points."""
    mean: Array
    """(m, 3), m, displacement of the centre."""
    gradient: Array
    """(m, 3, 3): the cross product with the rotation by LIN, R - I by the others."""

    @property
    def deflections(self) -> Array:
        """(m, 6), translation at the reference point, then rotation."""
        return np.hstack([self.translation, self.rotation])

    def case(self, index: int) -> RigidFit:
        """Return the motion of one load case."""
        at = slice(index, index + 1)
        return replace(
            self,
            translation=self.translation[at],
            rotation=self.rotation[at],
            mean=self.mean[at],
            gradient=self.gradient[at],
        )


def fit(field: Field, reference: ArrayLike, estimator: Estimator = "LIN") -> RigidFit:
    """Fit rigid motions to a field by weighted least squares; ``reference`` is (3,) in m.

    LIN is equations 12 to 17. SVD is equations 6 to 10, with the rotation's sign set so that it is
    never a reflection, which a plane field would allow; the angles are read by Table 1. As the
    paper says, the SVD's rotation is good to the rounding of 1, about 1e-16 rad, whatever its size.
    ``exact`` minimises equation 5 to the rounding of the displacements. Raises `FieldError` for an
    estimator or a reference that is none.
    """
    point = reference_point(reference)
    sums = moments(field)
    if estimator == "LIN":
        rotation = small_rotations(sums.second, sums.cross)
        gradient = skew_matrices(rotation)
    elif estimator == "exact":
        start = [log_rotation(R) for R in nearest_rotations(sums)]
        cases = zip(start, sums.cross, strict=True)
        rotation = np.stack([_refined(phi, sums.second, cross) for phi, cross in cases])
        gradient = np.stack([rotation_minus_identity(w) for w in rotation])
    elif estimator in get_args(Estimator):
        R = nearest_rotations(sums)
        rotation = _angles(R, estimator)
        gradient = R - np.eye(3)
    else:
        raise FieldError(
            f"there is no estimator {estimator!r}", mend=f"take {', '.join(get_args(Estimator))}"
        )
    translation = sums.mean + gradient @ (point - sums.centre)
    return RigidFit(estimator, point, translation, rotation, sums.centre, sums.mean, gradient)


def reference_point(reference: ArrayLike) -> Array:
    """Return a reference point as (3,) in m; raises `FieldError` if it is not three numbers."""
    point = np.asarray(reference, dtype=float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise FieldError(f"the reference point must be three finite numbers and is {reference!r}")
    return point


def nearest_rotations(sums: Moments) -> Array:
    """Return the rotations (m, 3, 3) of equations 8 to 10: R = V diag(1, 1, +-1) U^T."""
    U, _, Vt = np.linalg.svd(sums.second + sums.cross)
    V, Ut = Vt.mT.copy(), U.mT
    V[:, :, 2] *= np.sign(np.linalg.det(V @ Ut))[:, None]
    return np.asarray(V @ Ut)


def rotation_minus_identity(rotation_vector: Array) -> Array:
    """Return R - I (3, 3) of a rotation vector (3,), to relative rounding however small it is."""
    angle = float(np.linalg.norm(rotation_vector))
    W = skew(rotation_vector)
    return np.asarray(
        np.sinc(angle / np.pi) * W + 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2 * (W @ W)
    )


def _angles(R: Array, estimator: Estimator) -> Array:
    """Read the angles (m, 3) from rotations (m, 3, 3) by the paper's Table 1."""
    plus = np.stack([R[:, 2, 1], R[:, 0, 2], R[:, 1, 0]], axis=1)
    minus = -np.stack([R[:, 1, 2], R[:, 2, 0], R[:, 0, 1]], axis=1)
    if estimator == "SVD+":
        return plus
    return minus if estimator == "SVD-" else (plus + minus) / 2.0


def _refined(rotation: Array, second: Array, cross: Array) -> Array:
    """Return the rotation vector (3,) that fits the moments of one load case, from one near it.

    With R = I + E the torque on the residuals is that of Y = R (second + cross); ``second`` alone
    is symmetric and has none, so it is left out, and what remains is as small as the rotation.
    """
    for _ in range(REFINEMENTS):
        E = rotation_minus_identity(rotation)
        Y = cross + E @ (second + cross)
        step = np.linalg.solve(gyration(second + (Y + Y.T) / 2.0), axial(Y))
        rotation = log_rotation(exp_rotation(step) @ exp_rotation(rotation))
    return rotation
