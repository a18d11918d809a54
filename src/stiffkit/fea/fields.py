"""Displacement fields of a solved part, in the form that `identify` takes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.superelement import PortModel
from stiffkit.fea.tets import TET_EDGES
from stiffkit.identify import Field
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array

CASES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
"""Names of the load cases: a force of 1 N, then a moment of 1 N m, along each axis."""

_CORNERS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
_TET_NODES = [
    *_CORNERS,
    *(tuple(0.5 * np.add(_CORNERS[i], _CORNERS[j])) for i, j in TET_EDGES),
]
"""Corners and middles of edges of the reference tetrahedron, in the order of the mesh's nodes."""

MANY = 50_000
"""Points on the faces of a port from which fewer are taken in each triangle."""


def face_field(model: PortModel, port: int, frame: Frame | None = None) -> Field:
    """Return how the faces of a port move under a unit force or moment along each axis on it.

    The model's ``held`` port is at rest and the others are free. Points are integration points of
    the faces and weights their shares of the area, in m^2, so that the rigid motion that fits the
    field best is the one that the solution reads there: to rounding, on curved faces if all
    elements are of one order and there are no more than `MANY` points, beyond which a lower rule is
    taken. All is SI, in the axes of ``frame``
    (``T_part_frame``; the part's if None); loads act at the port's point.
    """
    from ngsolve import CF, TRIG, IntegrationRule, specialcf, x, y, z

    body, faces = model.solver.body, model.ports[port].faces
    order, space = body.settings.order, body.space_mesh
    # The rule that the loads and readings of an average port were integrated by.
    rule = IntegrationRule(TRIG, 2 * order + 2)
    n_triangles = int(np.isin(body.mesh.triangle_face, faces).sum())
    if n_triangles * len(rule) > MANY:
        rule = IntegrationRule(TRIG, order + 1)
    at = space.MapToAllElements(rule, space.Boundaries("|".join(f"f{face}" for face in faces)))
    tangents = specialcf.JacobianMatrix(3, 2)(at).reshape(-1, 3, 2)
    density = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=1)
    share = np.tile(np.array(rule.weights), len(density) // len(rule))
    points = np.asarray(CF((x, y, z))(at))
    frame = frame or Frame()
    R = frame.rotation
    return Field(
        (points - frame.position) @ R,
        displacements(model, port, at, R) @ R,
        share * density,
        CASES,
    )


def node_field(
    model: PortModel, port: int, nodes: NDArray[np.integer], frame: Frame | None = None
) -> Field:
    """Return how some nodes of the mesh move under unit loads on a port, as other programs write.

    ``nodes`` (n,) are indices of the mesh's points: corners of elements, and for an order above
    one middles of their edges too; others are left out. Each counts alike. See `face_field` for
    loads and axes.
    """
    from ngsolve import IntegrationRule

    body = model.solver.body
    mesh, space = body.mesh, body.space_mesh
    count = 10 if body.settings.order > 1 else 4
    tets = mesh.tets[:, :count]
    rows = np.flatnonzero(np.isin(tets, nodes))
    found, first = np.unique(tets.ravel()[rows], return_index=True)
    rule = IntegrationRule(_TET_NODES[:count], [0.0] * count)
    at = space.MapToAllElements(rule, space.Materials(".*"))[rows[first]]
    frame = frame or Frame()
    R = frame.rotation
    points = (mesh.points[found] - frame.position) @ R
    return Field(points, displacements(model, port, at, R) @ R, None, CASES, found)


def face_nodes(mesh: PartMesh, faces: Sequence[int], order: int) -> NDArray[np.int64]:
    """Return the nodes (n,) of faces, as `node_field` takes them, for an order of displacement."""
    triangles = mesh.triangles[np.isin(mesh.triangle_face, faces)]
    return np.unique(triangles if order > 1 else triangles[:, :3]).astype(np.int64)


def displacements(model: PortModel, port: int, at: Any, axes: Array | None = None) -> Array:
    """Return the displacements (6, n, 3), m, part axes, under unit loads on a port.

    ``at`` are n points as NGSolve maps them on the model's mesh. Loads are along the columns of
    ``axes`` (3, 3; the part's if None), forces of 1 N first, then moments of 1 N m at the port's
    point; the model's ``held`` port is at rest.
    """
    from ngsolve import GridFunction

    body = model.solver.body
    coefficients = _unit_load_fields(model, port, np.eye(3) if axes is None else axes)
    moved = GridFunction(body.functions(dim=3))
    out = []
    for k in range(6):
        moved.vec.FV().NumPy()[:] = coefficients[:, :, k].ravel()
        out.append(np.asarray(moved(at)))
    return np.stack(out)


def _unit_load_fields(model: PortModel, port: int, axes: Array) -> Array:
    """Return the coefficients (n, 3, 6) of the displacement fields under unit loads on a port."""
    others = [i for i in range(len(model.ports)) if i != model.held]
    columns = np.concatenate([6 * i + np.arange(6) for i in others])
    loaded = 6 * others.index(port) + np.arange(6)
    twists = model.compliance[:, loaded] @ np.kron(np.eye(2), axes)
    return np.asarray(model.solver.static_fields()[:, :, columns] @ twists)
