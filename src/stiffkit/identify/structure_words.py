"""The shape of residuals in words."""

from __future__ import annotations

import numpy as np

from stiffkit.identify.spread import direction_words
from stiffkit.spatial.rotation import Array

WORTH_A_WORD = 0.05
"""Share of the sum of squares from which a part is named."""
ALIKE = 0.2
"""Values are alike if they differ by this share of the larger."""
LARGEST_POISSON = 0.6
"""Largest ratio of strains, with tolerance, that is taken for a Poisson's ratio."""


def shape_words(
    linear: float,
    quadratic: float,
    normal: float,
    smooth: bool,
    strains: Array,
    directions: Array,
    estimator: str,
    angle: float,
) -> str:
    """Return what structured residuals look like.

    ``linear`` and ``quadratic`` are the shares of strain and its variation in the sum of squares,
    ``normal`` the share of the latter along the shortest axis, ``smooth`` whether neighbours agree
    in the rest, ``strains`` (d,) and ``directions`` (3, d) the principal strains, ``estimator`` and
    ``angle`` (rad) those of the rigid motion.
    """
    parts = []
    if linear >= WORTH_A_WORD:
        parts.append(
            f"{linear:.0%} is {_strain_words(strains, directions)}"
            f"{_linearisation_words(strains, estimator, angle)}"
        )
    if quadratic >= WORTH_A_WORD:
        parts.append(f"{quadratic:.0%} is {_quadratic_words(normal, len(strains))}")
    rest = max(1.0 - linear - quadratic, 0.0)
    if smooth and rest >= WORTH_A_WORD:
        parts.append(
            f"{rest:.0%} is of higher order but alike in neighbouring nodes, such as the warping "
            "of a section under torsion, or a local dent"
        )
    if not parts:
        parts.append(
            f"polynomials of position explain no more than {linear + quadratic:.1%}, but that "
            "is more than chance"
        )
    return "of the sum of squared residuals, " + "; ".join(parts)


def _strain_words(strains: Array, directions: Array) -> str:
    first, others = strains[0], strains[1:]
    along = [direction_words(direction) for direction in directions.T]
    same = np.ptp(strains) <= ALIKE * abs(first)
    if len(strains) == 2 and same:
        sense = "grows" if first > 0.0 else "shrinks"
        return (
            f"a face that {sense} evenly in its plane, by a strain of {strains.mean():.3g}: the "
            "Poisson contraction of a face that is loaded along its normal"
        )
    if len(strains) == 3 and same:
        sense = "growth" if first > 0.0 else "shrinking"
        return f"an even {sense} in all directions, by a strain of {strains.mean():.3g}"
    ratio = -float(others.mean() / first)
    across_alike = np.ptp(others) <= ALIKE * np.abs(others).max()
    if len(strains) == 3 and across_alike and 0.0 < ratio <= LARGEST_POISSON:
        return (
            f"a uniform strain of {first:.3g} along {along[0]}, with the {ratio:.2g}-fold of the "
            "other sign across: tension or compression with this Poisson's ratio"
        )
    values = ", ".join(f"{e:.3g} along {d}" for e, d in zip(strains, along, strict=True))
    return f"a uniform strain of {values}"


def _linearisation_words(strains: Array, estimator: str, angle: float) -> str:
    """Say so if the strain is what the wrong estimator makes of a rotation by ``angle`` rad."""
    largest = float(np.abs(strains).max())
    if abs(largest - angle**2 / 2.0) > ALIKE * largest:
        return ""
    other = "exact" if estimator == "LIN" else "LIN"
    return (
        f" (as large as what a rotation of {np.degrees(angle):.3g} deg leaves when the estimator "
        f"does not suit the field: try {other})"
    )


def _quadratic_words(normal: float, dimension: int) -> str:
    if dimension == 3:
        return "a strain that varies across the field, as in bending"
    if normal > 0.5:
        return "warping: the face leaves its plane like a bowl or a saddle"
    return "a strain that varies across the face, as in the anticlastic bending of a section"
