"""Loads that suit an identification: Pashkevich 2009, section 3.5.

A small load drowns in the noise of the field, a large one turns the body so far that rotations are
no longer small. Between them there is a best amplitude, and a range for a wanted accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.errors import FieldError
from stiffkit.identify.closed_forms import cubic_normal
from stiffkit.identify.field import Field
from stiffkit.identify.statistics import precision
from stiffkit.link.checks import LOADS
from stiffkit.spatial.rotation import Array

ACCURACY = 2e-3
"""The paper's 0.2 %."""
TURNS = 1e-3
"""A load turns the body if the rotation moves the field's nodes by this share of its shift."""


@dataclass(frozen=True)
class DeflectionNoise:
    """Standard deviations of an estimated deflection, of its worst component."""

    translation: float
    """m."""
    rotation: float
    """rad."""
    radius: float
    """m, root-mean-square distance of the nodes from their centre."""

    @staticmethod
    def of_cube(size: float, count: int, sigma: float) -> DeflectionNoise:
        """Return that of a regular cube of edge ``size`` with ``count`` nodes, lengths in m.

        Equation 20 at the cube's centre; the paper rounds the second to sigma / (a sqrt(n/6)).
        """
        normal = cubic_normal(size, count)
        radius = float(np.sqrt(1.5 * normal / count))
        return DeflectionNoise(sigma / np.sqrt(count), sigma / np.sqrt(normal), radius)

    @staticmethod
    def of_field(field: Field, reference: Array, sigma: float) -> DeflectionNoise:
        """Return that of a field at ``reference`` (3,) in m, with noise of ``sigma`` in m."""
        error = sigma * np.sqrt(np.diag(precision(field, reference).unit_covariance))
        return DeflectionNoise(float(error[:3].max()), float(error[3:].max()), field.spread.radius)


@dataclass(frozen=True)
class LoadAdvice:
    """How large one of the six pure loads should be."""

    load: str
    """Fx to Mz."""
    lowest: float
    """N or N m: below it noise exceeds the accuracy."""
    best: float
    """N or N m: noise and linearisation balance; as accurate as the others if only translating."""
    highest: float
    """N or N m: above it linearisation exceeds the accuracy; inf if the load only translates."""
    translation: float
    """m, size of the reference point's translation under the best load."""
    rotation: float
    """rad, size of its rotation under the best load."""
    reasoning: tuple[str, ...]


def advise(
    compliance: ArrayLike, noise: DeflectionNoise, accuracy: float = ACCURACY
) -> tuple[LoadAdvice, ...]:
    """Return advice for the six pure loads, from an expected compliance (6, 6) in SI.

    A rotation b is read with the relative error sqrt((s/b)^2 + (b/2)^2): noise of standard
    deviation s, and the second-order term b^2/2 that a linear model leaves out (Table 3). It is
    least at b = sqrt(2 s), and below the ``accuracy`` about from s/accuracy to 2 accuracy.
    Translations have noise only. Raises `FieldError` for a compliance, noise or accuracy that
    gives no load.
    """
    k = np.asarray(compliance, dtype=float)
    if k.shape != (6, 6) or not np.isfinite(k).all():
        raise FieldError("the expected compliance must be a 6x6 matrix of finite numbers")
    if not (noise.translation > 0.0 and noise.rotation > 0.0 and 0.0 < accuracy < 1.0):
        raise FieldError(
            "the noise must be positive and the accuracy between 0 and 1",
            mend="give the standard deviation of the noise in m, such as 5e-8, and 0.002 for 0.2 %",
        )
    best = np.sqrt(2.0 * noise.rotation)
    if best / np.sqrt(2.0) > accuracy:
        raise FieldError(
            f"an accuracy of {accuracy:.2g} cannot be had: noise of {noise.rotation:.2g} rad in "
            f"the rotation allows {best / np.sqrt(2.0):.2g} at best",
            mend="take a larger field, more nodes, a finer mesh, or accept less",
        )
    return tuple(_advice(LOADS[i], k[:, i], noise, accuracy) for i in range(6))


def _advice(load: str, column: Array, noise: DeflectionNoise, accuracy: float) -> LoadAdvice:
    shift, turn = float(np.linalg.norm(column[:3])), float(np.linalg.norm(column[3:]))
    if shift == 0.0 and turn == 0.0:
        raise FieldError(
            f"under {load} the expected compliance gives no deflection, so that no load follows",
            mend="give the whole compliance, small elements too",
        )
    if turn * noise.radius <= TURNS * shift:
        return _advice_by_translation(load, shift, turn, noise, accuracy)
    return _advice_by_rotation(load, shift, turn, noise, accuracy)


def _advice_by_translation(
    load: str, shift: float, turn: float, noise: DeflectionNoise, accuracy: float
) -> LoadAdvice:
    """Advise on a load that hardly turns the body, by ``shift`` m and ``turn`` rad per unit."""
    unit = _unit(load)
    lowest = noise.translation / accuracy / shift
    best = noise.translation / np.sqrt(noise.rotation) / shift
    reasoning = (
        f"{load} translates by {shift:.3g} m/{unit} and hardly turns: linearisation sets no limit, "
        "the elastic range does",
        f"noise of {noise.translation:.3g} m is {accuracy:.2g} of the translation at "
        f"{lowest:.3g} {unit}",
        f"at {best:.3g} {unit} it is read as accurately as rotations at their best; more is better",
    )
    return LoadAdvice(load, lowest, best, np.inf, best * shift, best * turn, reasoning)


def _advice_by_rotation(
    load: str, shift: float, turn: float, noise: DeflectionNoise, accuracy: float
) -> LoadAdvice:
    """Advise on a load that turns the body, by ``shift`` m and ``turn`` rad per unit."""
    unit = _unit(load)
    # The two roots in b of (s/b)^2 + (b/2)^2 = accuracy^2 have the product 2 s.
    most = float(np.sqrt(2.0 * (accuracy**2 + np.sqrt(accuracy**4 - noise.rotation**2))))
    least = 2.0 * noise.rotation / most
    balanced = float(np.sqrt(2.0 * noise.rotation))
    lowest, best, highest = least / turn, balanced / turn, most / turn
    reasoning = [
        f"{load} turns by {turn:.3g} rad/{unit}: noise of {noise.rotation:.3g} rad and the "
        f"second-order term b^2/2 balance at b = {np.degrees(balanced):.3g} deg, {best:.3g} "
        f"{unit}, with an error of {balanced / np.sqrt(2.0):.2g} of the rotation",
        f"from {np.degrees(least):.3g} to {np.degrees(most):.3g} deg, {lowest:.3g} to "
        f"{highest:.3g} {unit}, the error stays below {accuracy:.2g}; a linear finite-element "
        "program turns without second order, and only the lower limit counts there",
    ]
    seen = noise.translation / accuracy / shift if load.startswith("F") else 0.0
    if seen > lowest:
        lowest, best = seen, max(best, seen)
        reasoning.append(
            f"its translation of {shift:.3g} m/{unit} stands out of the noise of "
            f"{noise.translation:.3g} m by that accuracy only from {seen:.3g} {unit}"
        )
    if lowest > highest:
        reasoning.append("no load serves both; take the best and expect the rotation less accurate")
    return LoadAdvice(load, lowest, best, highest, best * shift, best * turn, tuple(reasoning))


def _unit(load: str) -> str:
    return "N" if load.startswith("F") else "N m"
