"""The simplified model of vibration: the drives yield, and the platform alone has mass.

``det(J^-T K J^-1 - omega^2 M) = 0`` (Briot et al. 2009, eq. 12, where J and its transpose are
printed in each other's place), which is asked here of the compliance ``k = J K^-1 J^T``: the
eigenvalues of ``k M`` are ``1/omega^2``. As many modes exist as there are directions in which the
drives let the platform's mass yield, so robots with fewer than six drives need no special care.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend
from stiffkit.errors import LinkError
from stiffkit.kinematics import SpanningTree
from stiffkit.link.superelement import rigid_mass
from stiffkit.robot import BASE, Link, Robot
from stiffkit.spatial import Frame, exp_rotation, shift_stiffness
from stiffkit.vibration.bodies import Bodies
from stiffkit.vibration.modes import ModalModel
from stiffkit.vibration.tracking import ModeVectors

Array = NDArray[np.float64]

_RIGID = 1e-12
"""Eigenvalues of a unit-free compliance below this share of the largest are rounding."""

_MASSLESS = 1e-14
"""Eigenvalues of compliance times mass below this share of the largest are no modes."""


def platform_bodies(robot: Robot) -> dict[str, Frame]:
    """Return T_tool_body of the rigid bodies that carry the tool: its own and those fixed to it."""
    tool = robot.tool
    found: dict[str, Frame] = {}
    waiting = [(tool.body, tool.port, tool.T_body_tool.inverse)]
    while waiting:
        body, port, T_tool_body = waiting.pop()
        if body in found or body == BASE:
            continue
        elastic = robot.links[body].compliance is not None
        if not elastic:
            found[body] = T_tool_body
        elif body != tool.body or port != tool.port:
            # Legs have no mass here; only what is fixed to the tool's own end belongs to it.
            continue
        for joint in robot.joints.values():
            if joint.kind != "fixed":
                continue
            if joint.from_body == body and (not elastic or joint.from_port == port):
                step = joint.T_from_joint @ joint.T_to_joint.inverse
                waiting.append((joint.to_body, joint.to_port, T_tool_body @ step))
            if joint.to_body == body and (not elastic or joint.to_port == port):
                step = joint.T_to_joint @ joint.T_from_joint.inverse
                waiting.append((joint.from_body, joint.from_port, T_tool_body @ step))
    return found


def platform_mass(robot: Robot) -> Array:
    """Return the platform's mass matrix (6, 6), SI, at the tool point, in the tool's axes.

    It holds the tool's point mass and the rigid bodies that carry the tool. Raises LinkError if
    none of them has mass.
    """
    M = np.zeros((6, 6))
    M[:3, :3] = (robot.tool.mass or 0.0) * np.eye(3)
    for name, T_tool_body in platform_bodies(robot).items():
        link = robot.links[name]
        if link.mass:
            # A mass matrix goes from frame to frame as a stiffness does.
            M += shift_stiffness(_body_mass(link, link.mass), T_tool_body)
    if not M.any():
        raise LinkError(
            f"{robot.name} has no mass at its tool, and the simplified model knows no other",
            mend="give the tool a mass, as in  tool: {at: ..., mass: 5 kg},  or its rigid body;"
            " or take the refined model",
        )
    return M


def platform(robot: Robot) -> Bodies:
    """Return the bodies of the simplified model. Raises LinkError if none of them has mass."""
    platform_mass(robot)
    links = [robot.links[name] for name in platform_bodies(robot)]
    rigid = {link.name: _body_mass(link, link.mass) for link in links if link.mass}
    return Bodies(rigid, {}, robot.tool.mass or 0.0)


def _body_mass(link: Link, mass: float) -> Array:
    center = np.zeros(3) if link.center_of_mass is None else link.center_of_mass
    return rigid_mass(mass, center, link.inertia)


def simplified_modes(
    tree: SpanningTree, length: float, *, backend: Backend | None = None
) -> ModalModel:
    """Return the simplified model of a mechanism, with mode shapes and energies.

    ``length`` (m) is one that is typical of the robot. Raises LinkError if its platform has no
    mass.
    """
    return ModalModel(
        tree, length, bodies=platform(tree.robot), elasticity="simplified", backend=backend
    )


def simplified_frequencies(lower: Array, tool: Array, mass: Array, length: float) -> Array:
    """Return the frequencies (6, N), Hz, ascending, of N postures; NaN where there is no mode.

    Args:
        lower: (21, N), lower triangles of the compliances of the simplified stiffness model, row
            by row; SI, world axes, at the tool point; NaN where a posture has none.
        tool: (6, N), tool poses: position (m) and rotation vector.
        mass: (6, 6), of `platform_mass`.
        length: m, typical of the robot.
    """
    known, shapes = _weighted(lower, tool, mass, length)
    frequencies = np.full((6, lower.shape[1]), np.nan)
    frequencies[:, known] = _frequencies_of(np.linalg.svd(shapes, compute_uv=False))
    return frequencies


def simplified_mode_vectors(lower: Array, tool: Array, mass: Array, length: float) -> ModeVectors:
    """Return the modes of N postures; arguments as for `simplified_frequencies`.

    Their vectors are the platform's twists in its own axes, weighted by the root of its mass.
    """
    known, shapes = _weighted(lower, tool, mass, length)
    frequencies = np.full((6, lower.shape[1]), np.nan)
    vectors = np.zeros((lower.shape[1], 6, 6))
    U, singular, _ = np.linalg.svd(shapes)
    frequencies[:, known] = _frequencies_of(singular)
    vectors[known] = np.swapaxes(U, 1, 2)
    vectors[np.isnan(frequencies.T)] = 0.0
    return ModeVectors(frequencies, vectors)


def _weighted(
    lower: Array, tool: Array, mass: Array, length: float
) -> tuple[NDArray[np.intp], Array]:
    """Return which postures (n,) have an answer, and matrices (n, 6, 6) that hold their modes.

    The singular values are 1/omega, and the left singular vectors the twists of the platform in
    tool axes, weighted by the root of the mass.
    """
    known = np.flatnonzero(np.isfinite(lower).all(axis=0) & np.isfinite(tool).all(axis=0))
    unit = np.array([length] * 3 + [1.0] * 3)
    k = _full(lower[:, known]) / np.outer(unit, unit)
    values, vectors = np.linalg.eigh(k)
    values = np.where(values > _RIGID * values[:, -1:], values, 0.0)
    # k = G G^T and M = B^T B.
    G = vectors * np.sqrt(values)[:, None, :]
    masses, axes = np.linalg.eigh(unit[:, None] * mass * unit)
    B = np.sqrt(np.maximum(masses, 0.0))[:, None] * axes.T
    return known, B @ _turned_back(tool[3:, known], G)


def _frequencies_of(singular: NDArray[np.floating]) -> Array:
    """Return the frequencies (6, n), Hz, of singular values 1/omega (n, 6), largest first."""
    exists = singular > np.sqrt(_MASSLESS) * singular[:, :1]
    omega = np.where(exists, 1.0 / np.where(exists, singular, 1.0), np.nan)
    return np.asarray(omega.T / (2.0 * np.pi))


def _full(lower: Array) -> Array:
    """Return symmetric matrices (N, 6, 6) of lower triangles (21, N)."""
    rows, columns = np.tril_indices(6)
    full = np.empty((lower.shape[1], 6, 6))
    full[:, rows, columns] = lower.T
    full[:, columns, rows] = lower.T
    return full


def _turned_back(rotation_vectors: Array, G: Array) -> Array:
    """Return twists in the columns of G (N, 6, m), world axes, in tool axes."""
    back = np.array([exp_rotation(w).T for w in rotation_vectors.T]).reshape(-1, 3, 3)
    return np.concatenate([back @ G[:, :3], back @ G[:, 3:]], axis=1)
