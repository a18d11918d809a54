"""Designs with their postures over the workspace, and what is measured at each of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.spec import Measure
from stiffkit.errors import LinkError, StiffkitError
from stiffkit.kinematics.locate import Located
from stiffkit.robot import Robot
from stiffkit.smallmat import vector
from stiffkit.stiffness import deflection
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep import Column
from stiffkit.study.sweep.closing import Closing, Homes
from stiffkit.study.sweep.engine import NEAREST, Engine, compliances
from stiffkit.study.sweep.family import Geometry
from stiffkit.vibration import platform_mass, simplified_frequencies

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_TOGETHER = 1 << 16
"""Postures at a time, of whole designs."""


class Solved:
    """B designs that share their machine code, put together at P postures of their workspaces."""

    def __init__(
        self,
        engine: Engine,
        numbers: NDArray[np.intp],
        closing: Closing,
        homes: Homes,
        which: NDArray[np.intp],
    ) -> None:
        """Take the designs' ``numbers`` (B,), and which of a closing's geometries they are (B,)."""
        self.engine = engine
        self.numbers = numbers
        self.geometries = [closing.geometries[i] for i in which]
        self._closing = closing
        self._which = which
        self._home = homes.unknowns[:, which]
        self._constants = closing.constants[:, which]
        self._all_homes = homes
        self._inside = np.stack([g.inside for g in self.geometries])
        self._compliances: dict[int, tuple[Array, Mask]] = {}
        self._at_postures: dict[tuple[int, str, str | None], Array] = {}
        self._joints: Array | None = None

    @cached_property
    def _postures(self) -> tuple[Array, Mask]:
        """Return the unknowns (n, B, P), NaN where a posture is not reached, and which are."""
        return self._closing.postures(self._which, self._all_homes)

    def of(self, measure: Measure, model: int) -> Array:
        """Return a measure by one of the models, by its number.

        It is (B, n): at each posture, NaN where there is no answer, with n = P, or n = F where the
        postures are those of the frequencies; or n = 1 if it is one number of the whole design.
        """
        match measure.kind:
            case "statistic" if measure.column is not None:
                return self._quantity(measure.column, model)
            case "reached":
                known = self._compliance(model)[1]
                return np.asarray((known.sum(axis=1) / self._inside.sum(axis=1))[:, None])
            case "mass":
                return np.array([[mass_of(g.robot)] for g in self.geometries])
            case "size":
                return self._size()[:, None]
        return self._joint(measure.joint)

    def _size(self) -> Array:
        """Return the largest dimension (B,), m, of the box round all joints and tool at home."""
        group = self._closing.group
        q, c = vector(self._home[: group.tree.n_coordinates]), vector(self._constants)
        at = Located(group.tree, group.closure.constants, q, c)
        joints = group.tree.robot.joints.values()
        frames = [at.tool, *map(at.from_side, joints), *map(at.to_side, joints)]
        points = [np.broadcast_arrays(*frame.p, self._constants[0])[:3] for frame in frames]
        return np.asarray(np.ptp(np.array(points, dtype=float), axis=0).max(axis=0))

    def _compliance(self, model: int) -> tuple[Array, Mask]:
        """Return compliances (21, B, P), and where there is an answer (B, P)."""
        if model not in self._compliances:
            group = self._closing.group
            self._compliances[model] = compliances(
                group, group.models[model], self.geometries, *self._postures
            )
        return self._compliances[model]

    def _quantity(self, column: Column, model: int) -> Array:
        key = model, column.quantity, column.load
        if key not in self._at_postures:
            quantity = QUANTITIES[column.quantity]
            if quantity.source == "frequencies":
                found = self._frequencies(model)
            elif quantity.per_load:
                found = quantity.of(self._deflection(str(column.load), model))
            else:
                found = quantity.of(self._compliance(model)[0])
            self._at_postures[key] = found
        return self._at_postures[key]

    def _deflection(self, load: str, model: int) -> Array:
        lower, _ = self._compliance(model)
        found = [
            deflection(lower[:, i], geometry.robot.loads[load].wrench)
            for i, geometry in enumerate(self.geometries)
        ]
        return np.stack(found, axis=1)

    def _frequencies(self, model: int) -> Array:
        """Return the lowest frequencies (B, F), Hz."""
        group, postures = self._closing.group, self.engine.family.frequency_postures
        lower, known = self._compliance(model)
        q = self._postures[0][:, :, postures]
        if group.models[model].model == "refined":
            if self.engine.frequencies is None:
                return np.full(known[:, postures].shape, np.nan)
            found = self.engine.frequencies.at(group, self.geometries, q, known[:, postures])
            return found.lowest
        number = np.repeat(self._which, postures.size)
        flat = q[: group.tree.n_coordinates].reshape(group.tree.n_coordinates, -1)
        tool, _ = self._closing.observe(flat, number)
        tool = tool.reshape(6, len(self.geometries), postures.size)
        lowest = np.full((len(self.geometries), postures.size), np.nan)
        for i, geometry in enumerate(self.geometries):
            try:
                mass = platform_mass(geometry.robot)
            except LinkError:
                continue
            own = lower[:, i, postures]
            lowest[i] = simplified_frequencies(own, tool[:, i], mass, geometry.length)[0]
        return lowest

    def _joint(self, name: str) -> Array:
        """Return a joint's coordinate (B, P), m or rad."""
        robot = self._closing.group.tree.robot
        names = [f"{joint.name}.{m}" for joint in robot.joints.values() for m in joint.motions]
        if self._joints is None:
            q = self._postures[0][: self._closing.group.tree.n_coordinates]
            number = np.repeat(self._which, q.shape[2])
            with np.errstate(invalid="ignore"):
                _, joints = self._closing.observe(q.reshape(q.shape[0], -1), number)
            self._joints = joints.reshape(-1, *q.shape[1:])
        return np.asarray(self._joints[names.index(name)])


def solve(engine: Engine, values: Array) -> Iterator[Solved]:
    """Yield designs with values (k, G) of the varied parameters, SI.

    Those that cannot be built, or put together, are left out.
    """
    grouped: dict[bytes, list[tuple[int, Geometry]]] = {}
    for i, own in enumerate(values.T):
        try:
            geometry = engine.family.geometry(own)
        except StiffkitError:
            continue
        grouped.setdefault(geometry.pattern, []).append((i, geometry))
    near = engine.anchors.nearest(values, engine.family.span, NEAREST)
    for members in grouped.values():
        numbers = np.array([i for i, _ in members], dtype=np.intp)
        own = [geometry for _, geometry in members]
        closing = Closing(engine.groups.of(own[0]), own, engine.anchors, near[:, numbers])
        homes = closing.homes()
        assembled = np.flatnonzero([not reason for reason in homes.reasons])
        size = max(1, _TOGETHER // engine.family.n_postures)
        for start in range(0, assembled.size, size):
            which = assembled[start : start + size]
            yield Solved(engine, numbers[which], closing, homes, which)


def mass_of(robot: Robot) -> float:
    """Return the mass of all links and the tool, kg."""
    return (robot.tool.mass or 0.0) + sum(link.mass or 0.0 for link in robot.links.values())
