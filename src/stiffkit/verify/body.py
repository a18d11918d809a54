"""Bodies of a robot as they stand in the whole system: meshed parts, and rigid ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, csr_array

from stiffkit.fea import Port
from stiffkit.fea.discretisation import Discretisation
from stiffkit.fea.rigid import check_apart
from stiffkit.link.superelement import rigid_mass
from stiffkit.robot import Link
from stiffkit.spatial import twist_shift
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Reading:
    """The twist of a port, from the coordinates of its body."""

    point: Array
    """(3,), m, body axes."""
    rows: csr_array
    """(6, n): the twist at the point, body axes."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body in axes of its own, by n coordinates: SI, the same at every posture.

    Those of a meshed part are the coefficients of its nodes and, in place of the nodes of each
    rigid port, the port's twist at its point. Those of a rigid body are its twist at its origin.
    """

    stiffness: csr_array
    """(n, n); rigid-body motions cost nothing."""
    mass: csr_array
    """(n, n)."""
    readings: Mapping[str, Reading]
    """Of each port."""
    at_origin: Array
    """(n, 6), coordinates of unit twists of the whole body at its origin."""
    weak: Array
    """(n,), stiffnesses of springs to the ground that would hold the body, translations with 1 N/m
    in all; rotations with 1 N m/rad times the square of its size."""
    rigidity: float
    """N/m, what a single node of it is held with by its neighbours; 0 if it is rigid."""

    @property
    def size(self) -> int:
        """How many coordinates it has."""
        return int(self.stiffness.shape[0])


def rigid_body(link: Link) -> Body:
    """Return a rigid link, in link axes."""
    center = np.zeros(3) if link.center_of_mass is None else link.center_of_mass
    mass = rigid_mass(link.mass or 0.0, center, link.inertia if link.mass else None)
    reach = max((float(np.linalg.norm(port.position)) for port in link.ports.values()), default=0)
    return Body(
        stiffness=csr_array((6, 6)),
        mass=csr_array(mass),
        readings={
            name: Reading(port.position, csr_array(twist_shift(port.position)))
            for name, port in link.ports.items()
        },
        at_origin=np.eye(6),
        weak=np.repeat([1.0, reach**2 or 1.0], 3),
        rigidity=0.0,
    )


def meshed_body(mesh: Discretisation, ports: Sequence[Port]) -> Body:
    """Return a meshed part, in part axes. Raises `CadError` if rigid ports touch each other."""
    on_port = {port.name: mesh.on_faces(port.faces) for port in ports if port.is_rigid}
    check_apart(on_port)
    carried = np.logical_or.reduce([np.zeros(3 * mesh.n_nodes, dtype=bool), *on_port.values()])
    free = np.flatnonzero(~carried)
    rigid = [port for port in ports if port.is_rigid]
    fields = [np.where(on_port[p.name][:, None], mesh.rigid_motions(p.point), 0) for p in rigid]
    carry = csr_array(np.hstack([np.zeros((3 * mesh.n_nodes, 0)), *fields]))
    K = mesh.stiffness()
    diagonal = K.diagonal().reshape(3, -1)[:, mesh.corners]
    at_origin = np.vstack(
        [mesh.rigid_motions(np.zeros(3))[free], *(twist_shift(p.point) for p in rigid)]
    )
    size = float(np.ptp(mesh.mesh.points, axis=0).max())
    return Body(
        stiffness=_carried(K, free, carry),
        mass=_carried(mesh.mass(), free, carry),
        readings=_readings(mesh, ports, free, carry),
        at_origin=at_origin,
        weak=_weak(mesh, free, len(rigid), size),
        rigidity=float(np.median(diagonal)),
    )


def _carried(K: csr_array, free: NDArray[np.intp], carry: csr_array) -> csr_array:
    """Return a matrix (3n, 3n) for the free coefficients and the twists of rigid ports."""
    rows = K[free]
    mixed = rows @ carry
    blocks = [[rows[:, free], mixed], [mixed.T, carry.T @ (K @ carry)]]
    return csr_array(block_array(blocks, format="csr")) if carry.shape[1] else rows[:, free]


def _readings(
    mesh: Discretisation, ports: Sequence[Port], free: NDArray[np.intp], carry: csr_array
) -> dict[str, Reading]:
    readings = {}
    n, at = free.size + carry.shape[1], free.size
    for port in ports:
        if port.is_rigid:
            rows = np.zeros((6, n))
            rows[:, at : at + 6] = np.eye(6)
            at += 6
        else:
            whole = mesh.reading(port)
            rows = np.hstack([whole[:, free], whole @ carry])
        readings[port.name] = Reading(port.point, csr_array(rows))
    return readings


def _weak(mesh: Discretisation, free: NDArray[np.intp], n_rigid: int, size: float) -> Array:
    """Return springs on one of the rigid ports or, if there is none, on the corners of the mesh."""
    weak = np.zeros(free.size + 6 * n_rigid)
    if n_rigid:
        weak[free.size : free.size + 6] = np.repeat([1.0, size**2], 3)
        return weak
    corners = np.zeros((3, mesh.n_nodes))
    corners[:, mesh.corners] = 1.0 / mesh.corners.stop
    return np.asarray(corners.ravel()[free])
