"""Postures to compliances, by the fastest method that is exact for the robot: the main door."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction
from stiffkit.kinematics import Kinematics, Postures, Status
from stiffkit.robot import DIRECTIONS, Freedom
from stiffkit.smallmat import ZERO_SHARE
from stiffkit.stiffness.assembly import AssembledCompliance, Assembly, Model
from stiffkit.stiffness.composition import Composition
from stiffkit.stiffness.indices import lower_triangles
from stiffkit.stiffness.simplified import SimplifiedModel

Array = NDArray[np.float64]

Method = Literal["composition", "jacobian", "assembly"]


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
        self.assembly = Assembly(kinematics.tree, kinematics.length, model)
        self.method, self._function = self._choose(backend)

    def _choose(self, backend: Backend | None) -> tuple[Method, BatchFunction | None]:
        tree, length = self.kinematics.tree, self.kinematics.length
        if self.model == "refined":
            composition = Composition(tree, length)
            if composition.available:
                return "composition", BatchFunction(composition.kernel(), backend)
        else:
            simplified = SimplifiedModel(self.kinematics.loops)
            mobility = self.kinematics.mobility
            driven_chords = any(Freedom.DRIVEN in chord.freedoms for chord in tree.chords)
            if len(simplified.driven) == mobility.numeric - mobility.idle and not driven_chords:
                return "jacobian", BatchFunction(simplified.kernel(), backend)
        return "assembly", None

    @cached_property
    def at_home(self) -> AssembledCompliance:
        """The general assembly's answer at the home posture."""
        return self.assembly.at(self.kinematics.home.coordinates[:, 0])

    @cached_property
    def uncontrolled(self) -> bool:
        """Whether the tool has a free motion at ordinary postures, not at singular ones only."""
        if not self.at_home.free_motions:
            return False
        return all(self.assembly.at(q).free_motions for q in self._neighbours_of_home())

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
        if self._function is None:
            return self._assembled(postures)
        out = self._function(postures.coordinates)
        lower, measure = out[:21], out[21]
        if self.method == "composition":
            singular = ~(measure > ZERO_SHARE)
        else:
            singular = ~(measure < 1.0 / ZERO_SHARE)
        singular |= ~np.isfinite(lower).all(axis=0)
        return self._with_status(lower, singular, postures)

    def _assembled(self, postures: Postures) -> Compliances:
        lower = np.full((21, len(postures)), np.nan)
        for n in np.flatnonzero(postures.reached):
            found = self.assembly.at(postures.coordinates[:, n]).compliance
            if found is not None:
                lower[:, n] = lower_triangles(found)
        return self._with_status(lower, ~np.isfinite(lower[0]), postures)

    def _with_status(
        self, lower: Array, singular: NDArray[np.bool_], postures: Postures
    ) -> Compliances:
        status = np.zeros(len(postures), dtype=np.int8)
        if singular[postures.reached].any():
            status[singular] = Status.UNCONTROLLED if self.uncontrolled else Status.SINGULAR
        status[~postures.reached] = Status.UNREACHABLE
        lower[:, status != Status.OK] = np.nan
        return Compliances(lower, status)
