"""Elastic coordinates in the axes of their own link or joint, where postures can be compared.

The coordinates of the general assembly turn with the posture. Seen from the link or the joint that
yields, and measured by the root of their strain energy, the modes of one posture look much like
those of another: a few of them span a basis for all postures (`FastModes`), and the products of
two postures' modes tell which is which (`track_modes`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics import Located
from stiffkit.network import JointPart, LinkPart, loose_directions
from stiffkit.robot import Freedom
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
    coordinates, robot = full.coordinates, full.tree.robot
    located = Located(
        full.tree,
        coordinates.constants,
        as_objects(q),
        as_objects(coordinates.constants.values),
    )
    tool = np.array(located.tool.p, dtype=float)
    to_si = np.diag([full.length] * 3 + [1.0] * 3)
    rows, start = [], 0
    for edge in coordinates.network.edges:
        if isinstance(edge.part, LinkPart):
            link = robot.links[edge.part.name]
            frame = located.body(link.name)
            R = np.array(frame.R, dtype=float)
            tip = R @ link.ports["tip"].position + np.array(frame.p, dtype=float)
            to_tip = np.kron(np.eye(2), R.T) @ twist_shift(tip - tool) @ to_si
            roots = np.sqrt(full.bodies.mode_stiffness.get(link.name, np.zeros(0)))
            end = start + 6 + roots.size
            rows.append(_root_stiffness(link.compliance) @ to_tip @ shapes[start : start + 6])
            rows.append(roots[:, None] * shapes[start + 6 : end])
            start = end
        elif isinstance(edge.part, JointPart):
            joint = robot.joints[edge.part.name]
            for direction in loose_directions(joint):
                unit = 1.0 if direction.turns else full.length
                if direction.freedom is not Freedom.PASSIVE:
                    root = np.sqrt(joint.stiffness[direction.index])
                    rows.append(root * unit * shapes[start : start + 1])
                start += 1
    return np.concatenate(rows)


def basis_of(full: ModalModel, U: Array) -> Basis:
    """Return the basis whose columns are U (n_energy, r), orthonormal and in their own axes."""
    robot = full.tree.robot
    blocks: dict[int, Array] = {}
    start = 0
    for i, edge in enumerate(full.coordinates.network.edges):
        if isinstance(edge.part, LinkPart):
            link = robot.links[edge.part.name]
            roots = np.sqrt(full.bodies.mode_stiffness.get(link.name, np.zeros(0)))
            end = start + 6 + roots.size
            bending = np.linalg.solve(_root_stiffness(link.compliance), U[start : start + 6])
            blocks[i] = np.vstack([bending, U[start + 6 : end] / roots[:, None]])
            start = end
        elif isinstance(edge.part, JointPart):
            joint = robot.joints[edge.part.name]
            directions = loose_directions(joint)
            blocks[i] = np.zeros((len(directions), U.shape[1]))
            for j, direction in enumerate(directions):
                if direction.freedom is not Freedom.PASSIVE:
                    blocks[i][j] = U[start] / np.sqrt(joint.stiffness[direction.index])
                    start += 1
    return Basis(blocks)


def _root_stiffness(compliance: Array | None) -> Array:
    """Return E with E^T E the inverse of a compliance (6, 6)."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(np.asarray(compliance))))
