"""Linear elasticity on the mesh of a part: assembled once, factorised once, any number of loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import CadError
from stiffkit.fea.material import Law
from stiffkit.fea.memory import Fill, must_iterate
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.orders import Orders
from stiffkit.fea.threads import idle_cores, threads
from stiffkit.fea.work import one_for_each, virtual_work
from stiffkit.spatial.rotation import Array

Mask = NDArray[np.bool_]

RESIDUAL = 1e-6
"""The relative residual of a direct solve above which the factorisation counts as failed."""

_SOLVED = 1e-10
"""The relative residual that needs no correction: compliances are in error by its square."""

_REFINEMENTS = 3

_SMALL = 5000
"""Nodes below which one thread is as fast as more."""


@dataclass(frozen=True)
class SolveSettings:
    """How a discretisation is solved."""

    order: int = 3
    """Polynomial order of the displacement."""
    orders: Orders | None = field(default=None, compare=False, repr=False)
    """Orders (e,) of the elements, on curved ones, where they differ; ``order`` is the highest."""
    threads: int | None = None
    """As many as cores are idle if None: on busy cores more threads are slower than one."""
    solver: str = "auto"
    """direct, iterative, or auto: direct where it fits into memory."""
    memory: float | None = None
    """bytes that the solve may take; most of what is free if None."""
    known: Fill | None = field(default=None, compare=False, repr=False)
    """What a factor of such a mesh was seen to take, if one was."""


class Elasticity:
    """Stiffness and mass of a part's mesh, with whole faces or single components held.

    Displacement fields are arrays (n, 3) of coefficients, n nodes by x, y, z, of hierarchical
    polynomials; several at once are (n, 3, k).
    """

    def __init__(
        self,
        mesh: PartMesh,
        laws: Sequence[Law],
        settings: SolveSettings,
        *,
        held_faces: Sequence[int] = (),
        pin_faces: Sequence[int] = (),
    ) -> None:
        """Assemble and factorise.

        ``laws``: one for each solid, or one for all. ``held_faces`` do not move at all. If there
        are none, six components at corners of ``pin_faces`` are held, just enough to stop the
        rigid-body motions: then loads must be in equilibrium. Raises `CadError` if the memory does
        not suffice.
        """
        self.mesh = mesh
        self.settings = settings
        self._laws = one_for_each(laws, int(mesh.tet_solid.max()) + 1)
        is_curved = settings.order > 1 or settings.orders is not None
        self._space_mesh = mesh.curved if is_curved else mesh.straight
        self._held = "|".join(f"f{face}" for face in held_faces)
        self._pin_faces = tuple(pin_faces)
        # Blocks of 3 x 3 are faster, but single components cannot be held in them, and NGSolve's
        # preconditioners do not know them.
        self._blocked = True
        self.n_nodes = int(self._make_space().ndof)
        self._n_threads = settings.threads or (1 if self.n_nodes < _SMALL else idle_cores())
        self._iterative = must_iterate(
            self.n_nodes, settings.solver, settings.memory, settings.known
        )
        self._blocked = bool(self._held) and not self._iterative
        self._set_up()

    def functions(self, *, dim: int = 1, held: str = "") -> Any:
        """Return NGSolve's space of the functions with ``dim`` components, of these orders."""
        from ngsolve import H1

        if self.settings.orders is None:
            return H1(self._space_mesh, order=self.settings.order, dim=dim, dirichlet=held)
        return self.mesh.topology.space(self.settings.orders, dim=dim, held=held)

    def _make_space(self) -> Any:
        from ngsolve import FESpace

        if self._blocked:
            return self.functions(dim=3, held=self._held)
        return FESpace([self.functions(held=self._held)] * 3)

    def _vector_of(self, field: Any) -> Any:
        """Return a test, trial or grid function as a vector."""
        from ngsolve import CF

        return CF(tuple(parts)) if (parts := _parts(field)) else field

    def _gradient(self, field: Any) -> Any:
        """Return the gradient (3, 3) of a test, trial or grid function."""
        from ngsolve import CF, Grad, grad

        parts = _parts(field)
        return CF(tuple(map(grad, parts)), dims=(3, 3)) if parts else Grad(field)

    def _set_up(self) -> None:
        from ngsolve import BilinearForm, Preconditioner, dx

        space = self._space = self._make_space()
        self._position, self._constant = self._coordinates()
        if not self._held:
            self._pin(space.FreeDofs())
        self._free = space.FreeDofs()
        self._mass: Any = None
        u, v = space.TnT()
        self._form = BilinearForm(space, symmetric=True, condense=False)
        work = virtual_work(self._space_mesh, self._laws, self._gradient(u), self._gradient(v))
        self._form += work * dx
        with threads(self._n_threads):
            self._preconditioner = Preconditioner(self._form, "bddc") if self._iterative else None
            self._form.Assemble()
            self._inverse = self._invert()

    @property
    def n_unknowns(self) -> int:
        """How many displacement components are free."""
        return int(self._free.NumSet()) * (3 if self._blocked else 1)

    def rigid_motions(self, point: Array) -> Array:
        """Return the six rigid-body displacement fields (n, 3, 6) for twists at ``point`` (3,)."""
        out = np.zeros((self.n_nodes, 3, 6))
        arm = self._position - np.outer(self._constant, point)
        for j, axis in enumerate(np.eye(3)):
            out[:, j, j] = self._constant
            out[:, :, 3 + j] = np.cross(axis, arm)
        return out

    def on_faces(self, faces: Sequence[int]) -> Mask:
        """Return which nodes (n,) lie on faces."""
        # NGSolve numbers the nodes alike, whatever the dimension of the values.
        space = self.functions(held="|".join(f"f{face}" for face in faces))
        return ~np.array(space.FreeDofs(), dtype=bool)

    def face_functionals(self, faces: Sequence[int], point: Array) -> Array:
        """Return the functionals (n, 3, 6): integrals over faces of u times the rigid motions.

        The rigid motions are those of `rigid_motions`; not normalised.
        """
        from ngsolve import CF, Cross, InnerProduct, LinearForm, ds, x, y, z

        region = self._space_mesh.Boundaries("|".join(f"f{face}" for face in faces))
        arm = CF((x, y, z)) - CF(tuple(float(c) for c in point))
        axes = [CF(tuple(map(float, row))) for row in np.eye(3)]
        v = self._vector_of(self._space.TestFunction())
        columns = []
        with threads(self._n_threads):
            for field in [*axes, *(Cross(axis, arm) for axis in axes)]:
                form = LinearForm(self._space)
                form += InnerProduct(field, v) * ds(definedon=region, bonus_intorder=2)
                form.Assemble()
                columns.append(self._array(form.vec))
        return np.stack(columns, axis=2)

    def apply_stiffness(self, fields: Array) -> Array:
        """Return the forces (n, 3, k) of displacement fields (n, 3, k)."""
        return self._apply(self._form.mat, fields)

    def apply_mass(self, fields: Array) -> Array:
        """Return the mass matrix times displacement fields (n, 3, k)."""
        if self._mass is None:
            self._mass = self._assemble_mass()
        return self._apply(self._mass.mat, fields)

    def solve(self, loads: Array) -> Array:
        """Return the displacement fields (n, 3, k) under loads (n, 3, k); what is held stays.

        Raises `CadError` if the solution does not satisfy its equations.
        """
        from ngsolve import Projector

        projector = Projector(self._free, True)
        load, residual = self._vector(), self._vector()
        out = np.empty_like(loads)
        with threads(self._n_threads):
            for k in range(loads.shape[2]):
                self._fill(load, loads[:, :, k])
                load.data = projector * load
                solution = self._vector()
                solution[:] = 0.0
                residual.data = load
                best = np.inf
                for _ in range(_REFINEMENTS):
                    correction = (self._inverse * residual).Evaluate()
                    solution.data += correction
                    residual.data = projector * (load - self._form.mat * solution)
                    error = residual.Norm() / max(load.Norm(), 1e-300)
                    # The residual stops falling at rounding, which is higher for slender parts.
                    if error < _SOLVED or error > 0.3 * best:
                        best = min(best, error)
                        break
                    best = error
                if not best <= RESIDUAL:
                    return self._solve_otherwise(loads, best)
                out[:, :, k] = self._array(solution)
        return out

    @property
    def fill(self) -> Fill | None:
        """What the factor takes, None if there is none."""
        if self._inverse is None or self._iterative:
            return None
        return Fill(self.n_nodes, self._inverse.nze * (1.0 if self._blocked else 1.0 / 9.0))

    def release(self) -> None:
        """Give the memory of matrix and factor back; nothing can be solved any more."""
        self._form = self._inverse = self._preconditioner = self._mass = None

    @property
    def is_released(self) -> bool:
        """Whether matrix and factor were given back."""
        return self._form is None

    def contents(self, fields: Array) -> Array:
        """Return twice the energies (2, e), J, of what orders hold in the elements, summed over k.

        First what the element's highest order p adds to the approximation of ``fields`` (n, 3, k)
        by order p - 1, then what that adds to the one by p - 2.
        """
        from ngsolve import CF, GridFunction, Integrate

        orders = np.full(len(self.mesh.tets), self.settings.order)
        if self.settings.orders is not None:
            orders = self.settings.orders
        lower = [self.mesh.topology.space(np.maximum(orders - k, 1), dim=3) for k in (1, 2)]
        contents = [CF(0.0), CF(0.0)]
        with threads(self._n_threads):
            for k in range(fields.shape[2]):
                finer = GridFunction(self._space)
                self._fill(finer.vec, fields[:, :, k])
                for i, space in enumerate(lower):
                    coarser = GridFunction(space)
                    coarser.Set(self._vector_of(finer))
                    D = self._gradient(finer) - self._gradient(coarser)
                    contents[i] += virtual_work(self._space_mesh, self._laws, D, D)
                    finer = coarser
            return np.array([Integrate(c, self._space_mesh, element_wise=True) for c in contents])

    def _solve_otherwise(self, loads: Array, residual: float) -> Array:
        """Solve again with scalar blocks, after the factorisation in 3 x 3 blocks has failed.

        NGSolve's sparsecholesky gives, now and then, wrong factors of matrices of small blocks.
        """
        if not self._blocked or self._preconditioner is not None:
            raise CadError(
                f"the equations could not be solved: a residual of {residual:.1e} is left",
                mend="check the mesh for very thin elements; try another mesh size or order",
            )
        self._blocked = False
        self._set_up()
        return self.solve(loads)

    def _assemble_mass(self) -> Any:
        from ngsolve import BilinearForm, InnerProduct, dx

        densities = {f"s{i}": law.density for i, law in enumerate(self._laws)}
        density = self._space_mesh.MaterialCF(densities)
        u, v = map(self._vector_of, self._space.TnT())
        form = BilinearForm(self._space, symmetric=True)
        # Curved elements have Jacobians of order three beside the shape functions.
        form += density * InnerProduct(u, v) * dx(bonus_intorder=3)
        with threads(self._n_threads):
            form.Assemble()
        return form

    def _coordinates(self) -> tuple[Array, Array]:
        """Return the coefficients (n, 3) of the position, m, and those (n,) of the constant one."""
        from ngsolve import CF, GridFunction, x, y, z

        field = GridFunction(self.functions(dim=3))
        with threads(self._n_threads):
            field.Set(CF((x, y, z)))
        constant = np.zeros(self.n_nodes)
        constant[: self._space_mesh.nv] = 1.0
        return field.vec.FV().NumPy().reshape(-1, 3).copy(), constant

    def _pin(self, free: Any) -> None:
        """Hold six of the free components, in place, so that no rigid-body motion is left."""
        from scipy.linalg import qr

        nodes = np.flatnonzero(self.on_faces(self._pin_faces)[: self._space_mesh.nv])
        rigid = self.rigid_motions(self._position[nodes].mean(axis=0))[nodes]
        size = float(np.ptp(self._position[nodes], axis=0).max())
        # The three rotations become as large as the translations.
        scaled = rigid.reshape(-1, 6) / np.repeat([1.0, size], 3)
        chosen = qr(scaled.T, mode="r", pivoting=True)[1][:6]
        for row in chosen:
            node, axis = divmod(int(row), 3)
            free.Clear(int(axis * self.n_nodes + nodes[node]))

    def _invert(self) -> Any:
        if self._preconditioner is None:
            return self._form.mat.Inverse(self._free, inverse="sparsecholesky")
        from ngsolve.krylovspace import CGSolver

        return CGSolver(self._form.mat, self._preconditioner.mat, tol=1e-10, maxiter=2000)

    def _vector(self) -> Any:
        return self._form.mat.CreateColVector()

    def _array(self, vector: Any) -> Array:
        flat = vector.FV().NumPy()
        if self._blocked:
            return np.array(flat.reshape(-1, 3))
        return np.array(flat.reshape(3, -1).T)

    def _fill(self, vector: Any, field: Array) -> None:
        vector.FV().NumPy()[:] = (field if self._blocked else field.T).reshape(-1)

    def _apply(self, matrix: Any, fields: Array) -> Array:
        source, image = matrix.CreateColVector(), matrix.CreateColVector()
        out = np.empty_like(fields)
        with threads(self._n_threads):
            for k in range(fields.shape[2]):
                self._fill(source, fields[:, :, k])
                image.data = matrix * source
                out[:, :, k] = self._array(image)
        return out


def _parts(field: Any) -> Any:
    """Return the three functions that one of a composed space consists of; none of another."""
    return field if isinstance(field, list) else getattr(field, "components", ())
