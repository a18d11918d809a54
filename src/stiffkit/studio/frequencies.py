"""Lowest natural frequencies over the workspace of a variant."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend
from stiffkit.errors import StiffkitError
from stiffkit.stiffness import Model
from stiffkit.studio.stations import Closed, Stations
from stiffkit.study.sweep.frequencies import Basis
from stiffkit.study.sweep.group import Group, Groups
from stiffkit.study.sweep.train import train_basis
from stiffkit.vibration import FastGeometries, platform_mass, simplified_frequencies

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_VARIANTS = 6
"""Variants that the basis is made from and proved at, the file's own among them."""
_MOST_TRIED = 20
_AWAY = 0.15
"""How far they are from the file's own values, at most, over the ranges of the sliders."""
_WORTH_COMPILING = 2000
"""Postures of the workspace from which on compiling is less work than interpreting."""
_TOGETHER = 1024
"""Postures at a time: each takes constants of its own, some thousand of them."""


class Frequencies:
    """The fast model of all variants of a robot."""

    def __init__(self, groups: Groups, stations: Stations, backend: Backend) -> None:
        """Take what reaches the variants that the fast model is made from, when first needed."""
        self._groups = groups
        self._stations = stations
        few = groups.family.n_postures < _WORTH_COMPILING
        self._backend: Backend = "numpy" if few else backend
        self._fast: dict[Group, FastGeometries] = {}

    @property
    def is_ready(self) -> bool:
        """Whether the refined model is made; making it takes from seconds to half a minute."""
        return bool(self._fast)

    @cached_property
    def basis(self) -> Basis:
        """The basis of the fast model; it has no vectors where none is good enough."""
        family, varied = self._groups.family, self._groups.family.spec.varied
        rng = np.random.default_rng(0)
        anchors = self._stations.own
        for _ in range(_MOST_TRIED):
            if anchors.number == _VARIANTS or not varied:
                break
            away = rng.uniform(-_AWAY, _AWAY, len(varied)) * family.span
            values = dict(zip((v.name for v in varied), family.own_values() + away, strict=True))
            try:
                anchors = anchors.with_one_more(self._stations.anchor(values))
            except StiffkitError:
                # There can be no such robot; others will do.
                continue
        return train_basis(self._groups, anchors)

    def lowest(self, closed: Closed, model: Model, lower: Array, known: Mask) -> Array:
        """Return the lowest frequency (P,), Hz, of a model with compliances (21, P).

        NaN where the compliance is not ``known`` (P,). Raises LinkError where masses are at fault,
        StiffkitError where there is no fast model.
        """
        found = np.full(known.shape, np.nan)
        at = np.flatnonzero(known)
        if model == "refined":
            found[at] = self._refined(closed, at)
        else:
            mass = platform_mass(closed.geometry.robot)
            tool, _ = closed.observe(closed.q[:, at])
            length = closed.geometry.length
            found[at] = simplified_frequencies(lower[:, at], tool, mass, length)[0]
        return found

    def _refined(self, closed: Closed, at: NDArray[np.intp]) -> Array:
        group, geometry = closed.group, closed.geometry
        if not self.basis.U.shape[1]:
            raise StiffkitError(
                f"{geometry.robot.name} has no fast model of vibration that is good enough",
                mend="look at single poses, or run 'stiffkit map'",
            )
        if group not in self._fast:
            self._fast[group] = FastGeometries(
                group.tree, group.length, self.basis.U, self._backend
            )
        fast = self._fast[group]
        constants = fast.constants(geometry.robot, geometry.length, geometry.elasticity)
        q = closed.q[: group.tree.n_coordinates, None, at]
        parts = [
            fast.lowest([constants], q[:, :, start : start + _TOGETHER])[0][0]
            for start in range(0, at.size, _TOGETHER)
        ]
        return np.concatenate([np.zeros(0), *parts])
