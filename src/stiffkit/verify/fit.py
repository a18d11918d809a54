"""How parts lie to each other at a posture: do interfaces meet, do parts overlap."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stiffkit.fea import Part, PartMesh, Port
from stiffkit.fea.distance import distances_to_triangles
from stiffkit.robot import Joint
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array

GAP = 0.25
"""Interfaces of a joint that are farther apart do not meet; over the size of the smaller one."""

DEPTH = 0.01
"""A point that lies deeper in another part means an overlap; over the size of the smaller one."""

_SPACING = 20
"""Points along an interface, at which its distance from the other one is measured."""

_NEAREST = 10
"""Of these points, those whose distance is found exactly."""

_CHUNK = 2_000_000
"""Pairs of points and triangles at a time."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A part of a robot at a posture."""

    part: Part
    ports: Mapping[str, Port]
    T_world_part: Frame
    mesh: PartMesh


@dataclass(frozen=True)
class Gap:
    """Interfaces of a joint that do not meet."""

    joint: str
    first: str
    """A port, such as "arm.tip"."""
    second: str
    distance: float
    """m."""

    def describe(self) -> str:
        """Return it in words."""
        return (
            f"joint {self.joint}: the interfaces {self.first} and {self.second} are "
            f"{1e3 * self.distance:.3g} mm apart"
        )


@dataclass(frozen=True)
class Overlap:
    """Two parts of which one reaches into the other."""

    first: str
    second: str
    depth: float
    """m, of the deepest point that was found."""
    at: tuple[float, float, float]
    """m, that point, world axes."""

    def describe(self) -> str:
        """Return it in words."""
        place = ", ".join(f"{1e3 * x:.4g}" for x in self.at)
        return (
            f"{self.first} and {self.second} overlap: {1e3 * self.depth:.3g} mm deep "
            f"at ({place}) mm"
        )


def find_gaps(joints: Iterable[Joint], placed: Mapping[str, Placed]) -> list[Gap]:
    """Return the joints between two parts whose interfaces do not meet."""
    gaps = []
    for joint in joints:
        if joint.from_body not in placed or joint.to_body not in placed:
            continue
        a = _interface(placed[joint.from_body], joint.from_port)
        b = _interface(placed[joint.to_body], joint.to_port)
        sizes = [float(np.linalg.norm(np.ptp(one.reshape(-1, 3), axis=0))) for one in (a, b)]
        distance = _distance(a, b)
        if distance > GAP * min(sizes):
            ports = (f"{joint.from_body}.{joint.from_port}", f"{joint.to_body}.{joint.to_port}")
            gaps.append(Gap(joint.name, *ports, distance))
    return gaps


def find_overlaps(joints: Iterable[Joint], placed: Mapping[str, Placed]) -> list[Overlap]:
    """Return the pairs of parts that overlap.

    Two parts that a joint ties may share the place around it, to a distance as large as their
    interfaces are: a joint's own body is seldom drawn.
    """
    shared: dict[frozenset[str], list[tuple[Array, float]]] = {}
    for joint in joints:
        for body, port in ((joint.from_body, joint.from_port), (joint.to_body, joint.to_port)):
            if body in placed:
                points = _interface(placed[body], port).reshape(-1, 3)
                middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
                reach = float(np.linalg.norm(np.ptp(points, axis=0)))
                pair = frozenset((joint.from_body, joint.to_body))
                shared.setdefault(pair, []).append((middle, reach))
    overlaps = []
    for first, second in itertools.combinations(placed, 2):
        spared = shared.get(frozenset((first, second)), [])
        deepest = max(
            _deepest(placed[first], placed[second], spared),
            _deepest(placed[second], placed[first], spared),
            key=lambda found: found[0],
        )
        smaller = min(placed[first].part.diagonal, placed[second].part.diagonal)
        if deepest[0] > DEPTH * smaller:
            x, y, z = deepest[1].tolist()
            overlaps.append(Overlap(first, second, deepest[0], (x, y, z)))
    return overlaps


def _interface(placed: Placed, port: str) -> Array:
    """Return the triangles (t, 3, 3) of a port, world axes."""
    own = np.isin(placed.part.triangle_face, placed.ports[port].faces)
    return _moved(placed.T_world_part, placed.part.triangles[own])


def _moved(frame: Frame, points: Array) -> Array:
    return np.asarray(points @ frame.rotation.T + frame.position)


def _distance(a: Array, b: Array) -> float:
    """Return the distance of two sets of triangles (t, 3, 3), from points spread over both."""
    points = _spread(a)
    nearest = np.argsort(cKDTree(_spread(b)).query(points)[0])[:_NEAREST]
    return min(float(distances_to_triangles(point, b).min()) for point in points[nearest])


def _spread(triangles: Array) -> Array:
    """Return points (n, 3) spread over triangles."""
    corners = triangles.reshape(-1, 3)
    spacing = float(np.linalg.norm(np.ptp(corners, axis=0))) / _SPACING
    points = []
    for triangle in triangles:
        longest = max(float(np.linalg.norm(triangle[i] - triangle[i - 1])) for i in range(3))
        n = max(1, int(np.ceil(longest / spacing)))
        shares = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
        points.append(shares @ triangle)
    return np.concatenate(points)


def _deepest(
    inner: Placed, outer: Placed, spared: Iterable[tuple[Array, float]]
) -> tuple[float, Array]:
    """Return how deep a point of one part lies in the other, 0 if none does; and the point."""
    points = _moved(inner.T_world_part, inner.mesh.points)
    own = _moved(outer.T_world_part.inverse, points)
    near = np.all((own >= outer.part.low) & (own <= outer.part.high), axis=1)
    for middle, reach in spared:
        near &= np.linalg.norm(points - middle, axis=1) > reach
    points, own = points[near], own[near]
    # Straight edges cut corners of a bore, but the depth is that below the true surface.
    inside = _inside(own, outer.mesh)
    points, own = points[inside], own[inside]
    if not len(points):
        return 0.0, np.zeros(3)
    depths = [float(distances_to_triangles(point, outer.part.triangles).min()) for point in own]
    return max(depths), points[int(np.argmax(depths))]


def _inside(points: Array, mesh: PartMesh) -> NDArray[np.bool_]:
    """Return which points (n, 3), part axes, lie in one of a mesh's tetrahedra."""
    corners = mesh.points[mesh.tets[:, :4]]
    to_shares = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
    inside = np.zeros(len(points), dtype=bool)
    pieces = max(1, len(points) * len(corners) // _CHUNK)
    for chunk in np.array_split(np.arange(len(points)), pieces):
        arms = points[chunk][:, None] - corners[None, :, 0]
        shares = np.einsum("eij,pej->pei", to_shares, arms)
        within = (shares.min(axis=2) >= 0.0) & (shares.sum(axis=2) <= 1.0)
        inside[chunk] = within.any(axis=1)
    return inside
