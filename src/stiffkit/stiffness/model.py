"""Postures to compliances, by the fastest method that is exact for the robot: the main door."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction, Kernel
from stiffkit.kinematics import Kinematics, Postures, Status
from stiffkit.network import Model
from stiffkit.robot import DIRECTIONS, Freedom
from stiffkit.smallmat import ZERO_SHARE
from stiffkit.stiffness.assembly import AssembledCompliance, Assembly
from stiffkit.stiffness.composition import Composition
from stiffkit.stiffness.indices import full_matrices, lower_triangles
from stiffkit.stiffness.simplified import SimplifiedModel

Array = NDArray[np.float64]

Method = Literal["composition", "jacobian", "assembly"]

_AGREEMENT = 1e-6
"""Largest difference between fast path and assembly, over the largest entry, both unit-free."""


@dataclass(frozen=True, eq=False)
class Compliances:
    """The tool's compliance at N postures; SI, world axes, at the tool point."""

    lower: Array
    """(21, N), lower triangles row by row; NaN where the status is not OK."""
    status: NDArray[np.int8]
    """(N,), values of `stiffkit.kinematics.Status`."""


class Stiffness:
    """The stiffness of a robot by one model.

    "refined" takes all elastic links, joints and drives into account, "simplified" the drives only
    (Briot et al. 2009, sections 2.2 and 2.1).
    """

    def __init__(
        self, kinematics: Kinematics, model: Model = "refined", *, backend: Backend | None = None
    ) -> None:
        """Choose the method: composition or Jacobian where they apply, else the assembly."""
        self.kinematics = kinematics
        self.model: Model = model
        self.assembly = Assembly(kinematics.tree, kinematics.length, model, backend=backend)
        self.method: Method = "assembly"
        self._function: BatchFunction | None = None
        fast = self._fast_kernel()
        if fast is not None and self._agrees_at_home(fast[1]):
            self.method, self._function = fast[0], BatchFunction(fast[1], backend)

    def _fast_kernel(self) -> tuple[Method, Kernel] | None:
        tree, length = self.kinematics.tree, self.kinematics.length
        if self.model == "refined":
            composition = Composition(tree, length)
            return ("composition", composition.kernel()) if composition.available else None
        simplified = SimplifiedModel(self.kinematics.loops)
        mobility = self.kinematics.mobility
        driven_chords = any(Freedom.DRIVEN in chord.freedoms for chord in tree.chords)
        if len(simplified.driven) == mobility.numeric - mobility.idle and not driven_chords:
            return "jacobian", simplified.kernel()
        return None

    def _agrees_at_home(self, kernel: Kernel) -> bool:
        """Check the fast path once against the general assembly, before it is trusted."""
        exact = self.at_home.compliance
        if exact is None:
            return True
        fast = BatchFunction(kernel, "numpy")(self.kinematics.home.coordinates)[:21]
        unit_free = np.diag([1.0 / self.kinematics.length] * 3 + [1.0] * 3)
        error = unit_free @ (full_matrices(fast)[..., 0] - exact) @ unit_free
        allowed = _AGREEMENT * np.abs(unit_free @ exact @ unit_free).max()
        return bool((np.abs(error) <= allowed).all())

    @cached_property
    def at_home(self) -> AssembledCompliance:
        """The general assembly's answer at the home posture."""
        return self.assembly.at(self.kinematics.home.coordinates[:, 0])

    @cached_property
    def uncontrolled(self) -> bool:
        """Whether the tool has a free motion at ordinary postures, not at singular ones only."""
        if not self.at_home.free_motions:
            return False
        around = self._neighbours_of_home()
        return bool(around) and all(self.assembly.at(q).free_motions for q in around)

    def _neighbours_of_home(self) -> list[Array]:
        kinematics = self.kinematics
        home = np.array([kinematics.home.tool[DIRECTIONS.index(d), 0] for d in kinematics.asked])
        rng = np.random.default_rng(0)
        scale = np.array(
            [1.0 if d.startswith("r") else kinematics.length for d in kinematics.asked]
        )
        around = home[:, None] + 0.05 * scale[:, None] * rng.uniform(-1.0, 1.0, (len(home), 4))
        postures = kinematics.solve(around)
        return list(postures.coordinates.T[postures.reached])

    def at(self, postures: Postures) -> Compliances:
        """Return the compliances at postures."""
        return self.ready_for(len(postures))(postures)

    def ready_for(self, n: int) -> Callable[[Postures], Compliances]:
        """Return `at` for about ``n`` postures, given in any number of parts.

        By composition and Jacobian several threads may compute them.
        """
        if self._function is None:
            return self._assembled
        evaluate = self._function.ready_for(n)
        # Found out here, by one thread, what all the others will say of singular postures.
        otherwise = Status.UNCONTROLLED if self.uncontrolled else Status.SINGULAR
        return lambda postures: self._evaluated(evaluate, otherwise, postures)

    def _evaluated(
        self, evaluate: Callable[[Array], Array], otherwise: Status, postures: Postures
    ) -> Compliances:
        out = evaluate(postures.coordinates)
        lower, measure = out[:21], out[21]
        if self.method == "composition":
            singular = ~(measure > ZERO_SHARE)
        else:
            singular = ~(measure < 1.0 / ZERO_SHARE)
        singular |= ~np.isfinite(lower).all(axis=0)
        return _with_status(lower, singular, otherwise, postures)

    def _assembled(self, postures: Postures) -> Compliances:
        lower = np.full((21, len(postures)), np.nan)
        reached = np.flatnonzero(postures.reached)
        found = self.assembly.at_each(postures.coordinates[:, reached])
        for n, assembled in zip(reached, found, strict=True):
            if assembled.compliance is not None:
                lower[:, n] = lower_triangles(assembled.compliance)
        singular = ~np.isfinite(lower[0])
        found_some = singular[reached].any()
        otherwise = Status.UNCONTROLLED if found_some and self.uncontrolled else Status.SINGULAR
        return _with_status(lower, singular, otherwise, postures)


def _with_status(
    lower: Array, singular: NDArray[np.bool_], otherwise: Status, postures: Postures
) -> Compliances:
    """Return compliances (21, N) with the status that tells where there are none, and why."""
    status = np.zeros(len(postures), dtype=np.int8)
    status[singular] = otherwise
    status[~postures.reached] = Status.UNREACHABLE
    if status.any():
        lower[:, status != Status.OK] = np.nan
    return Compliances(lower, status)
