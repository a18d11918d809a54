"""The displacements that the elements of a part's mesh can have, and what is read off them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import CadError
from stiffkit.fea.interfaces import Port
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.settings import SolveSettings
from stiffkit.fea.threads import idle_cores, threads
from stiffkit.fea.work import one_for_each, virtual_work
from stiffkit.spatial.rotation import Array

Mask = NDArray[np.bool_]

_SMALL = 5000
"""Nodes below which one thread is as fast as more."""


class Displacements:
    """The continuous displacements of a part's mesh that are polynomials in each element.

    Each is an array (n, 3) of coefficients, n nodes by x, y, z, of hierarchical polynomials;
    several at once are (n, 3, k). All is SI, in part axes.
    """

    def __init__(self, mesh: PartMesh, laws: Sequence[Law], settings: SolveSettings) -> None:
        """Take a mesh, a law for each solid, or one for all, and orders."""
        self.mesh = mesh
        self.settings = settings
        self._laws = one_for_each(laws, int(mesh.tet_solid.max()) + 1)
        self._scalar = self.functions()
        self.space_mesh = self._scalar.mesh
        """The mesh as NGSolve has it."""
        self.n_nodes = int(self._scalar.ndof)
        self.corners = slice(0, int(self.space_mesh.nv))
        """Which nodes are the elements' corners; the others are edges, faces and insides."""
        self.n_threads = settings.threads or (1 if self.n_nodes < _SMALL else idle_cores())

    def functions(self, *, dim: int = 1, held: str = "") -> Any:
        """Return NGSolve's space of the continuous functions of these orders.

        They have ``dim`` components; ``held``: NGSolve's pattern of the faces where they vanish.
        """
        from ngsolve import H1

        order, orders = self.settings.order, self.settings.orders
        if orders is not None:
            return self.mesh.topology.space(orders, dim=dim, held=held)
        curved = self.mesh.curved if order > 1 else self.mesh.straight
        return H1(curved, order=order, dim=dim, dirichlet=held)

    def components(self, held: str = "") -> Any:
        """Return NGSolve's space of displacements: all of x, then all of y, then all of z."""
        from ngsolve import FESpace

        return FESpace([self.functions(held=held) if held else self._scalar] * 3)

    def stiffness_form(self, space: Any) -> Any:
        """Return NGSolve's form of the stiffness, not assembled, on a space of displacements."""
        from ngsolve import BilinearForm, dx

        D, d = map(gradient, space.TnT())
        form = BilinearForm(space, symmetric=True)
        form += virtual_work(self.space_mesh, self._laws, D, d) * dx
        return form

    def mass_form(self, space: Any) -> Any:
        """Return NGSolve's form of the mass, not assembled, on a space of displacements."""
        from ngsolve import BilinearForm, InnerProduct, dx

        densities = {f"s{i}": law.density for i, law in enumerate(self._laws)}
        density = self.space_mesh.MaterialCF(densities)
        u, v = map(as_vector, space.TnT())
        form = BilinearForm(space, symmetric=True)
        # Curved elements have Jacobians of order three beside the shape functions.
        form += density * InnerProduct(u, v) * dx(bonus_intorder=3)
        return form

    def on_faces(self, faces: Sequence[int]) -> Mask:
        """Return which nodes (n,) lie on faces."""
        return np.array(self._scalar.GetDofs(self._region(faces)), dtype=bool)

    def rigid_motions(self, point: Array) -> Array:
        """Return the six rigid-body displacements (n, 3, 6) of unit twists at ``point`` (3,)."""
        constant = np.zeros(self.n_nodes)
        constant[self.corners] = 1.0
        return _of_twists(constant, self._position - np.outer(constant, point))

    def reading(self, port: Port) -> Array:
        """Return the loads (n, 3, 6) of unit wrenches on a port, which read its twist too.

        What is read is the rigid motion nearest to the displacement of the port's faces, by area.
        Raises `CadError` if they are too thin to tell a rotation from.
        """
        integrals = self._integrals(port)
        gram = products(integrals, self.rigid_motions(port.point))
        size = np.sqrt(np.diag(gram))
        if np.linalg.cond(gram / np.outer(size, size)) > 1e12:
            raise CadError(
                f"interface {port.name}: its faces are too small or too thin to tell a rotation "
                "from",
                mend="add faces to it",
            )
        return np.asarray(integrals @ np.linalg.inv(gram))

    def _integrals(self, port: Port) -> Array:
        """Return the integrals (n, 3, 6) over faces of displacements times the rigid motions."""
        from ngsolve import CF, LinearForm, ds, x, y, z

        v = self._scalar.TestFunction()
        on_port = ds(definedon=self._region(port.faces), bonus_intorder=2)
        arm = (c - float(p) for c, p in zip((x, y, z), port.point, strict=True))
        found = []
        with threads(self.n_threads):
            for function in (CF(1.0), *arm):
                form = LinearForm(function * v * on_port).Assemble()
                found.append(form.vec.FV().NumPy().copy())
        return _of_twists(found[0], np.column_stack(found[1:]))

    @cached_property
    def _position(self) -> Array:
        """The coefficients (n, 3) of the position, m."""
        from ngsolve import GridFunction, x, y, z

        columns = []
        with threads(self.n_threads):
            for coordinate in (x, y, z):
                field = GridFunction(self._scalar)
                field.Set(coordinate)
                columns.append(field.vec.FV().NumPy().copy())
        return np.column_stack(columns)

    def _region(self, faces: Sequence[int]) -> Any:
        return self.space_mesh.Boundaries("|".join(f"f{face}" for face in faces))


def products(a: Array, b: Array) -> Array:
    """Return the products (j, k) of displacements or loads (n, 3, j) and (n, 3, k)."""
    rows = a.shape[0] * a.shape[1]
    return np.asarray(a.reshape(rows, a.shape[2]).T @ b.reshape(rows, b.shape[2]))


def as_vector(field: Any) -> Any:
    """Return a test, trial or grid function of NGSolve as a vector."""
    from ngsolve import CF

    return CF(tuple(parts)) if (parts := _parts(field)) else field


def gradient(field: Any) -> Any:
    """Return the gradient (3, 3) of a test, trial or grid function of NGSolve."""
    from ngsolve import CF, Grad, grad

    parts = _parts(field)
    return CF(tuple(map(grad, parts)), dims=(3, 3)) if parts else Grad(field)


def _parts(field: Any) -> Any:
    """Return the three functions that one of a composed space consists of; none of another."""
    return field if isinstance(field, list) else getattr(field, "components", ())


def _of_twists(constant: Array, arm: Array) -> Array:
    """Return what belongs to unit twists (n, 3, 6), from what belongs to 1 (n,) and r (n, 3)."""
    out = np.zeros((*arm.shape, 6))
    for j, axis in enumerate(np.eye(3)):
        out[:, j, j] = constant
        out[:, :, 3 + j] = np.cross(axis, arm)
    return out
