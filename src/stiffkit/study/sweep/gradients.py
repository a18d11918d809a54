"""Exact derivatives of what is reduced over the workspace, by the varied parameters.

A column of a study's table is a statistic of a quantity over postures. Which postures count, and
how much, follows from the statistic; there the quantity's derivative by the compliance is carried
back through the compliance to the constants of the mechanism, and through the loops, which stay
closed (`stiffkit.stiffness.sensitivity`). What is left is how constants follow the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import StiffkitError
from stiffkit.kinematics import SpanningTree
from stiffkit.kinematics.sensitivity import ClosureSensitivity, Following
from stiffkit.stiffness import Model
from stiffkit.stiffness.indices import deflection, full_matrices
from stiffkit.stiffness.sensitivity import ComplianceSensitivity
from stiffkit.stiffness.slopes import as_lower, by_compliance, by_deflection
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.closing import Closing
from stiffkit.study.sweep.differences import STENCIL, Numbers, derivatives, steps_of
from stiffkit.study.sweep.engine import NEAREST, Engine, compliances
from stiffkit.study.sweep.family import Geometry
from stiffkit.study.sweep.group import CompliancesOfModel, Group
from stiffkit.study.sweep.spec import Column
from stiffkit.study.sweep.statistics import reduce, shares
from stiffkit.vibration import ModalModel
from stiffkit.vibration.slopes import Change, lowest_frequency_slopes

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Gradient:
    """Columns of one geometry and their derivatives."""

    values: Array
    """(C,), SI; NaN where there is no answer."""
    slopes: Array
    """(C, k), by each of the varied parameters, SI."""


@dataclass(frozen=True, eq=False)
class Traced:
    """A quantity at N postures, traced back to what it follows from."""

    following: Following
    """Its derivatives by tool coordinates and by the constants of the mechanism, SI."""
    by_parameters: Array
    """(k, N), its derivatives by the varied parameters, SI."""


class Gradients:
    """Derivatives of the columns of geometries of one family."""

    def __init__(self, engine: Engine) -> None:
        """Take the engine that computes the columns themselves."""
        self.engine = engine
        self.family = engine.family
        self._compliance: dict[tuple[Group, Model], ComplianceSensitivity] = {}
        self._closing: dict[Group, ClosureSensitivity] = {}

    def at(self, values: Array, columns: Sequence[Column], model: Model = "refined") -> Gradient:
        """Return columns and derivatives at values (k,) of the varied parameters, SI.

        Raises FileError or PoseError where there can be no such robot.
        """
        postures = self.postures(values)
        if postures is None:
            return Gradient(
                np.full(len(columns), np.nan), np.full((len(columns), values.size), np.nan)
            )
        return self.of(postures, columns, model)

    def of(
        self, postures: PosturesOf, columns: Sequence[Column], model: Model = "refined"
    ) -> Gradient:
        """Return columns and derivatives of a geometry whose postures are known."""
        k = postures.values.size
        found = Gradient(np.full(len(columns), np.nan), np.full((len(columns), k), np.nan))
        lower, ok = postures.compliances(model)
        for i, column in enumerate(columns):
            one = self._column(postures, column, model, lower, ok)
            found.values[i], found.slopes[i] = one
        return found

    def postures(self, values: Array) -> PosturesOf | None:
        """Return the postures of a geometry over its workspace, None if it is not assembled."""
        family = self.family
        geometry = family.geometry(values)
        near = self.engine.anchors.nearest(values[:, None], family.span, NEAREST)
        closing = Closing(self.engine.groups.of(geometry), [geometry], self.engine.anchors, near)
        homes = closing.homes()
        if homes.reasons[0]:
            return None
        q, reached = closing.postures(np.zeros(1, dtype=np.intp), homes)
        asked = closing.asked(np.zeros(1, dtype=np.intp), homes)
        return PosturesOf(self, values, geometry, q[:, 0], asked[:, 0], reached[0])

    def _column(
        self, postures: PosturesOf, column: Column, model: Model, lower: Array, ok: Mask
    ) -> tuple[float, Array]:
        quantity = QUANTITIES[column.quantity]
        if quantity.source == "frequencies":
            return self._frequency(postures, column, ok)
        load = column.load
        wrench = None if load is None else postures.geometry.robot.loads[load].wrench
        values = quantity.of_compliance(lower, wrench)
        result = float(reduce(column, values[None])[0][0])
        if not np.isfinite(result):
            # A direction that does not yield at all keeps on doing so.
            nothing = 0.0 if np.isinf(result) else np.nan
            return result, np.full(postures.values.size, nothing)
        weights = shares(column, values)
        at = np.flatnonzero(weights)
        slopes = postures.quantity_slopes(column.quantity, load, model, at, lower[:, at])
        return result, slopes @ weights[at]

    def _frequency(self, postures: PosturesOf, column: Column, ok: Mask) -> tuple[float, Array]:
        at = self.family.frequency_postures
        at = at[ok[at]]
        if not at.size:
            return np.nan, np.full(postures.values.size, np.nan)
        lowest, slopes = postures.frequency_slopes(at)
        result = float(reduce(column, lowest[None])[0][0])
        return result, slopes @ shares(column, lowest)

    def knows(self, model: Model) -> bool:
        """Tell whether compliances of a model have derivatives: those that are kernels do."""
        return self.family.analysis.model(model).method != "assembly"

    def compliance_sensitivity(self, group: Group, model: Model) -> ComplianceSensitivity:
        """Return what carries derivatives back through the compliance of a model."""
        key = (group, model)
        if key not in self._compliance:
            function = _of(group, model).function
            if function is None:
                raise StiffkitError(
                    f"the {model} model of {self.family.robot.name} has no exact derivatives: its"
                    " compliance is that of the general assembly, one posture at a time",
                    mend="'stiffkit check' names the methods that a robot gets; ask for the other"
                    " model, or give rigid parts and drives a finite stiffness",
                )
            self._compliance[key] = ComplianceSensitivity(
                function.kernel, group.closure, group.backend
            )
        return self._compliance[key]

    def closing_sensitivity(self, group: Group) -> ClosureSensitivity:
        """Return what carries derivatives back through the loops."""
        if group not in self._closing:
            self._closing[group] = ClosureSensitivity(group.closure, group.backend)
        return self._closing[group]


class PosturesOf:
    """The postures of one geometry, and how everything about them follows its parameters."""

    def __init__(
        self,
        gradients: Gradients,
        values: Array,
        geometry: Geometry,
        q: Array,
        asked: Array,
        reached: Mask,
    ) -> None:
        """Take unknowns (n, P) at tool coordinates asked for (m, P), and which are reached."""
        self.gradients = gradients
        self.family = gradients.family
        self.values = values
        self.geometry = geometry
        self.q = q
        self.asked = asked
        self.reached = reached
        self.steps = steps_of(values, self.family.span)
        # A parameter that is zero, or a right angle, may leave zeros in the constants that are
        # there by its value and not by the topology. A neighbour shows which ones these are.
        shares = 0.1 + np.modf(0.618034 * np.arange(1, values.size + 1))[0]
        beside = self.family.geometry(values + shares * self.steps)
        self.group = gradients.engine.groups.of(beside)
        self.slopes = derivatives(self._numbers, values, self.steps)

    def _numbers(self, values: Array) -> Numbers:
        geometry = self.family.geometry(values)
        numbers = {"poses": geometry.poses, "home": geometry.home}
        for model in self.group.models:
            numbers[model.model] = self.group.constants_of(model, geometry)
        for name, load in geometry.robot.loads.items():
            numbers[f"wrench:{name}"] = load.wrench
        return numbers

    def compliances(self, model: Model) -> tuple[Array, Mask]:
        """Return compliances (21, P), SI, and where there is an answer (P,)."""
        own = _of(self.group, model)
        lower, ok = compliances(
            self.group, own, [self.geometry], self.q[:, None], self.reached[None]
        )
        return lower[:, 0], ok[0]

    def quantity_slopes(
        self, name: str, load: str | None, model: Model, at: NDArray[np.intp], lower: Array
    ) -> Array:
        """Return the derivatives (k, N) of a quantity at N postures with compliances (21, N)."""
        return self.traced(name, load, model, at, lower).by_parameters

    def traced(
        self, name: str, load: str | None, model: Model, at: NDArray[np.intp], lower: Array
    ) -> Traced:
        """Return a quantity at N postures with compliances (21, N), traced to what it follows."""
        if not QUANTITIES[name].per_load:
            following = self.following(model, at, by_compliance(name, lower))
            return Traced(following, self._by_parameters(following, at, self.slopes[model]))
        wrench = self.geometry.robot.loads[str(load)].wrench
        slopes = by_deflection(name, deflection(lower, wrench))
        seeds = as_lower(slopes[:, None] * wrench[None, :, None])
        following = self.following(model, at, seeds)
        by_wrench = np.einsum("ijn,in->jn", full_matrices(lower), slopes)
        by_parameters = self._by_parameters(following, at, self.slopes[model])
        return Traced(following, by_parameters + self.slopes[f"wrench:{load}"] @ by_wrench)

    def following(self, model: Model, at: NDArray[np.intp], seeds: Array) -> Following:
        """Return how functions of the compliances of N postures follow pose and constants.

        ``seeds`` (21, N) are the functions' derivatives by the compliances' lower triangles.
        """
        sensitivity = self.gradients.compliance_sensitivity(self.group, model)
        constants = self.group.constants_of(_of(self.group, model), self.geometry)
        return sensitivity.of(self.q[:, at], self.asked[:, at], seeds, constants)

    def unknowns_slopes(self, at: NDArray[np.intp]) -> Array:
        """Return the derivatives (k, n, N) of the unknowns of N postures, poses followed."""
        n = self.q.shape[0]
        repeated = np.repeat(at, n)
        one_each = np.tile(np.eye(n), at.size)
        sensitivity = self.gradients.closing_sensitivity(self.group)
        geometric = self.group.n_geometric
        following = sensitivity.of(
            self.q[:, repeated],
            self.asked[:, repeated],
            one_each,
            self.geometry.constants[:geometric],
        )
        by_constants = self.slopes[self.group.models[0].model][:, :geometric]
        found = self._by_parameters(following, repeated, by_constants)
        return np.swapaxes(found.reshape(-1, at.size, n), 1, 2)

    def _by_parameters(
        self, following: Following, at: NDArray[np.intp], by_constants: Array
    ) -> Array:
        """Return derivatives (k, N) by parameters of those by constants and tool coordinates."""
        by_constants = by_constants.copy()
        # The length that makes equations free of units changes nothing.
        by_constants[:, self.group.n_geometric - 1] = 0.0
        asked = self._asked_slopes()[:, :, at]
        return np.asarray(
            by_constants @ following.constants + np.einsum("kmn,mn->kn", asked, following.asked)
        )

    def _asked_slopes(self) -> Array:
        """Return the derivatives (k, m, P) of the tool coordinates that are asked for."""
        family = self.family
        slopes = np.zeros((self.values.size, len(family.asked), self.q.shape[1]))
        for row, name in enumerate(family.asked):
            if name in family.swept:
                slopes[:, row] = self.slopes["poses"][:, family.swept.index(name)]
            elif name in family.given_at_home:
                slopes[:, row] = self.slopes["home"][:, family.given_at_home.index(name), None]
        return slopes

    def frequency_slopes(self, at: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return the lowest frequencies (N,) of N postures, and their derivatives (k, N), Hz."""
        length = self.geometry.length
        q = self.q[: self.group.tree.n_coordinates, at]
        moved = self.unknowns_slopes(at)[:, : len(q)]
        model = ModalModel(SpanningTree.of(self.geometry.robot), length, backend="numpy")
        changes = [self._change(i, q, moved[i]) for i in range(self.values.size)]
        found = lowest_frequency_slopes(model, q, changes, length)
        return found.lowest, found.slopes

    def _change(self, i: int, q: Array, moved: Array) -> Change:
        models, places, weights = [], [], []
        step = self.steps[i]
        for count, weight in STENCIL:
            for sign in (1.0, -1.0):
                values = self.values.copy()
                values[i] += sign * count * step
                tree = SpanningTree.of(self.family.geometry(values).robot)
                models.append(ModalModel(tree, self.geometry.length, backend="numpy"))
                places.append(q + sign * count * step * moved)
                weights.append(sign * weight / step)
        return Change(models, places, weights)


def _of(group: Group, model: Model) -> CompliancesOfModel:
    return next(own for own in group.models if own.model == model)
