"""The matrices of a meshed part, whole: nothing held, nothing factorised, nothing reduced."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from stiffkit.fea.displacement import Displacements, Mask
from stiffkit.fea.interfaces import Port
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.settings import SolveSettings
from stiffkit.fea.threads import threads
from stiffkit.spatial.rotation import Array


class Discretisation:
    """Stiffness and mass of a part's mesh as sparse matrices.

    Displacements are the coefficients (3n,) of `Displacements`: those of x for all n nodes, then
    those of y, then those of z; part axes.
    """

    def __init__(self, mesh: PartMesh, laws: Sequence[Law], settings: SolveSettings) -> None:
        """Take a mesh, the orders of ``settings``, and a law for each solid, or one for all."""
        self.mesh = mesh
        self._nodal = Displacements(mesh, laws, settings)
        self.n_nodes = self._nodal.n_nodes
        self.corners = self._nodal.corners

    def stiffness(self) -> csr_array:
        """Return the stiffness (3n, 3n), N/m; rigid-body motions cost nothing."""
        return self._assembled(self._nodal.stiffness_form(self._nodal.components()))

    def mass(self) -> csr_array:
        """Return the mass (3n, 3n), kg."""
        return self._assembled(self._nodal.mass_form(self._nodal.components()))

    def rigid_motions(self, point: Array) -> Array:
        """Return the displacements (3n, 6) of unit twists at ``point`` (3,)."""
        return _in_a_row(self._nodal.rigid_motions(point))

    def on_faces(self, faces: Sequence[int]) -> Mask:
        """Return which coefficients (3n,) belong to nodes on faces."""
        return np.tile(self._nodal.on_faces(faces), 3)

    def reading(self, port: Port) -> Array:
        """Return the rows (6, 3n) that read the twist of a port; see `Displacements.reading`."""
        return _in_a_row(self._nodal.reading(port)).T

    def _assembled(self, form: Any) -> csr_array:
        with threads(self._nodal.n_threads):
            form.Assemble()
        values, columns, starts = form.mat.CSR()
        n = 3 * self.n_nodes
        arrays = (np.array(values), np.array(columns), np.array(starts))
        return csr_array(arrays, shape=(n, n))


def _in_a_row(fields: Array) -> Array:
    """Return displacements (3n, k), of displacements (n, 3, k)."""
    return np.ascontiguousarray(fields.transpose(1, 0, 2)).reshape(-1, fields.shape[2])


def node_count(mesh: PartMesh, settings: SolveSettings) -> int:
    """Return how many nodes elements of these orders have on a mesh."""
    return mesh.topology.node_count(settings.orders_of(len(mesh.tets)))
