"""Parts reduced to their ports: compliance, stiffness, and mass with internal modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.elasticity import SolveSettings
from stiffkit.fea.interfaces import Port
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import PartMesh
from stiffkit.fea.reduction import Reduction
from stiffkit.fea.rigid import relative_twists
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

    def link_frame(self, up: Array | None = None) -> Frame:
        """Return ``T_part_link``: origin at the held port's point, x to the other one's.

        z lies as near as it can to ``up`` (3,), the part's z if None (its y if that is along x).
        Raises `CadError` unless there are two ports, at different points.
        """
        base, tip = self._base_and_tip()
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

    def to_link(self, n_modes: int, up: Array | None = None) -> Superelement:
        """Return the superelement of a link with two ports, the held one its base, in link axes.

        See `link_frame`; ``n_modes`` modes with both ports held. Raises `CadError` as that does.
        """
        turn = np.kron(np.eye(2), self.link_frame(up).rotation)
        values, M = self.modes(n_modes)
        ports = np.concatenate([6 * self.held + np.arange(6), 6 * (1 - self.held) + np.arange(6)])
        order = np.concatenate([ports, 12 + np.arange(n_modes)])
        whole = np.eye(12 + n_modes)
        whole[:12, :12] = np.kron(np.eye(2), turn)
        M = whole.T @ M[np.ix_(order, order)] @ whole
        k = turn.T @ self.compliance @ turn
        rule = f"finite elements, {self.n_unknowns} unknowns"
        return Superelement(0.5 * (k + k.T), values, 0.5 * (M + M.T), rule)

    def _base_and_tip(self) -> tuple[Port, Port]:
        if len(self.ports) != 2:
            raise CadError(
                f"the part has {len(self.ports)} ports, and a link in a leg has two",
                mend="use the stiffness and mass of all ports",
            )
        return self.ports[self.held], self.ports[1 - self.held]


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
