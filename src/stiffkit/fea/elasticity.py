"""Linear elasticity on the mesh of a part: assembled once, factorised once, any number of loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.displacement import Displacements, as_vector, gradient
from stiffkit.fea.material import Law
from stiffkit.fea.memory import Fill, must_iterate
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.settings import SolveSettings
from stiffkit.fea.threads import threads
from stiffkit.fea.work import virtual_work
from stiffkit.spatial.rotation import Array

RESIDUAL = 1e-6
"""The relative residual of a direct solve above which the factorisation counts as failed."""

_SOLVED = 1e-10
"""The relative residual that needs no correction: compliances are in error by its square."""

_REFINEMENTS = 3


class Elasticity(Displacements):
    """Stiffness and mass of a part's mesh, with whole faces or single components held."""

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
        super().__init__(mesh, laws, settings)
        self._held = "|".join(f"f{face}" for face in held_faces)
        self._pin_faces = tuple(pin_faces)
        self._iterative = must_iterate(
            self.n_nodes, settings.solver, settings.memory, settings.known
        )
        # Blocks of 3 x 3 are faster, but single components cannot be held in them, and NGSolve's
        # preconditioners do not know them.
        self._blocked = bool(self._held) and not self._iterative
        self._set_up()

    def _set_up(self) -> None:
        from ngsolve import Preconditioner

        held = self._held
        self._space = self.functions(dim=3, held=held) if self._blocked else self.components(held)
        self._free = self._space.FreeDofs()
        if not held:
            self._pin(self._free)
        self._mass: Any = None
        self._form = self.stiffness_form(self._space)
        with threads(self.n_threads):
            self._preconditioner = Preconditioner(self._form, "bddc") if self._iterative else None
            self._form.Assemble()
            self._inverse = self._invert()

    @property
    def n_unknowns(self) -> int:
        """How many displacement components are free."""
        return int(self._free.NumSet()) * (3 if self._blocked else 1)

    def apply_stiffness(self, fields: Array) -> Array:
        """Return the forces (n, 3, k) of displacement fields (n, 3, k)."""
        return self._apply(self._form.mat, fields)

    def apply_mass(self, fields: Array) -> Array:
        """Return the mass matrix times displacement fields (n, 3, k)."""
        if self._mass is None:
            self._mass = self.mass_form(self._space)
            with threads(self.n_threads):
                self._mass.Assemble()
        return self._apply(self._mass.mat, fields)

    def solve(self, loads: Array) -> Array:
        """Return the displacement fields (n, 3, k) under loads (n, 3, k); what is held stays.

        Raises `CadError` if the solution does not satisfy its equations.
        """
        from ngsolve import Projector

        projector = Projector(self._free, True)
        load, residual = self._vector(), self._vector()
        out = np.empty_like(loads)
        with threads(self.n_threads):
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

        orders = self.settings.orders_of(len(self.mesh.tets))
        lower = [self.mesh.topology.space(np.maximum(orders - k, 1), dim=3) for k in (1, 2)]
        contents = [CF(0.0), CF(0.0)]
        with threads(self.n_threads):
            for k in range(fields.shape[2]):
                finer = GridFunction(self._space)
                self._fill(finer.vec, fields[:, :, k])
                for i, space in enumerate(lower):
                    coarser = GridFunction(space)
                    coarser.Set(as_vector(finer))
                    D = gradient(finer) - gradient(coarser)
                    contents[i] += virtual_work(self.space_mesh, self._laws, D, D)
                    finer = coarser
            return np.array([Integrate(c, self.space_mesh, element_wise=True) for c in contents])

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

    def _pin(self, free: Any) -> None:
        """Hold six of the free components, in place, so that no rigid-body motion is left."""
        from scipy.linalg import qr

        nodes = np.flatnonzero(self.on_faces(self._pin_faces)[self.corners])
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
        with threads(self.n_threads):
            for k in range(fields.shape[2]):
                self._fill(source, fields[:, :, k])
                image.data = matrix * source
                out[:, :, k] = self._array(image)
        return out
