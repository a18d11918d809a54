"""How postures follow the mechanism's dimensions: the implicit function theorem, backwards.

With the equations F(u, x, c) = 0 of unknowns u, tool coordinates asked for x and constants c, a
function g of u changes by -mu (F_x dx + F_c dc), where mu = (F_u^+)^T g_u: one solution for each
posture, however many constants there are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffkit.compiled import AdjointFunction, Backend, GeometriesFunction
from stiffkit.compiled.kernel import Array
from stiffkit.kinematics.closure import ClosureEquations


@dataclass(frozen=True, eq=False)
class Following:
    """Derivatives of functions of N postures that follow pose and dimensions."""

    asked: Array
    """(k, N), by the tool coordinates asked for, SI."""
    constants: Array
    """(m, N), by the constants of the closure."""


class ClosureSensitivity:
    """Carries derivatives by a posture's unknowns over to what the posture follows from."""

    def __init__(self, closure: ClosureEquations, backend: Backend) -> None:
        """Take the equations with the tool coordinates that fix a posture."""
        self.closure = closure
        self._multipliers = GeometriesFunction(closure.multipliers(), backend)
        residuals = closure.residuals()
        self._residuals = AdjointFunction(residuals, closure.n_equations, backend)

    def of(self, unknowns: Array, asked: Array, gradient: Array, constants: Array) -> Following:
        """Return the derivatives of functions with a ``gradient`` (n, N) by the unknowns (n, N).

        ``asked`` are the tool coordinates (k, N), ``constants`` (m,) those of the closure; SI.
        Where branches meet there are none, and what is returned is large or not finite.
        """
        n, N = unknowns.shape
        inputs = np.concatenate([unknowns, asked])
        evaluate = self._multipliers.at(constants[:, None], np.zeros(N, dtype=np.intp))
        multipliers = evaluate(np.concatenate([inputs, gradient]))
        found = self._residuals(inputs, -multipliers, constants)
        return Following(found.inputs[n:], found.constants)
