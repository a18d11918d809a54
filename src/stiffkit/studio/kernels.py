"""Machine code that serves all variants of a robot."""

from __future__ import annotations

import numpy as np

from stiffkit.compiled import Backend
from stiffkit.study.sweep.family import Family, Geometry
from stiffkit.study.sweep.group import Group, Groups


class SharedKernels(Groups):
    """Groups of which one serves all geometries, special values of parameters included.

    A parameter that is zero, or a right angle, leaves zeros and ones in the constants that are
    there by its value and not by the topology. Code made for a geometry without such chances is
    right for all: a slider never waits for a compiler.
    """

    def __init__(self, family: Family, backend: Backend, ordinary: Geometry) -> None:
        """Take an ``ordinary`` geometry, all of whose parameters have been moved a little."""
        super().__init__(family, backend)
        self._ordinary = ordinary
        self._compiled_in = ordinary.elasticity.compiled_in
        self._fixed = ordinary.constants[self._compiled_in]

    def of(self, geometry: Geometry) -> Group:
        """Return the group that a geometry belongs to."""
        fits = np.array_equal(geometry.constants[self._compiled_in], self._fixed)
        return super().of(self._ordinary if fits else geometry)
