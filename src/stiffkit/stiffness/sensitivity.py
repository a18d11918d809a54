"""How the compliance of postures follows pose, dimensions and elasticities."""

from __future__ import annotations

import numpy as np

from stiffkit.compiled import AdjointFunction, Backend, Kernel
from stiffkit.compiled.kernel import Array
from stiffkit.kinematics.closure import ClosureEquations
from stiffkit.kinematics.sensitivity import ClosureSensitivity, Following

_LOWER = 21


class ComplianceSensitivity:
    """Derivatives of functions of the tool's compliance by everything that it depends on.

    The posture follows the dimensions, with the tool pose held.
    """

    def __init__(self, kernel: Kernel, closure: ClosureEquations, backend: Backend) -> None:
        """Take a kernel whose first 21 outputs are the compliance, and the closure of its robot.

        The constants of the closure are the first ones of the kernel's.
        """
        self.closure = closure
        self._compliance = AdjointFunction(kernel, _LOWER, backend)
        self._closing = ClosureSensitivity(closure, backend)

    def of(self, unknowns: Array, asked: Array, seeds: Array, constants: Array) -> Following:
        """Return derivatives at postures with unknowns (n, N) at tool coordinates asked (k, N).

        ``seeds`` (21, N) are the derivatives of the functions by the entries of the lower triangle
        of the compliance, ``constants`` (m,) the kernel's; SI.
        """
        n = self.closure.tree.n_coordinates
        direct = self._compliance(unknowns[:n], seeds, constants)
        gradient = np.zeros_like(unknowns)
        gradient[:n] = direct.inputs
        geometric = self.closure.constants.values.size
        moved = self._closing.of(unknowns, asked, gradient, constants[:geometric])
        by_constants = direct.constants
        by_constants[:geometric] += moved.constants
        return Following(moved.asked, by_constants)
