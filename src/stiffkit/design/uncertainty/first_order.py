"""Error bars of the first order: variances carried through derivatives.

With independent sources of covariances C_s and the derivatives g_s of a quantity by them, its
variance is the sum of g_s^T C_s g_s (JCGM 100:2008, Guide to the expression of uncertainty in
measurement, section 5).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.uncertainty.links import covariance_of
from stiffkit.design.uncertainty.spec import Asked, UncertaintySpec
from stiffkit.errors import StiffkitError
from stiffkit.kinematics import Status
from stiffkit.stiffness import Model
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.engine import Engine
from stiffkit.study.sweep.family import Family
from stiffkit.study.sweep.gradients import Gradients, PosturesOf
from stiffkit.study.sweep.group import Groups
from stiffkit.study.sweep.prepare import make_anchors

Array = NDArray[np.float64]

ROUNDING = 1e-9
"""A deflection that is smaller, over the largest, is nothing but rounding error; and so is what
scatters by less, over its value."""

_TOGETHER = 4096
"""Postures at a time: derivatives by all constants are held for as many."""


@dataclass(frozen=True, eq=False)
class Bands:
    """A quantity at P postures with its error."""

    values: Array
    """(P,), SI; NaN where there is no answer."""
    variances: Array
    """(S, P), that each source causes, SI squared."""

    @property
    def sigma(self) -> Array:
        """Standard deviation (P,), SI."""
        return np.asarray(np.sqrt(self.variances.sum(axis=0)))


class FirstOrder:
    """Error bars of the quantities of one robot over its workspace."""

    def __init__(self, spec: UncertaintySpec, groups: Groups) -> None:
        """Solve the robot at the postures of the family of ``groups``.

        Raises StiffkitError where the robot cannot be put together, or where its compliance has no
        derivatives, and LinkError where a link cannot scatter as it should.
        """
        self.spec = spec
        self.engine = Engine(groups, make_anchors(groups), None)
        self.family: Family = groups.family
        links = self.family.robot.links
        self._covariances = [covariance_of(links[u.name], u) for u in spec.links]
        self._sigma = np.array([p.sigma for p in spec.parameters])
        gradients = Gradients(self.engine)
        postures = gradients.postures(np.array([p.value for p in spec.parameters]))
        if postures is None:
            raise StiffkitError(f"{self.family.robot.name} cannot be assembled")
        self.postures: PosturesOf = postures
        for model in spec.models:
            gradients.compliance_sensitivity(postures.group, model)
        self._compliances = {model: postures.compliances(model) for model in spec.models}

    def status(self, model: Model) -> NDArray[np.int8]:
        """Return the status (P,) of each posture, as maps have it."""
        _, ok = self._compliances[model]
        status = np.where(ok, Status.OK, Status.SINGULAR)
        status[~self.postures.reached] = Status.UNREACHABLE
        status[~self.family.grid.inside] = Status.OUTSIDE
        return status.astype(np.int8)

    def bands(self, asked: Asked, model: Model) -> Bands:
        """Return a quantity with its error at all postures."""
        lower, values = self.nominal(asked, model)
        variances = np.full((len(self.spec.sources), values.size), np.nan)
        variances[:, values == 0.0] = 0.0
        at = np.flatnonzero(np.isfinite(values) & (values != 0.0))
        for start in range(0, at.size, _TOGETHER):
            part = at[start : start + _TOGETHER]
            found = self._variances(asked, model, part, lower[:, part])
            found[found < (ROUNDING * values[part]) ** 2] = 0.0
            variances[:, part] = found
        return Bands(values, variances)

    def nominal(self, asked: Asked, model: Model) -> tuple[Array, Array]:
        """Return compliances (21, P) and a quantity (P,), SI, of the robot as its file has it.

        A deflection that is rounding error is 0, a stiffness beside which all others are nothing
        is infinite.
        """
        lower, _ = self._compliances[model]
        values = self.values(asked, lower)
        if QUANTITIES[asked.quantity].worst_is_largest:
            values[np.abs(values) < self._rounding(asked)] = 0.0
        else:
            values[values > self._rounding(asked)] = np.inf
        return lower, values

    def _rounding(self, asked: Asked) -> float:
        """Return the deflection below which, or the stiffness above which, all is rounding error.

        It is told by the largest deflection, or the smallest stiffness, of all models.
        """
        quantity = QUANTITIES[asked.quantity]
        alike = replace(asked, quantity=quantity.scale)
        sizes = [self.values(alike, lower) for lower, _ in self._compliances.values()]
        known = np.abs(np.concatenate(sizes))
        known = known[np.isfinite(known) & (known > 0.0)]
        if quantity.worst_is_largest:
            return ROUNDING * float(known.max(initial=0.0))
        return float(known.min(initial=np.inf)) / ROUNDING

    def values(self, asked: Asked, lower: Array) -> Array:
        """Return a quantity (...), SI, of compliances given by their lower triangles (21, ...)."""
        load = asked.load
        wrench = None if load is None else self.family.robot.loads[load].wrench
        return QUANTITIES[asked.quantity].of_compliance(lower, wrench)

    def _variances(self, asked: Asked, model: Model, at: NDArray[np.intp], lower: Array) -> Array:
        traced = self.postures.traced(asked.quantity, asked.load, model, at, lower)
        rows = [(self._sigma[:, None] * traced.by_parameters) ** 2]
        for link, covariance in zip(self.spec.links, self._covariances, strict=True):
            where = self.postures.geometry.elasticity.where(f"compliance:{link.name}")
            if model == "simplified":
                rows.append(np.zeros((1, at.size)))
                continue
            g = traced.following.constants[where]
            rows.append(np.einsum("in,ij,jn->n", g, covariance, g)[None])
        return np.concatenate(rows)
