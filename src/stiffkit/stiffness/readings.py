"""What engineers read off a compliance, as a posture kernel: deflections, extreme stiffnesses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Constants, Kernel
from stiffkit.smallmat import (
    Scalar,
    Vector,
    add,
    dot,
    from_lower_triangle,
    magnitude,
    matmul,
    multiply,
    sqrt,
    vector,
)
from stiffkit.stiffness.indices import extreme_stiffnesses

Array = NDArray[np.float64]

STIFFNESSES = (
    "stiffness_translation_min",
    "stiffness_translation_max",
    "stiffness_rotation_min",
    "stiffness_rotation_max",
)
"""The first outputs of the kernel, N/m and N m/rad; see `stiffkit.stiffness.indices`."""

DEFLECTIONS = (
    "deflection_translation",
    "deflection_xy",
    "deflection_z",
    "deflection_rotation",
)
"""For each load, after the six numbers of its deflection: sizes of its parts, m and rad."""


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
        outputs = [*extreme_stiffnesses(lower, 0), *extreme_stiffnesses(lower, 3)]
        for wrench in constants.read(c, "wrenches"):
            d = matmul(k, wrench)
            outputs += [*d, *_sizes(d)]
        return vector(outputs)

    return Kernel("readings", read, 21, constants, (len(wrenches),))


def _sizes(d: Vector) -> list[Scalar]:
    in_plane = dot(d[:2], d[:2])
    in_space = add(in_plane, multiply(d[2], d[2]))
    return [sqrt(in_space), sqrt(in_plane), magnitude(d[2]), sqrt(dot(d[3:], d[3:]))]
