"""Superelements that somebody gives: the stiffness and mass matrices of a link from outside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stiffkit.link.checks import SYMMETRY_TOLERANCE, check_inertia
from stiffkit.link.ports import BASE, carried, in_words, places_of
from stiffkit.link.reduction import craig_bampton
from stiffkit.link.superelement import Superelement
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array, skew

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")

_RIGID = 1e-5
"""Share of the stiffness that may resist a rigid motion: matrices are printed with rounding."""
_DEFINITE = 1e-9
"""Share of the largest eigenvalue below which a negative one is rounding."""


@dataclass(frozen=True, eq=False)
class RigidBody:
    """The mass of a link as a whole."""

    mass: float
    """kg."""
    center_of_mass: Array
    """(3,), m, link axes."""
    inertia: Array
    """(3, 3), kg m^2, about the centre of mass, link axes."""


def check_superelement(K: Array, M: Array, ports: Mapping[str, Frame]) -> list[str]:
    """Return what keeps a stiffness and a mass matrix (6m + n, 6m + n), SI, from being a link's.

    The first coordinates are the twists of the base and of the other ports, in order; ``ports``
    holds T_link_port of those others.
    """
    for name, matrix in (("stiffness", K), ("mass", M)):
        faults = _faults_of_shape(name, matrix, [BASE, *ports])
        if faults:
            return faults
    if K.shape != M.shape:
        return [f"the stiffness is {len(K)}x{len(K)} and the mass {len(M)}x{len(M)}"]
    faults = [
        *_asymmetry("stiffness", K),
        *_asymmetry("mass", M),
        *_indefiniteness("stiffness", K),
        *_indefiniteness("mass", M),
    ]
    return faults or _resistance(K, ports)


def _faults_of_shape(name: str, M: Array, ports: list[str]) -> list[str]:
    if M.ndim != 2 or M.shape[0] != M.shape[1]:
        return [f"the {name} must be square and is {'x'.join(map(str, M.shape))}"]
    if len(M) < 6 * len(ports):
        return [
            f"the {name} has {len(M)} coordinates, {in_words(ports)} alone need {6 * len(ports)}"
        ]
    bad = np.argwhere(~np.isfinite(M))
    return [f"{name} entry {i + 1},{j + 1} is {M[i, j]}" for i, j in bad[:1]]


def _asymmetry(name: str, M: Array) -> list[str]:
    size = np.sqrt(np.abs(np.diag(M)))
    scale = np.outer(size, size)
    difference = np.abs(M - M.T)
    wrong = difference > SYMMETRY_TOLERANCE * np.where(scale > 0.0, scale, np.abs(M).max())
    if not wrong.any():
        return []
    i, j = np.argwhere(wrong)[0]
    return [
        f"the {name} is not symmetric: entry {i + 1},{j + 1} = {M[i, j]:.6g} and entry "
        f"{j + 1},{i + 1} = {M[j, i]:.6g}"
    ]


def _indefiniteness(name: str, M: Array) -> list[str]:
    size = np.sqrt(np.maximum(np.diag(M), 0.0))
    if (np.diag(M) < 0.0).any():
        i = int(np.argmin(np.diag(M)))
        return [f"{name} entry {i + 1},{i + 1} = {M[i, i]:.6g} is negative"]
    size[size == 0.0] = 1.0
    values = np.linalg.eigvalsh((M + M.T) / 2.0 / np.outer(size, size))
    # Printed matrices are rounded, and a stiffness has six eigenvalues that are zero.
    share = values[0] / values[-1]
    if share >= -_RIGID:
        return []
    return [f"the {name} is indefinite: an eigenvalue is {share:.2g} of the largest"]


def _resistance(K: Array, ports: Mapping[str, Frame]) -> list[str]:
    """Tell whether the stiffness resists rigid motions of the whole link, and holds its ports."""
    reduced = _statically_reduced(K, 6 + 6 * len(ports))
    size = np.sqrt(np.maximum(np.diag(reduced), 0.0))
    loose = _port_not_held(reduced[6:, 6:], size[6:])
    if loose is not None:
        return [f"with its base held the link does not hold its {list(ports)[loose]}"]
    motions = _rigid_motions(places_of(ports))
    forces = np.abs(reduced @ motions) / (np.outer(size, size) @ np.abs(motions))
    resisted = np.flatnonzero(forces.max(axis=0) > _RIGID)
    if resisted.size == 0:
        return []
    j = int(resisted[0])
    return [
        f"the stiffness resists a rigid motion of the whole link along {DIRECTIONS[j]}"
        f" ({forces[:, j].max():.2g} of its own size): the order must be"
        f" {', '.join(f'{port} x y z rx ry rz' for port in [BASE, *ports])}, others, and the"
        f" {'places of the ports' if len(ports) > 1 else f'place of the {next(iter(ports))}'}"
        " must be right"
    ]


def _port_not_held(K: Array, size: Array) -> int | None:
    """Return the index of a port that a stiffness (6p, 6p) with the base held leaves free.

    ``size`` (6p,) is the root of its diagonal.
    """
    if (size == 0.0).any():
        return int(np.argmin(size)) // 6
    values, vectors = np.linalg.eigh(K / np.outer(size, size))
    if values[0] > _DEFINITE * values[-1]:
        return None
    return int(np.argmax(np.abs(vectors[:, 0]))) // 6


def _statically_reduced(K: Array, ports: int) -> Array:
    """Return a stiffness (6m + n, 6m + n) on its first coordinates, with nothing on the others."""
    inner = slice(ports, None)
    if len(K) == ports:
        return K
    follow = np.linalg.lstsq(K[inner, inner], K[inner, :ports], rcond=None)[0]
    return np.asarray(K[:ports, :ports] - K[:ports, inner] @ follow)


def _rigid_motions(places: Array) -> Array:
    """Return the twists of all ports (6m, 6) when the link moves as one with its base."""
    return np.vstack([np.eye(6), carried(places)])


def given_superelement(K: Array, M: Array, n_ports: int = 2) -> Superelement:
    """Return the superelement of a stiffness and a mass matrix (6m + n, 6m + n), SI.

    They must be free of faults (`check_superelement`). Coordinates after those of the m ports are
    any: modes, or displacements inside.
    """
    K, M = (K + K.T) / 2.0, (M + M.T) / 2.0
    reduced = craig_bampton(K, M, np.arange(6 * n_ports), None)
    compliance = np.linalg.inv(reduced.stiffness[6:, 6:])
    return Superelement(
        (compliance + compliance.T) / 2.0,
        reduced.mode_stiffness,
        reduced.mass,
        f"given superelement of {len(K)} coordinates",
    )


def rigid_body_of(element: Superelement, places: Array) -> RigidBody:
    """Return mass, centre of mass and inertia of a superelement.

    Its ports but the base are at ``places`` (m-1, 3), m.
    """
    motions = _rigid_motions(places)
    M = motions.T @ element.mass[: len(motions), : len(motions)] @ motions
    mass = float(np.trace(M[:3, :3])) / 3.0
    if mass <= 0.0:
        return RigidBody(0.0, np.zeros(3), np.zeros((3, 3)))
    moment = (M[3:, :3] - M[:3, 3:]) / 2.0
    center = np.array([moment[2, 1], moment[0, 2], moment[1, 0]]) / mass
    inertia = M[3:, 3:] + mass * skew(center) @ skew(center)
    return RigidBody(mass, center, np.asarray((inertia + inertia.T) / 2.0))


def doubts_superelement(element: Superelement, places: Array) -> list[str]:
    """Return what looks wrong in the mass of a superelement free of faults.

    Its ports but the base are at ``places`` (m-1, 3), m.
    """
    body = rigid_body_of(element, places)
    if body.mass == 0.0:
        return ["the superelement has no mass"]
    return check_inertia(body.mass, body.inertia)
