"""What looks like a wrong unit beside the size of the body."""

from __future__ import annotations

import numpy as np

from stiffkit.spatial.rotation import Array

LONGEST, SHORTEST = 50.0, 1e-4
"""m; bodies outside of these are doubted."""
FAR = 30.0
"""Sizes of the body from its nodes to the reference point that are doubted."""
LARGE_DISPLACEMENT = 0.1
"""Displacement over the size of the body that no link reaches in its elastic range."""
STIFFEST_MODULUS = 1.2e12
"""Pa, Young's modulus of diamond."""
STIFFER = 0.1
"""A compliance below this share of a diamond block's is doubted, as the base may be near."""


def size_doubts(
    points: Array, displacements: Array, compliance: Array, reference: Array
) -> list[str]:
    """Return what looks like a wrong unit beside the size of the body, in words.

    ``points`` (n, 3) in m are all nodes that are known, ``displacements`` (m, n, 3) in m those of
    some of them; ``compliance`` (6, 6) in SI at ``reference`` (3,) in m; all in link axes, whose
    origin is the link's base.
    """
    extents = np.ptp(points, axis=0)
    size = float(np.linalg.norm(extents))
    if not SHORTEST <= size <= LONGEST:
        return [f"the nodes span {size:.3g} m: is the unit of coordinates right?"]
    return [
        *_reference_doubts(points, size, reference),
        *_displacement_doubts(displacements, max(size, float(np.linalg.norm(reference)))),
        *_block_doubts(extents, compliance),
    ]


def _reference_doubts(points: Array, size: float, reference: Array) -> list[str]:
    away = float(np.linalg.norm(reference - (points.min(axis=0) + points.max(axis=0)) / 2.0))
    if away <= FAR * size:
        return []
    return [
        f"the reference point is {away:.3g} m away from nodes that span {size:.3g} m: is its unit "
        "that of the coordinates?"
    ]


def _displacement_doubts(displacements: Array, size: float) -> list[str]:
    largest = float(np.abs(displacements).max())
    if largest <= LARGE_DISPLACEMENT * size:
        return []
    return [
        f"nodes move by up to {1e3 * largest:.3g} mm on a body of {1e3 * size:.3g} mm, far beyond "
        "an elastic range: the displacements may be in another unit, such as mm read as m"
    ]


def _block_doubts(extents: Array, compliance: Array) -> list[str]:
    """Compare with the block that fills the box around the nodes, pulled along one of its edges."""
    if extents.min() <= 0.0:
        return []
    block = extents**2 / (STIFFEST_MODULUS * extents.prod())
    ratios = np.diag(compliance)[:3] / block
    i = int(ratios.argmin())
    if not 0.0 < ratios[i] < STIFFER:
        return []
    return [
        f"along {'xyz'[i]} the body is {1.0 / ratios[i]:.3g} times stiffer than a solid block of "
        "diamond of its size: the displacements may be in another unit, such as m read as mm, or "
        "the loads too large"
    ]
