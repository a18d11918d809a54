"""The geometries of a study: one mechanism with many values of its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Constants
from stiffkit.errors import PoseError
from stiffkit.files import Given
from stiffkit.kinematics import Postures, typical_length
from stiffkit.network import add_elasticity
from stiffkit.robot import DIRECTIONS, Robot, RobotFile, Workspace
from stiffkit.study.analysis import Analysis
from stiffkit.study.grid import PoseGrid, pose_grid
from stiffkit.study.map import postures_of
from stiffkit.study.sweep.spec import StudySpec
from stiffkit.units import Value, parse_quantity
from stiffkit.vibration.fast import far_apart

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_NEAREST = 6
"""Neighbours of a posture among a list of points."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """A robot with values of its parameters, as far as numbers go."""

    robot: Robot
    length: float
    """m, typical of it."""
    elasticity: Constants
    """Of `stiffkit.network.add_elasticity`."""
    constants: Array
    """(m,), the numbers in it."""
    pattern: bytes
    """Which of the constants are compiled in, and their values."""
    home: Array
    """(k,), the tool coordinates that the file gives at home, SI."""
    hints: Array
    """(n_joint_coordinates,), rough joint coordinates at home, NaN where the file gives none."""
    poses: Array
    """(s, P), the tool coordinates that are swept, SI."""
    inside: Mask
    """(P,), which poses lie in the workspace."""


class Family:
    """What all geometries of a study have in common, and how to make one."""

    def __init__(
        self, spec: StudySpec, derived: Mapping[str, Given] | None = None, *, remembered: int = 0
    ) -> None:
        """Read the robot file and put its own geometry together.

        ``derived`` are parameters that all geometries have in place of the file's own, such as
        expressions on those that are varied. The last ``remembered`` geometries are not made anew
        when they are asked for again.

        Raises FileError, AssemblyError or PoseError where that is not possible.
        """
        self.spec = spec
        self.derived = dict(derived or {})
        self.file = RobotFile(spec.robot)
        self.analysis = Analysis(self.file.robot(self.derived))
        self.robot = self.analysis.robot
        self.kinematics = self.analysis.kinematics
        self.asked = self.kinematics.asked
        self.given_at_home = tuple(d for d in DIRECTIONS if d in self.robot.home.tool)
        self.grid = pose_grid(self.robot, spec.postures)
        ends = [(min(v.values), max(v.values)) for v in spec.varied]
        self.span = np.array([max(high - low, 1e-9 * abs(high), 1e-300) for low, high in ends])
        """(k,), how far the varied parameters range, to make distances comparable."""
        self.frequency_postures = _spread(self.grid, spec.frequency_postures)
        """(F,), the postures at which frequencies are asked for."""
        self._workspace = lru_cache(maxsize=1000)(self._poses)
        self._made = lru_cache(maxsize=remembered)(self._geometry)
        self.neighbours = _neighbours(self.grid)
        """(P, k), postures beside each other in the workspace; -1 where there is none."""

    @property
    def n_postures(self) -> int:
        """P, postures of each geometry."""
        return int(self.grid.inside.size)

    @property
    def swept(self) -> tuple[str, ...]:
        """The tool coordinates of the workspace."""
        return tuple(self.grid.axes)

    def reference_postures(self) -> Postures:
        """Return the postures of the file's own geometry; see `postures_of`."""
        return postures_of(self.analysis, self.grid)

    def own_values(self) -> Array:
        """Return the values (k,) that the file has for the parameters that are varied."""
        return np.array([self.robot.parameters[v.name].value for v in self.spec.varied])

    def parameters(self, values: Array) -> dict[str, float]:
        """Return all parameters, SI, at values (k,) of those that are varied."""
        resolved = self.file.parameters(self._given(values.tolist()))
        return {name: value.si for name, value in resolved.items()}

    def geometry(self, values: Array) -> Geometry:
        """Return the geometry with these values (k,) of the varied parameters, SI.

        Raises FileError or PoseError where there can be no such robot.
        """
        return self._made(tuple(values.tolist()))

    def _geometry(self, values: tuple[float, ...]) -> Geometry:
        return self.geometry_of(self.file.robot(self._given(values)))

    def geometry_of(self, robot: Robot) -> Geometry:
        """Return the geometry that a robot is, which is the family's but for its numbers.

        Raises PoseError where its workspace has another shape.
        """
        length = typical_length(robot)
        constants = Constants()
        add_elasticity(constants, robot, length)
        numbers, compiled_in = constants.values, constants.compiled_in
        grid = self._workspace(robot.workspace)
        return Geometry(
            robot,
            length,
            constants,
            numbers,
            compiled_in.tobytes() + numbers[compiled_in].tobytes(),
            np.array([robot.home.tool[d] for d in self.given_at_home]),
            _hints(robot),
            np.array(list(grid.values().values())),
            grid.inside,
        )

    def _given(self, values: Iterable[float]) -> Mapping[str, Given]:
        given = dict(self.derived)
        for varied, si in zip(self.spec.varied, values, strict=True):
            dims = parse_quantity(f"1 {varied.unit}").dims if varied.unit else None
            given[varied.name] = Value(si, dims)
        return given

    def _poses(self, workspace: Workspace) -> PoseGrid:
        """Return the poses of a geometry's workspace, as many along each axis as in all others."""
        counts = {name: len(values) for name, values in self.grid.axes.items()}
        same = workspace if self.grid.listed else replace(workspace, counts=counts)
        grid = pose_grid(replace(self.robot, workspace=same))
        if grid.shape != self.grid.shape or tuple(grid.axes) != self.swept:
            raise PoseError(
                "the workspace has another shape than that of the robot file's own parameters",
                mend="let no range of it shrink to nothing",
            )
        return grid


def _spread(grid: PoseGrid, count: int) -> NDArray[np.intp]:
    """Return poses (count,) that lie as far apart as can be, those at the edge first."""
    inside = np.flatnonzero(grid.inside)
    points = np.array(list(grid.values().values()))[:, inside]
    return np.asarray(inside[far_apart(points, count)])


def _hints(robot: Robot) -> Array:
    nothing = {name: (np.nan,) * len(joint.motions) for name, joint in robot.joints.items()}
    return np.array([x for hint in (nothing | dict(robot.home.joints)).values() for x in hint])


def _neighbours(grid: PoseGrid) -> NDArray[np.intp]:
    """Return the neighbours (P, k) of each pose: along a grid's axes, or the nearest of a list."""
    if grid.listed:
        from scipy.spatial import cKDTree  # slow to import

        points = np.array(list(grid.axes.values())).T
        points = points / np.maximum(np.ptp(points, axis=0), 1e-300)
        k = min(1 + _NEAREST, len(points))
        _, nearest = cKDTree(points).query(points, k=list(range(1, 1 + k)))
        return np.asarray(nearest[:, 1:], dtype=np.intp)
    numbers = np.arange(grid.inside.size, dtype=np.intp).reshape(grid.shape)
    columns = []
    for axis in range(numbers.ndim):
        for sense in (1, -1):
            moved = np.roll(numbers, sense, axis)
            edge = [slice(None)] * numbers.ndim
            edge[axis] = slice(0, 1) if sense == 1 else slice(-1, None)
            moved[tuple(edge)] = -1
            columns.append(moved.ravel())
    return np.stack(columns, axis=1)
