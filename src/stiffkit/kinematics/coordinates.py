"""Joint coordinates and tool coordinates read off frames, for batches of postures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.robot import Joint

Array = NDArray[np.float64]


def rotation_vectors(R: Array) -> Array:
    """Return the rotation vectors (3, N), angle in [0, pi], of rotation matrices (3, 3, N)."""
    axis_sin = 0.5 * np.stack([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = np.sqrt(np.sum(axis_sin**2, axis=0))
    cosine = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    small = sine < 1e-8
    w = axis_sin * np.where(small, 1.0, angle / np.where(small, 1.0, sine))
    far = cosine < -0.9
    if np.any(far):
        # Near half a turn the antisymmetric part is small and the symmetric part holds the axis.
        w[:, far] = _rotation_vectors_near_half_turn(R[..., far], axis_sin[:, far], angle[far])
    return np.asarray(w)


def _rotation_vectors_near_half_turn(R: Array, axis_sin: Array, angle: Array) -> Array:
    cosine = np.cos(angle)
    outer = 0.5 * (R + R.transpose(1, 0, 2)) - cosine * np.eye(3)[..., None]
    largest = np.argmax(np.einsum("iin->in", outer), axis=0)
    axis = outer[:, largest, np.arange(len(largest))]
    axis = axis / np.sqrt(np.sum(axis**2, axis=0))
    sign = np.where(np.sum(axis * axis_sin, axis=0) < 0.0, -1.0, 1.0)
    return np.asarray(sign * angle * axis)


def joint_coordinates(joint: Joint, R: Array, p: Array) -> Array:
    """Return the coordinates (n_motions, N) of a joint.

    R (3, 3, N) and p (3, N, m) are the frame of the ``to`` side in that of the ``from`` side.
    """
    if joint.kind == "spherical":
        return rotation_vectors(R)
    rotations = [m for m in joint.motions if m.startswith("r")]
    if len(rotations) == 2:
        return np.stack(_universal_angles(R, *("xyz".index(m[1]) for m in rotations)))
    values = []
    for motion in joint.motions:
        if motion.startswith("r"):
            i = "xyz".index(motion[1])
            j, k = (i + 1) % 3, (i + 2) % 3
            values.append(np.arctan2(R[k, j] - R[j, k], R[j, j] + R[k, k]))
        else:
            values.append(p["xyz".index(motion)])
    return np.stack(values) if values else np.empty((0, R.shape[-1]))


def _universal_angles(R: Array, a: int, b: int) -> tuple[Array, Array]:
    """Return alpha, beta of ``R = R_a(alpha) R_b(beta)``."""
    c = 3 - a - b
    sign = 1.0 if (a + 1) % 3 == b else -1.0  # of e_a x e_b along e_c
    alpha = np.arctan2(sign * R[c, b], R[b, b])
    beta = np.arctan2(sign * R[a, c], R[a, a])
    return alpha, beta
