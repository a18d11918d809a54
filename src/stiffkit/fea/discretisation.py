"""The matrices of a meshed part, whole: nothing held, nothing factorised, nothing reduced."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from stiffkit.errors import CadError
from stiffkit.fea.elasticity import SolveSettings
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.threads import idle_cores, threads
from stiffkit.fea.work import one_for_each, virtual_work
from stiffkit.spatial.rotation import Array

Mask = NDArray[np.bool_]


class Discretisation:
    """Stiffness and mass of a part's mesh as sparse matrices.

    Displacements are the coefficients (3n,) of hierarchical polynomials: those of x for all n
    nodes, then those of y, then those of z; part axes.
    """

    def __init__(self, mesh: PartMesh, laws: Sequence[Law], settings: SolveSettings) -> None:
        """Take a mesh, the orders of ``settings``, and a law for each solid, or one for all."""
        from ngsolve import FESpace

        self.mesh = mesh
        self.settings = settings
        self._laws = one_for_each(laws, int(mesh.tet_solid.max()) + 1)
        self._n_threads = idle_cores()
        self._scalar = _functions(mesh, settings)
        self._space_mesh = self._scalar.mesh
        self._space = FESpace([self._scalar] * 3)
        self.n_nodes = int(self._scalar.ndof)
        self._position = self._coordinates()

    @property
    def corners(self) -> slice:
        """Which nodes are the elements' corners; the others are edges, faces and insides."""
        return slice(0, int(self._space_mesh.nv))

    def stiffness(self) -> csr_array:
        """Return the stiffness (3n, 3n), N/m; rigid-body motions cost nothing."""
        from ngsolve import CF, BilinearForm, dx, grad

        D, d = (CF(tuple(map(grad, u)), dims=(3, 3)) for u in self._space.TnT())
        form = BilinearForm(self._space)
        form += virtual_work(self._space_mesh, self._laws, D, d) * dx
        return self._assembled(form)

    def mass(self) -> csr_array:
        """Return the mass (3n, 3n), kg."""
        from ngsolve import CF, BilinearForm, InnerProduct, dx

        densities = {f"s{i}": law.density for i, law in enumerate(self._laws)}
        density = self._space_mesh.MaterialCF(densities)
        u, v = (CF(tuple(w)) for w in self._space.TnT())
        form = BilinearForm(self._space)
        # Curved elements have Jacobians of order three beside the shape functions.
        form += density * InnerProduct(u, v) * dx(bonus_intorder=3)
        return self._assembled(form)

    def rigid_motions(self, point: Array) -> Array:
        """Return the displacements (3n, 6) of unit twists at ``point`` (3,)."""
        constant = np.zeros(self.n_nodes)
        constant[self.corners] = 1.0
        arm = self._position - np.outer(constant, point)
        out = np.zeros((3, self.n_nodes, 6))
        for j, axis in enumerate(np.eye(3)):
            out[j, :, j] = constant
            out[:, :, 3 + j] = np.cross(axis, arm).T
        return out.reshape(3 * self.n_nodes, 6)

    def on_faces(self, faces: Sequence[int]) -> Mask:
        """Return which coefficients (3n,) belong to nodes on faces."""
        region = "|".join(f"f{face}" for face in faces)
        free = np.array(_functions(self.mesh, self.settings, region).FreeDofs(), dtype=bool)
        return np.tile(~free, 3)

    def reading(self, faces: Sequence[int], point: Array) -> Array:
        """Return the rows (6, 3n) that read the mean twist of faces at ``point`` (3,).

        It is the rigid motion nearest to the displacement of the faces, by area. Raises `CadError`
        if the faces are too thin to tell a rotation from.
        """
        moments = self._moments(faces, point)
        gram = moments @ self.rigid_motions(point)
        size = np.sqrt(np.diag(gram))
        if np.linalg.cond(gram / np.outer(size, size)) > 1e12:
            raise CadError(
                f"the faces {', '.join(map(str, faces))} are too small or too thin to tell a "
                "rotation from",
                mend="add faces to the interface",
            )
        return np.asarray(np.linalg.solve(gram, moments))

    def _moments(self, faces: Sequence[int], point: Array) -> Array:
        """Return the integrals (6, 3n) over faces of the displacement times the rigid motions."""
        from ngsolve import CF, Cross, InnerProduct, LinearForm, ds, x, y, z

        region = self._space_mesh.Boundaries("|".join(f"f{face}" for face in faces))
        arm = CF((x, y, z)) - CF(tuple(float(c) for c in point))
        axes = [CF(tuple(map(float, row))) for row in np.eye(3)]
        v = CF(tuple(self._space.TestFunction()))
        rows = []
        with threads(self._n_threads):
            for field in [*axes, *(Cross(axis, arm) for axis in axes)]:
                form = LinearForm(self._space)
                form += InnerProduct(field, v) * ds(definedon=region, bonus_intorder=2)
                form.Assemble()
                rows.append(form.vec.FV().NumPy().copy())
        return np.array(rows)

    def _coordinates(self) -> Array:
        """Return the coefficients (n, 3) of the position, m."""
        from ngsolve import CF, GridFunction, x, y, z

        columns = []
        with threads(self._n_threads):
            for coordinate in (x, y, z):
                field = GridFunction(self._scalar)
                field.Set(CF(coordinate))
                columns.append(field.vec.FV().NumPy().copy())
        return np.column_stack(columns)

    def _assembled(self, form: Any) -> csr_array:
        with threads(self._n_threads):
            form.Assemble()
        values, columns, starts = form.mat.CSR()
        n = 3 * self.n_nodes
        arrays = (np.array(values), np.array(columns), np.array(starts))
        return csr_array(arrays, shape=(n, n))


def node_count(mesh: PartMesh, settings: SolveSettings) -> int:
    """Return how many nodes elements of these orders have on a mesh."""
    return int(_functions(mesh, settings).ndof)


def _functions(mesh: PartMesh, settings: SolveSettings, held: str = "") -> Any:
    """Return NGSolve's space of the continuous functions of these orders.

    ``held``: NGSolve's pattern of the faces where they vanish.
    """
    from ngsolve import H1

    if settings.orders is not None:
        return mesh.topology.space(settings.orders, held=held)
    curved = mesh.curved if settings.order > 1 else mesh.straight
    return H1(curved, order=settings.order, dirichlet=held)
