"""What looks like a wrong unit in an identified compliance: possible, but hardly meant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stiffkit.link.checks import doubts_compliance, symmetrize
from stiffkit.spatial.rotation import Array

Mask = NDArray[np.bool_]

LARGE_ROTATION = 0.2
"""rad; a link in its elastic range hardly turns more."""
SAME_PATTERN = 0.9
"""Correlation above which the two coupling blocks differ by a factor only."""
NEAR = 0.15
"""Decades by which a factor may miss a power of 1000."""


def doubts(
    compliance: Array, deflections: Array, case_names: Sequence[str], significant: Mask
) -> list[str]:
    """Return what looks like a wrong unit, in words.

    ``compliance`` (6, 6) is taken as SI, with a mask (6, 6) of elements that are not just noise;
    ``deflections`` (m, 6) are in m and rad, of m named load cases.
    """
    found = _rotation_doubts(deflections, case_names) + _coupling_doubts(compliance, significant)
    if np.diag(compliance).min() > 0.0:
        found += doubts_compliance(symmetrize(compliance))
    return found


def _rotation_doubts(deflections: Array, case_names: Sequence[str]) -> list[str]:
    angles = np.linalg.norm(deflections[:, 3:], axis=1)
    j = int(angles.argmax())
    if angles[j] <= LARGE_ROTATION:
        return []
    return [
        f"load case {case_names[j]} turns the reference point by {np.degrees(angles[j]):.3g} deg, "
        "which no link does in its elastic range; if the displacements are in mm and were read as "
        "m, or the coordinates in m and were read as mm, rotations come out 1000 times too large"
    ]


def _coupling_doubts(compliance: Array, significant: Mask) -> list[str]:
    """Compare translations by moments with rotations by forces, which are the same numbers.

    A compliance is symmetric (Maxwell and Betti). The two blocks scale differently when the unit of
    coordinates or of moments is wrong, and equally in all other cases.
    """
    by_moment = np.where(significant, compliance, 0.0)[:3, 3:]
    by_force = np.where(significant, compliance, 0.0)[3:, :3].T
    sizes = float(np.linalg.norm(by_moment)), float(np.linalg.norm(by_force))
    if min(sizes) == 0.0:
        return []
    if float((by_moment * by_force).sum()) < SAME_PATTERN * sizes[0] * sizes[1]:
        return []
    decades = float(np.log10(sizes[0] / sizes[1]))
    power = 3 * round(decades / 3.0)
    if power == 0 or abs(decades - power) > NEAR:
        return []
    factor = f"{10.0 ** abs(power):,.0f}"
    compared = "rotations under forces (rad/N) should equal translations under moments (m/(N m))"
    if power > 0:
        return [
            f"{compared} and are {factor} times smaller: the coordinates are probably in mm and "
            "were read as m, or the moments too small by that factor"
        ]
    return [
        f"{compared} and are {factor} times larger: the moments are probably in N mm and were "
        "read as N m, or the coordinates in m and were read as mm"
    ]
