"""What engineers read off a compliance, as a posture kernel: deflections, extreme stiffnesses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Constants, Kernel
from stiffkit.smallmat import (
    Scalar,
    Vector,
    dot,
    from_lower_triangle,
    magnitude,
    matmul,
    sqrt,
    vector,
)
from stiffkit.stiffness.indices import extreme_stiffnesses

Array = NDArray[np.float64]

Reading = Callable[[Vector], Scalar]
"""Scalars of a posture to one of them."""

STIFFNESSES: Mapping[str, Reading] = MappingProxyType(
    {
        "stiffness_translation_min": lambda lower: extreme_stiffnesses(lower, 0)[0],
        "stiffness_translation_max": lambda lower: extreme_stiffnesses(lower, 0)[1],
        "stiffness_rotation_min": lambda lower: extreme_stiffnesses(lower, 3)[0],
        "stiffness_rotation_max": lambda lower: extreme_stiffnesses(lower, 3)[1],
    }
)
"""How to read each off the lower triangle of a compliance (21, SI), N/m and N m/rad."""

DEFLECTIONS: Mapping[str, Reading] = MappingProxyType(
    {
        "deflection_translation": lambda d: sqrt(dot(d[:3], d[:3])),
        "deflection_xy": lambda d: sqrt(dot(d[:2], d[:2])),
        "deflection_z": lambda d: magnitude(d[2]),
        "deflection_rotation": lambda d: sqrt(dot(d[3:], d[3:])),
    }
)
"""How to read each off a deflection (6, m and rad): sizes of its parts, m and rad."""


def readings(wrenches: Array) -> Kernel:
    """Return the kernel for load cases, each a wrench at the tool point: (n_loads, 6), N and N m.

    Inputs: the lower triangle of the compliance (21, SI, at the tool point). Outputs: the numbers
    of `STIFFNESSES`; then, for each load, its deflection (6, m and rad) and the numbers of
    `DEFLECTIONS`.
    """
    wrenches = np.asarray(wrenches, dtype=float).reshape(-1, 6)
    constants = Constants()
    constants.add("wrenches", wrenches)

    def read(lower: Vector, c: Vector) -> Vector:
        k = from_lower_triangle(lower)
        outputs = [stiffness(lower) for stiffness in STIFFNESSES.values()]
        for wrench in constants.read(c, "wrenches"):
            d = matmul(k, wrench)
            outputs += [*d, *(size(d) for size in DEFLECTIONS.values())]
        return vector(outputs)

    return Kernel("readings", read, 21, constants, (len(wrenches),))
