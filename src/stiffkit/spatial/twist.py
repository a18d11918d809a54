"""Small displacements and loads: 6 numbers, translation (force) first, at a named point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array, skew

SMALL = 1e-6
"""A motion is pure when what disturbs it is this small, over the characteristic length."""

UNITS = {"m": (1.0, 5), "mm": (1e3, 2)}
"""Unit of length: how many make a metre, decimals to print."""


def twist_shift(vector: ArrayLike) -> Array:
    """Return X (6x6) so that ``twist_at_Q = X @ twist_at_P``, with ``vector`` (3,) = Q - P in m.

    The translation of Q is that of P and ``rotation x vector``. A wrench goes the other way:
    ``wrench_at_P = X.T @ wrench_at_Q``.
    """
    X = np.eye(6)
    X[:3, 3:] = -skew(vector)
    return X


def shift_compliance(k: ArrayLike, T_A_B: Frame) -> Array:
    """Return a compliance (6x6), given in B at B's origin, in the axes of A at A's origin."""
    X = _twist_transform(T_A_B)
    return np.asarray(X @ np.asarray(k, dtype=float) @ X.T)


def shift_stiffness(K: ArrayLike, T_A_B: Frame) -> Array:
    """Return a stiffness (6x6), given in B at B's origin, in the axes of A at A's origin."""
    X = _twist_transform(T_A_B.inverse)
    return np.asarray(X.T @ np.asarray(K, dtype=float) @ X)


def _twist_transform(T_A_B: Frame) -> Array:
    """Return X (6x6): twist in B at B's origin to twist of the same body in A at A's origin."""
    turn = np.kron(np.eye(2), T_A_B.rotation)
    return np.asarray(twist_shift(-T_A_B.position) @ turn)


@dataclass(frozen=True, eq=False)
class Screw:
    """A small motion as what it is: a translation, a turn about an axis, or both at once.

    The sense of the motion is dropped: `direction` has its first component that counts positive.
    """

    kind: str
    """translation, rotation or screw."""
    direction: Array
    """(3,), unit vector of the translation or of the axis."""
    point: Array
    """(3,), m: the point of the axis nearest to where the twist was given; that point itself for a
    translation."""
    pitch: float
    """m/rad, translation along the axis per turn about it; inf for a translation."""

    @staticmethod
    def of_twist(twist: ArrayLike, point: ArrayLike, length: float = 1.0) -> Screw:
        """Return the screw of a twist (6,) of any magnitude at a point (3,).

        The size of the mechanism, ``length`` in m, weighs rotation against translation: what moves
        points at that distance by a millionth of the whole motion counts as zero. Raises
        `ValueError` if the twist is zero.
        """
        t, phi = np.split(np.asarray(twist, dtype=float), 2)
        P = np.asarray(point, dtype=float)
        translation, rotation = float(np.linalg.norm(t)), float(np.linalg.norm(phi))
        if translation == 0.0 and rotation == 0.0:
            raise ValueError("a twist of zero has no direction")
        if rotation * length <= SMALL * translation:
            return Screw("translation", _senseless(t / translation), P, float("inf"))
        axis = phi / rotation
        pitch = float(axis @ t) / rotation
        nearest = P + np.cross(axis, t) / rotation
        if abs(pitch) <= SMALL * max(length, translation / rotation):
            return Screw("rotation", _senseless(axis), nearest, 0.0)
        return Screw("screw", _senseless(axis), nearest, pitch)

    def describe(self, unit: str = "mm") -> str:
        """Return the motion in words, with lengths in "mm" or "m"."""
        direction = _direction_words(self.direction)
        if self.kind == "translation":
            return f"translates along {direction}"
        factor, decimals = UNITS[unit]
        through = ", ".join(_plain(factor * x, decimals) for x in self.point)
        axis = f"about an axis along {direction} through ({through}) {unit}"
        if self.kind == "rotation":
            return f"turns {axis}"
        return f"screws {axis}, with {_plain(factor * self.pitch, decimals)} {unit}/rad"


def _senseless(direction: Array) -> Array:
    """Return a unit vector (3,) with its first component that counts made positive."""
    first = direction[np.flatnonzero(np.abs(direction) > SMALL)[0]]
    return -direction if first < 0.0 else direction


def _direction_words(direction: Array) -> str:
    rounded = np.round(direction, 3) + 0.0
    for name, axis in zip("xyz", np.eye(3), strict=True):
        if np.array_equal(np.abs(rounded), axis):
            return name
    return "({:.3f}, {:.3f}, {:.3f})".format(*rounded)


def _plain(value: float, decimals: int) -> str:
    return f"{round(value, decimals) + 0.0:.10g}"
