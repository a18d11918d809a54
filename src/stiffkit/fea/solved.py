"""What the solution of a part gave, as facts and arrays that can be kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiffkit.fea.arrays import MeshArrays
from stiffkit.fea.mesh import MeshSettings, PartMesh
from stiffkit.fea.meshcheck import MeshCheck
from stiffkit.fea.settings import SolveSettings
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
    """Relative difference of the compliance from the result's, over all loads."""

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
    mesh: PartMesh
    """Of the last solution; part axes."""
    settings: SolveSettings
    """With which orders it was solved."""
    estimate: float | None
    """Estimated relative error of the compliance over all loads; None where there is none."""
    steps: tuple[Step, ...]
    """The way to the solution, and beyond it where that led to nothing better."""
    facts: Mapping[str, Any]
    """Plain values: the part, its interfaces, the mesh, whether the tolerance was reached."""


def to_plain(solved: Solved) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return a solution as plain values and arrays."""
    element, surface = solved.element, solved.surface
    facts: dict[str, Any] = {
        "facts": dict(solved.facts),
        "rule": element.rule,
        "ports": list(solved.ports),
        "mass": solved.mass,
        "mesh": {
            "settings": vars(solved.mesh.settings),
            "check": vars(solved.mesh.check),
            "seconds": solved.mesh.seconds,
            "failures": list(solved.mesh.failures),
            "cuts": solved.mesh.cuts,
        },
        "order": solved.settings.order,
        "estimate": solved.estimate,
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
    for name in MeshArrays.__dataclass_fields__:
        arrays[f"mesh_{name}"] = getattr(solved.mesh, name)
    if solved.settings.orders is not None:
        arrays["orders"] = solved.settings.orders.astype(np.float64)
    return facts, arrays


def from_plain(facts: Mapping[str, Any], arrays: Mapping[str, Array]) -> Solved:
    """Return the solution of plain values and arrays. Raises KeyError if they lack something."""
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
        mesh=_mesh_from_plain(facts["mesh"], arrays),
        settings=SolveSettings(
            facts["order"], arrays["orders"].astype(np.intp) if "orders" in arrays else None
        ),
        estimate=facts["estimate"],
        steps=tuple(Step(**step) for step in facts["steps"]),
        facts=facts["facts"],
    )


def _mesh_from_plain(facts: Mapping[str, Any], arrays: Mapping[str, Array]) -> PartMesh:
    values: dict[str, Any] = {
        name: arrays[f"mesh_{name}"] for name in MeshArrays.__dataclass_fields__
    }
    return PartMesh(
        **values,
        settings=MeshSettings(**facts["settings"]),
        check=MeshCheck(**facts["check"]),
        seconds=facts["seconds"],
        failures=tuple(facts["failures"]),
        cuts=facts["cuts"],
    )
