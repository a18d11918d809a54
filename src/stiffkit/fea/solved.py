"""What the solution of a part gave, as facts and arrays that can be kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiffkit.fea.elasticity import SolveSettings
from stiffkit.fea.mesh import MeshSettings
from stiffkit.fea.surface_fields import Surface
from stiffkit.link import Superelement
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True)
class Step:
    """One solution on the way to the last."""

    mesh: int
    """Which mesh, from 1."""
    lowest_order: int
    order: int
    """The highest of the elements."""
    elements: int
    unknowns: int
    seconds: float
    """s since the first began."""
    estimate: float | None
    """Estimated relative error of the compliance over all loads; None where there is none."""
    change: float
    """Relative difference of the compliance from the last solution's, over all loads."""

    @property
    def orders(self) -> str:
        """The lowest and the highest order, as people read it."""
        same = self.lowest_order == self.order
        return str(self.order) if same else f"{self.lowest_order} to {self.order}"


@dataclass(frozen=True, eq=False)
class Solved:
    """A part reduced to its ports, in link axes."""

    T_part_link: Frame
    ports: Mapping[str, Frame]
    """T_link_port of the ports but the base, in order."""
    element: Superelement
    mass: float
    """kg, of the CAD kernel."""
    center_of_mass: Array
    """(3,), m."""
    inertia: Array
    """(3, 3), kg m^2, about the centre of mass."""
    surface: Surface
    mesh: MeshSettings
    """What the mesher was asked for in the last solution."""
    settings: SolveSettings
    """With which orders it was solved."""
    steps: tuple[Step, ...]
    facts: Mapping[str, Any]
    """Plain values: the part, its interfaces, the mesh, whether the tolerance was reached."""

    @property
    def estimate(self) -> float | None:
        """Estimated relative error of the compliance over all loads."""
        return self.steps[-1].estimate


def to_plain(solved: Solved) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return a solution as plain values and arrays."""
    element, surface = solved.element, solved.surface
    facts: dict[str, Any] = {
        "facts": dict(solved.facts),
        "rule": element.rule,
        "ports": list(solved.ports),
        "mass": solved.mass,
        "mesh": {key: value for key, value in vars(solved.mesh).items() if key != "wanted"},
        "order": solved.settings.order,
        "steps": [vars(step) for step in solved.steps],
    }
    arrays: dict[str, Array] = {
        "link_axes": solved.T_part_link.rotation,
        "link_origin": solved.T_part_link.position,
        "port_axes": np.array([port.rotation for port in solved.ports.values()]),
        "port_origins": np.array([port.position for port in solved.ports.values()]),
        "compliance": element.compliance,
        "mode_stiffness": element.mode_stiffness,
        "element_mass": element.mass,
        "center_of_mass": solved.center_of_mass,
        "inertia": solved.inertia,
        "points": surface.points,
        "triangles": surface.triangles.astype(np.float64),
        "displacements": surface.displacements,
    }
    if solved.mesh.wanted is not None:
        arrays["mesh_points"], arrays["mesh_sizes"] = solved.mesh.wanted
    if solved.settings.orders is not None:
        arrays["orders"] = solved.settings.orders.astype(np.float64)
    return facts, arrays


def from_plain(facts: Mapping[str, Any], arrays: Mapping[str, Array]) -> Solved:
    """Return the solution of plain values and arrays. Raises KeyError if they lack something."""
    wanted = None
    if "mesh_points" in arrays:
        wanted = arrays["mesh_points"], arrays["mesh_sizes"]
    return Solved(
        T_part_link=Frame(arrays["link_axes"], arrays["link_origin"]),
        ports={
            name: Frame(axes, origin)
            for name, axes, origin in zip(
                facts["ports"], arrays["port_axes"], arrays["port_origins"], strict=True
            )
        },
        element=Superelement(
            arrays["compliance"], arrays["mode_stiffness"], arrays["element_mass"], facts["rule"]
        ),
        mass=facts["mass"],
        center_of_mass=arrays["center_of_mass"],
        inertia=arrays["inertia"],
        surface=Surface(
            arrays["points"],
            arrays["triangles"].astype(np.int64),
            arrays["displacements"],
        ),
        mesh=MeshSettings(**facts["mesh"], wanted=wanted),
        settings=SolveSettings(
            facts["order"], arrays["orders"].astype(np.intp) if "orders" in arrays else None
        ),
        steps=tuple(Step(**step) for step in facts["steps"]),
        facts=facts["facts"],
    )
