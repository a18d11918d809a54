"""Rotation matrices and rotation vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def skew(vector: ArrayLike) -> Array:
    """Return the 3x3 matrix of the cross product ``vector x``."""
    x, y, z = np.asarray(vector, dtype=float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def exp_rotation(rotation_vector: ArrayLike) -> Array:
    """Return the rotation matrix (3x3) of a rotation vector (3,) in rad (Rodrigues' formula)."""
    w = np.asarray(rotation_vector, dtype=float)
    angle = float(np.linalg.norm(w))
    W = skew(w)
    sinc = np.sinc(angle / np.pi)
    half_sinc = np.sinc(angle / (2 * np.pi))
    return np.asarray(np.eye(3) + sinc * W + 0.5 * half_sinc**2 * (W @ W))


def log_rotation(R: ArrayLike) -> Array:
    """Return the rotation vector (3,), angle in [0, pi], of a rotation matrix (3x3)."""
    R = np.asarray(R, dtype=float)
    axis_sin = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.linalg.norm(axis_sin))
    cosine = 0.5 * (float(np.trace(R)) - 1.0)
    angle = float(np.arctan2(sine, cosine))
    if cosine > 0.0:
        # arctan2(sine, cosine)/sine tends to 1 at the identity.
        return axis_sin * (angle / sine if sine > 0.0 else 1.0)
    # Towards half a turn the antisymmetric part vanishes and the symmetric part holds the axis.
    outer = (R + R.T) / 2.0 - cosine * np.eye(3)
    column = outer[:, int(np.argmax(np.diag(outer)))]
    axis = column / np.linalg.norm(column)
    return np.asarray(axis * angle * (-1.0 if axis @ axis_sin < 0.0 else 1.0))


def axis_rotation(axis: str, angle: float) -> Array:
    """Return the rotation matrix (3x3) about one of the axes "x", "y", "z" by an angle in rad."""
    return exp_rotation(angle * np.eye(3)["xyz".index(axis)])
