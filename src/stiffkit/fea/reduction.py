"""Static condensation of a mesh on its ports, and the modes with all ports held."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stiffkit.fea.displacement import products
from stiffkit.fea.elasticity import Elasticity
from stiffkit.fea.interfaces import Port
from stiffkit.fea.lanczos import lowest_modes
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.rigid import check_apart, rehold
from stiffkit.fea.settings import SolveSettings
from stiffkit.spatial.rotation import Array
from stiffkit.spatial.twist import twist_shift


class Reduction:
    """Static condensation of a mesh on its ports.

    Rigid ports are held or moved as one body. Loads on average ports are spread so that they are
    the energy-conjugate of the reading: with the functionals L of the port's rigid motions, the
    reading is G^-1 L^T u, with G so that rigid motions are read exactly, and the load is L G^-1 w.
    This is the area-weighted linear regression of the displacement, and the traction
    (F + (J^-1 M) x r) / A.
    """

    def __init__(
        self,
        mesh: PartMesh,
        ports: Sequence[Port],
        laws: Sequence[Law],
        settings: SolveSettings,
        held: int = 0,
    ) -> None:
        """Assemble, factorise and solve for all ports.

        ``held`` is the port whose motion the others' is relative to. If it is an average one and
        others are rigid, a rigid one takes its place in the solve. Raises `CadError` if rigid ports
        touch each other.
        """
        self.ports = tuple(ports)
        self._asked = held
        rigid = [i for i, port in enumerate(self.ports) if port.is_rigid]
        self._ref = held if self.ports[held].is_rigid or not rigid else rigid[0]
        self._has_rigid = bool(rigid)
        self._others = [i for i in range(len(self.ports)) if i != self._ref]
        self._moved = [i for i in self._others if self.ports[i].is_rigid]
        self._loaded = [i for i in self._others if not self.ports[i].is_rigid]
        faces = [face for i in rigid for face in self.ports[i].faces]
        self.body = Elasticity(
            mesh, laws, settings, held_faces=faces, pin_faces=self.ports[self._ref].faces
        )
        check_apart({ports[i].name: self.body.on_faces(ports[i].faces) for i in rigid})
        self._solve()

    def _solve(self) -> None:
        """Find the motions under unit displacements of rigid and unit loads on average ports."""
        body = self.body
        X = {i: self._carry(i) for i in self._others}
        readings = [body.reading(self.ports[i]) for i in self._loaded]
        if not self._has_rigid:
            self._ref_reading = body.reading(self.ports[self._ref])
            readings = [
                R - self._ref_reading @ X[i].T for i, R in zip(self._loaded, readings, strict=True)
            ]
        shape = (body.n_nodes, 3, 0)
        self._R = np.concatenate([np.zeros(shape), *readings], axis=2)
        self._Y = body.solve(self._R)
        raw = products(self._R, self._Y)
        # Equal to the energy, symmetric, and second-order in the solver's error.
        C = raw + raw.T - products(self._Y, body.apply_stiffness(self._Y))
        self._C = 0.5 * (C + C.T)
        scale = np.sqrt(np.abs(np.diag(self._C)))
        self.asymmetry = float(np.max(np.abs(raw - raw.T) / np.outer(scale, scale), initial=0.0))
        self._U = self._moved_fields()
        self._G = products(self._R, self._U)
        S = products(self._U, body.apply_stiffness(self._U))
        self._S = 0.5 * (S + S.T)

    def _moved_fields(self) -> Array:
        """Return the fields (n, 3, 6r) of unit twists of the moved rigid ports."""
        fields = [np.zeros((self.body.n_nodes, 3, 0))]
        for i in self._moved:
            field = self.body.rigid_motions(self.ports[i].point)
            field[~self.body.on_faces(self.ports[i].faces)] = 0.0
            fields.append(field - self.body.solve(self.body.apply_stiffness(field)))
        return np.concatenate(fields, axis=2)

    def _carry(self, port: int) -> Array:
        """Return X (6, 6): twist of the reference port to that of a port, for a rigid part."""
        return twist_shift(self.ports[port].point - self.ports[self._ref].point)

    @property
    def load_fields(self) -> Array:
        """The displacement fields (n, 3, 6(m-1)) of loads that span all there are.

        Fields of moved rigid ports are those of unit wrenches on them.
        """
        r = self._S.shape[0]
        moved = self._U @ np.linalg.inv(self._S) if r else self._U
        return np.concatenate([moved, self._Y], axis=2)

    @property
    def compliance_of_loads(self) -> Array:
        """Their products in the energy (6(m-1), 6(m-1))."""
        r = self._S.shape[0]
        zero = np.zeros((r, self._C.shape[0]))
        rigid = np.linalg.inv(self._S) if r else np.zeros((0, 0))
        return np.block([[rigid, zero], [zero.T, self._C]])

    def _order(self) -> NDArray[np.intp]:
        """Return where the rows of the others' twists, in order, stand in (moved, loaded)."""
        solved = [*self._moved, *self._loaded]
        return np.concatenate([6 * solved.index(i) + np.arange(6) for i in self._others])

    def compliance(self) -> Array:
        """Return the compliance (6(m-1), 6(m-1)) of the other ports with the asked one held."""
        r = self._S.shape[0]
        k = np.zeros((r + self._C.shape[0],) * 2)
        # Wrenches on rigid ports act on S; those on average ports do so through G as well.
        rigid = np.linalg.inv(self._S) if r else np.zeros((0, 0))
        k[:r, :r] = rigid
        k[:r, r:] = rigid @ self._G.T
        k[r:, :r] = k[:r, r:].T
        k[r:, r:] = self._C + self._G @ rigid @ self._G.T
        order = self._order()
        k = 0.5 * (k + k.T)[np.ix_(order, order)]
        if self._ref == self._asked:
            return k
        return rehold(k, self.ports, self._ref, self._asked)

    def static_fields(self) -> Array:
        """Return the displacement fields (n, 3, 6m) of unit twists of the ports, in order."""
        ports = self.ports
        rigid = self.body.rigid_motions(ports[self._ref].point)
        inverse = np.linalg.inv(self._C)
        loaded = self._Y @ inverse
        if not self._has_rigid:
            loaded = loaded - rigid @ products(self._ref_reading, loaded)
        solved = np.concatenate([self._U - loaded @ self._G, loaded], axis=2)
        relative = solved[:, :, self._order()]
        out = np.empty((self.body.n_nodes, 3, 6 * len(ports)))
        X = np.vstack([self._carry(i) for i in self._others])
        out[:, :, 6 * self._ref : 6 * self._ref + 6] = rigid - relative @ X
        for at, i in enumerate(self._others):
            out[:, :, 6 * i : 6 * i + 6] = relative[:, :, 6 * at : 6 * at + 6]
        return out

    def _held_response(self, load: Array) -> Array:
        """Return the displacement (n, 3) under a load (n, 3) with all ports held."""
        if self._has_rigid:
            u = self.body.solve(load[:, :, None])
        else:
            rigid = self.body.rigid_motions(self.ports[self._ref].point)
            balance = self._ref_reading @ np.einsum("nck,nc->k", rigid, load)
            u = self.body.solve((load - balance)[:, :, None])
        u = u - self._Y @ np.linalg.solve(self._C, products(self._R, u))
        if not self._has_rigid:
            u = u - rigid @ products(self._ref_reading, u)
        return np.asarray(u[:, :, 0])

    def modes(self, n_modes: int) -> tuple[Array, Array]:
        """Return mode stiffness (k,), 1/s^2, and mass (6m + k, 6m + k), kg and m.

        The modes are the lowest ones with all ports held, of unit modal mass. R. R. Craig, M. C. C.
        Bampton, "Coupling of substructures for dynamic analyses", AIAA J. 6(7), 1968.
        """
        fields = self.static_fields()
        values = np.zeros(0)
        if n_modes:
            values, shapes = self._lowest_modes(n_modes)
            fields = np.concatenate([fields, shapes], axis=2)
        M = products(fields, self.body.apply_mass(fields))
        return values, 0.5 * (M + M.T)

    def _lowest_modes(self, n_modes: int) -> tuple[Array, Array]:
        n = self.body.n_nodes

        def mass(x: Array) -> Array:
            return np.asarray(self.body.apply_mass(x.reshape(n, 3, 1)).ravel())

        def response(x: Array) -> Array:
            return np.asarray(self._held_response(x.reshape(n, 3)).ravel())

        values, shapes = lowest_modes(mass, response, 3 * n, n_modes)
        return values, shapes.reshape(n, 3, n_modes)
