"""Elastic coordinates in the axes of their own link or joint, where postures can be compared.

The coordinates of the general assembly turn with the posture. Seen from the link or the joint that
yields, and measured by the root of their strain energy, the modes of one posture look much like
those of another: a few of them span a basis for all postures (`FastModes`), and the products of
two postures' modes tell which is which (`track_modes`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Located
from stiffkit.network import elements_of, loose_directions
from stiffkit.robot import Freedom, Joint, Link
from stiffkit.smallmat import as_objects
from stiffkit.spatial import twist_shift
from stiffkit.vibration.modes import ModalModel
from stiffkit.vibration.reduced import Basis
from stiffkit.vibration.tracking import ModeVectors

Array = NDArray[np.float64]


def modes_in_own_axes(full: ModalModel, q: Array, n: int) -> ModeVectors:
    """Return the lowest ``n`` modes at coordinates (n_coordinates, N), by the full model."""
    frequencies = np.full((n, q.shape[1]), np.nan)
    vectors = np.zeros((q.shape[1], n, 0))
    for i, modes in enumerate(full.at_each(q, n)):
        # A shape of unit modal mass has the energy omega^2 / 2.
        shapes = to_own_axes(full, q[:, i], modes.shapes / (2.0 * np.pi * modes.frequencies_hz))
        if i == 0:
            vectors = np.zeros((q.shape[1], n, shapes.shape[0]))
        found = modes.frequencies_hz.size
        frequencies[:found, i] = modes.frequencies_hz
        vectors[i, :found] = shapes.T
    return ModeVectors(frequencies, vectors)


def to_own_axes(full: ModalModel, q: Array, shapes: Array) -> Array:
    """Return elastic coordinates (n_energy, k) of shapes (n, k) of the network at q (n,).

    They are in their own axes and of unit stiffness: half their square is the strain energy.
    """
    coordinates = full.coordinates
    located = Located(
        full.tree,
        coordinates.constants,
        as_objects(q),
        as_objects(coordinates.constants.values),
    )
    tool = np.array(located.tool.p, dtype=float)
    to_si = np.diag([full.length] * 3 + [1.0] * 3)
    rows, start = [], 0
    for part in elements_of(coordinates.network, full.tree.robot):
        if isinstance(part, Link):
            frame = located.body(part.name)
            R, p = np.array(frame.R, dtype=float), np.array(frame.p, dtype=float)
            turn = np.kron(np.eye(2), R.T)
            deflections = []
            for port in part.other_ports:
                place = R @ part.ports[port].position + p
                own = shapes[start : start + 6]
                deflections.append(turn @ twist_shift(place - tool) @ to_si @ own)
                start += 6
            rows.append(_root_stiffness(part) @ np.concatenate(deflections))
            roots = np.sqrt(full.bodies.mode_stiffness.get(part.name, np.zeros(0)))
            rows.append(roots[:, None] * shapes[start : start + roots.size])
            start += roots.size
        else:
            for direction in loose_directions(part):
                unit = 1.0 if direction.turns else full.length
                if direction.freedom is not Freedom.PASSIVE:
                    root = np.sqrt(part.stiffness[direction.index])
                    rows.append(root * unit * shapes[start : start + 1])
                start += 1
    return np.concatenate(rows)


def basis_of(
    elements: Iterable[Link | Joint], mode_stiffness: Mapping[str, Array], U: Array
) -> Basis:
    """Return the basis whose columns are U (n_energy, r), orthonormal and in their own axes.

    ``elements`` are those of the robot's network, see `stiffkit.network.elements_of`;
    ``mode_stiffness`` holds the squared angular frequencies (n,) of links' internal modes.
    """
    edges: list[Array] = []
    modes: dict[str, Array] = {}
    start = 0
    for part in elements:
        if isinstance(part, Link):
            p = len(part.other_ports)
            bending = U[start : start + 6 * p]
            edges += np.split(np.linalg.solve(_root_stiffness(part), bending), p)
            start += 6 * p
            roots = np.sqrt(mode_stiffness.get(part.name, np.zeros(0)))
            modes[part.name] = U[start : start + roots.size] / roots[:, None]
            start += roots.size
        else:
            directions = loose_directions(part)
            edges.append(np.zeros((len(directions), U.shape[1])))
            for row, direction in zip(edges[-1], directions, strict=True):
                if direction.freedom is not Freedom.PASSIVE:
                    row[:] = U[start] / np.sqrt(part.stiffness[direction.index])
                    start += 1
    return Basis(tuple(edges), modes)


@lru_cache(maxsize=1000)
def _root_stiffness(link: Link) -> Array:
    """Return E with E^T E the inverse of a link's compliance (n, n)."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(np.asarray(link.compliance))))
