"""Parts reduced to their ports: compliance, stiffness, and mass with internal modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.interfaces import Port
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.reduction import Reduction
from stiffkit.fea.rigid import relative_twists
from stiffkit.fea.settings import SolveSettings
from stiffkit.link.superelement import Superelement
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class PortModel:
    """A part reduced to m ports; all in the part's axes, twists at the ports' points."""

    ports: tuple[Port, ...]
    held: int
    """Index of the port that is held where a compliance is meant."""
    compliance: Array
    """(6(m-1), 6(m-1)): twists of the other ports, in order, with ``held`` at rest."""
    n_unknowns: int
    asymmetry: float
    """Of the compliance as read, over its diagonal, before rounding is averaged out."""
    solver: Reduction = field(repr=False)

    @property
    def stiffness(self) -> Array:
        """(6m, 6m): wrenches on the ports from their twists; rigid-body motions cost nothing."""
        B = relative_twists(self.ports, self.held)
        return np.asarray(B.T @ np.linalg.inv(self.compliance) @ B)

    def modes(self, n_modes: int) -> tuple[Array, Array]:
        """Return mode stiffness (k,) and mass (6m + k, 6m + k) with ``n_modes`` modes.

        See `Reduction.modes`.
        """
        return self.solver.modes(n_modes)

    @property
    def _from_held(self) -> list[int]:
        """Indices of the ports, the held one first."""
        return [self.held, *(i for i in range(len(self.ports)) if i != self.held)]

    def link_frame(self, up: Array | None = None) -> Frame:
        """Return ``T_part_link``: origin at the held port's point, x to the first of the others.

        z lies as near as it can to ``up`` (3,), the part's z if None (its y if that is along x).
        Raises `CadError` if the two ports are at one point.
        """
        base, tip, *_ = (self.ports[i] for i in self._from_held)
        along = tip.point - base.point
        length = float(np.linalg.norm(along))
        if length == 0.0:
            raise CadError(
                f"ports {base.name} and {tip.name} are at one point, so the link has no direction",
                mend="give one of the interfaces another reference point",
            )
        x = along / length
        choices = np.eye(3)[[2, 1]] if up is None else np.atleast_2d(up)
        for choice in choices:
            z = choice - (choice @ x) * x
            if np.linalg.norm(z) > 1e-3 * np.linalg.norm(choice):
                z /= np.linalg.norm(z)
                return Frame(np.column_stack([x, np.cross(z, x), z]), base.point)
        raise CadError("the direction up is along the link", mend="choose another")

    def to_link(self, n_modes: int, R: Array) -> Superelement:
        """Return the superelement of a link, the held port its base, and the others in order.

        Its axes are the columns of ``R`` (3, 3) in the part's, such as those of `link_frame`;
        ``n_modes`` modes with all ports held.
        """
        m = len(self.ports)
        values, M = self.modes(n_modes)
        ports = [6 * i + np.arange(6) for i in self._from_held]
        order = np.concatenate([*ports, 6 * m + np.arange(n_modes)])
        whole = np.eye(6 * m + n_modes)
        whole[: 6 * m, : 6 * m] = np.kron(np.eye(2 * m), R)
        M = whole.T @ M[np.ix_(order, order)] @ whole
        turn = np.kron(np.eye(2 * (m - 1)), R)
        k = turn.T @ self.compliance @ turn
        rule = f"finite elements, {self.n_unknowns} unknowns"
        return Superelement(0.5 * (k + k.T), values, 0.5 * (M + M.T), rule)


def reduce_part(
    mesh: PartMesh,
    ports: Sequence[Port],
    laws: Sequence[Law],
    settings: SolveSettings,
    held: int = 0,
) -> PortModel:
    """Return a meshed part reduced to its ports. Raises `CadError`; see `Reduction`."""
    if len(ports) < 2:
        raise CadError("a link needs two ports or more", mend="name another interface")
    solver = Reduction(mesh, ports, laws, settings, held)
    return PortModel(
        ports=solver.ports,
        held=held,
        compliance=solver.compliance(),
        n_unknowns=solver.body.n_unknowns,
        asymmetry=solver.asymmetry,
        solver=solver,
    )
