"""Machine code for geometries that share a topology."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, GeometriesFunction
from stiffkit.kinematics import ClosureEquations, SpanningTree
from stiffkit.robot import DIRECTIONS, Robot
from stiffkit.stiffness import Composition, Model, SimplifiedModel
from stiffkit.study.sweep.family import Family, Geometry

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CompliancesOfModel:
    """The compliance of a model as a kernel, and the constants that it has beside the common."""

    model: Model
    method: str
    """composition, jacobian or assembly; the last one has no kernel."""
    function: GeometriesFunction | None
    drives: tuple[str, ...] = ()
    """Driven directions, whose compliances follow upon geometry and length."""


class Group:
    """Geometries in which the same constants are zeros, and ones in rotations."""

    def __init__(self, family: Family, geometry: Geometry, backend: Backend) -> None:
        """Make the kernels, of one of the geometries."""
        self.family = family
        self.backend = backend
        self.tree = SpanningTree.of(geometry.robot)
        self.length = geometry.length
        self.closure = ClosureEquations(self.tree, family.asked, self.length, any_geometry=True)
        self.at_home = ClosureEquations(
            self.tree, family.given_at_home, self.length, any_geometry=True
        )
        self.n_geometric = self.closure.constants.values.size
        """How many of the constants the closure has, which come first."""

    @cached_property
    def step(self) -> GeometriesFunction:
        """Newton's step at the tool coordinates that fix a posture."""
        return GeometriesFunction(self.closure.newton_step(), self.backend)

    @cached_property
    def home_step(self) -> GeometriesFunction:
        """Newton's step at the tool coordinates that the file gives at home."""
        return GeometriesFunction(self.at_home.newton_step(), self.backend)

    @cached_property
    def observe(self) -> GeometriesFunction:
        """The tool's frame and the chords'."""
        return GeometriesFunction(self.closure.observation(), self.backend)

    @cached_property
    def models(self) -> list[CompliancesOfModel]:
        """The models that are asked for."""
        return [self._model(model) for model in self.family.spec.models]

    def _model(self, model: Model) -> CompliancesOfModel:
        method = self.family.analysis.model(model).method
        if method == "composition":
            kernel = Composition(self.tree, self.length).kernel()
            return CompliancesOfModel(model, method, GeometriesFunction(kernel, self.backend))
        if method == "jacobian":
            loops = ClosureEquations(self.tree, (), self.length, any_geometry=True)
            simplified = SimplifiedModel(loops)
            function = GeometriesFunction(simplified.kernel(), self.backend)
            return CompliancesOfModel(model, method, function, tuple(simplified.drive_names))
        return CompliancesOfModel(model, method, None)

    def constants_of(self, model: CompliancesOfModel, geometry: Geometry) -> Array:
        """Return the constants (m,) that a model's kernel takes."""
        if model.method != "jacobian":
            return geometry.constants
        drives = drive_compliances(geometry.robot, model.drives)
        return np.concatenate([geometry.constants[: self.n_geometric], drives])


class Groups:
    """The groups of a family, each made when its first geometry is met."""

    def __init__(self, family: Family, backend: Backend) -> None:
        """Begin with none."""
        self.family = family
        self.backend = backend
        self._known: dict[bytes, Group] = {}

    def of(self, geometry: Geometry) -> Group:
        """Return the group that a geometry belongs to."""
        if geometry.pattern not in self._known:
            self._known[geometry.pattern] = Group(self.family, geometry, self.backend)
        return self._known[geometry.pattern]


def drive_compliances(robot: Robot, drives: tuple[str, ...]) -> Array:
    """Return the compliances (n,), SI, of driven directions such as "motor.rz"."""
    parts = (name.rpartition(".") for name in drives)
    return np.array(
        [1.0 / robot.joints[joint].stiffness[DIRECTIONS.index(d)] for joint, _, d in parts]
    )
