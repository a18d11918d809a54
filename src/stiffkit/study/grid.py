"""The tool poses of a study: a grid over the workspace, or a list of points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import PoseError
from stiffkit.robot import DIRECTIONS, Robot, Workspace, with_place

Array = NDArray[np.float64]

DEFAULT_POSTURES = {1: 201, 2: 2601, 3: 9261}
"""Postures of a map by the number of swept coordinates: quick, and fine enough to look at."""


@dataclass(frozen=True, eq=False)
class PoseGrid:
    """The poses of a study."""

    axes: dict[str, Array]
    """Swept tool coordinates and their grid values, SI; or, for a list of points, their values."""
    listed: bool
    """Whether the poses are a list of points instead of a grid."""
    inside: NDArray[np.bool_]
    """(N,), False where a grid point lies outside the workspace's outline."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the sweep dimensions."""
        sizes = tuple(values.size for values in self.axes.values())
        return sizes[:1] if self.listed else sizes

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the sweep dimensions."""
        return ("point",) if self.listed else tuple(self.axes)

    def values(self) -> dict[str, Array]:
        """Return each swept coordinate at all poses, (N,), last dimension fastest."""
        if self.listed:
            return dict(self.axes)
        grids = np.meshgrid(*self.axes.values(), indexing="ij")
        return {name: grid.ravel() for name, grid in zip(self.axes, grids, strict=True)}


def pose_grid(robot: Robot, points: int | None = None) -> PoseGrid:
    """Return the poses of the robot's workspace, about ``points`` of them for a grid.

    Raises PoseError if the robot has no workspace.
    """
    workspace = robot.workspace
    if workspace.points is not None:
        axes = dict(zip(workspace.point_axes, workspace.points.T, strict=True))
        return PoseGrid(axes, True, np.ones(len(workspace.points), dtype=bool))
    ranges = _ranges(workspace)
    if not ranges:
        error = PoseError(
            f"{robot.name} has no workspace to map",
            mend="add one to the robot file, such as  workspace: {x: [-100 mm, 100 mm]}",
        )
        raise with_place(error, robot, "workspace")
    counts = _counts(ranges, workspace.counts, points)
    axes = {name: _steps(*ranges[name], counts[name]) for name in ranges}
    grid = PoseGrid(axes, False, np.ones(0, dtype=bool))
    values = grid.values()
    inside = np.ones(next(iter(values.values())).size, dtype=bool)
    if workspace.polygon is not None:
        u, v = workspace.polygon_axes
        inside = inside_polygon(values[u], values[v], workspace.polygon)
    return PoseGrid(grid.axes, False, inside)


def _steps(low: float, high: float, count: int) -> Array:
    """Return equal steps, with a zero that is exact."""
    if count == 1:
        return np.array([low])
    values = np.linspace(low, high, count)
    return np.where(np.abs(values) < 1e-9 * (high - low), 0.0, values)


def _ranges(workspace: Workspace) -> dict[str, tuple[float, float]]:
    ranges = dict(workspace.ranges)
    if workspace.polygon is not None:
        for name, corner in zip(workspace.polygon_axes, workspace.polygon.T, strict=True):
            ranges.setdefault(name, (float(corner.min()), float(corner.max())))
    return {name: ranges[name] for name in DIRECTIONS if name in ranges}


def _counts(
    ranges: dict[str, tuple[float, float]], asked: Mapping[str, int], points: int | None
) -> dict[str, int]:
    wide = [name for name, (low, high) in ranges.items() if high > low]
    if points is None and all(name in asked for name in wide):
        return {name: asked[name] if name in wide else 1 for name in ranges}
    total = points or DEFAULT_POSTURES.get(len(wide), 20_000)
    # Equal steps along coordinates of one unit; three points are the least that show a curve.
    widths = np.array([ranges[name][1] - ranges[name][0] for name in wide])
    turns = np.array([name.startswith("r") for name in wide], dtype=bool)
    for kind in (turns, ~turns):
        if kind.any():
            widths[kind] /= np.exp(np.mean(np.log(widths[kind])))
    scale = total ** (1.0 / len(wide)) if wide else 1.0
    share = np.clip(widths, 0.2, 5.0)
    counts = dict.fromkeys(ranges, 1)
    for name, factor in zip(wide, share, strict=True):
        # Odd, so that the middle of the workspace is among the postures.
        counts[name] = max(3, 2 * round((scale * factor - 1.0) / 2.0) + 1)
    return counts


def inside_polygon(u: Array, v: Array, corners: Array) -> NDArray[np.bool_]:
    """Tell which points (N,) lie inside or on an outline (n, 2), by crossings of a ray."""
    inside = np.zeros(u.shape, dtype=bool)
    size = float(np.ptp(corners))
    on_edge = np.zeros(u.shape, dtype=bool)
    for (u0, v0), (u1, v1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        crosses = (v0 > v) != (v1 > v)
        slope = (u1 - u0) / (v1 - v0) if v1 != v0 else 0.0
        inside ^= crosses & (u < u0 + slope * (v - v0))
        length = np.hypot(u1 - u0, v1 - v0)
        along = np.clip(
            ((u - u0) * (u1 - u0) + (v - v0) * (v1 - v0)) / max(length**2, 1e-300), 0, 1
        )
        on_edge |= np.hypot(u - u0 - along * (u1 - u0), v - v0 - along * (v1 - v0)) < 1e-9 * size
    return np.asarray(inside | on_edge)
