"""From a specification to a solution: read the part, mesh it, solve, reduce."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiffkit.fea.adapt import Adapted, AdaptSettings, Level, adapt
from stiffkit.fea.estimate import relative_difference
from stiffkit.fea.geometry import Part
from stiffkit.fea.interfaces import Port
from stiffkit.fea.link_spec import LinkSpec, blamed_on
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import MeshSettings, PartMesh, mesh_part
from stiffkit.fea.prepared import laws_of, ports_of, read_part
from stiffkit.fea.reading import describe_readings
from stiffkit.fea.settings import SolveSettings
from stiffkit.fea.solved import Solved, Step
from stiffkit.fea.superelement import PortModel, reduce_part
from stiffkit.fea.surface_fields import surface_of
from stiffkit.progress import Progress
from stiffkit.spatial.frame import Frame

BASE = 0


@dataclass(frozen=True, eq=False)
class _Solution:
    model: PortModel
    mesh: PartMesh
    order: int
    estimate: float | None
    steps: tuple[Step, ...]
    converged: bool
    stopped: str


def solve_spec(spec: LinkSpec, progress: Progress) -> Solved:
    """Return the solution that a specification asks for.

    Raises FileError, with its place, where the part, its faces or its materials are wrong, or
    where no mesh or no solution can be found.
    """
    progress("reading the part", 0.0)
    part = read_part(spec)
    ports, laws = ports_of(part, spec), laws_of(part, spec)
    with blamed_on(spec.cad_place):
        progress("meshing", 0.05)
        found = _refined(part, ports, laws, spec, progress)
        progress("modes", 0.9)
        return _solved(part, ports, laws, spec, found)


def _refined(
    part: Part, ports: Sequence[Port], laws: Sequence[Law], spec: LinkSpec, progress: Progress
) -> _Solution:
    if spec.mesh is not None:
        return _on_one_mesh(part, ports, laws, spec.mesh.size, spec.mesh.order)

    def report(level: Level) -> None:
        words = f"{level.n_unknowns} unknowns"
        if math.isfinite(level.estimate):
            words += f", error {100.0 * level.estimate:.2g} %"
        # How far it is to go is known for the error only, and that not well.
        far = math.log(max(1.0, level.estimate / spec.tolerance))
        progress(words, 0.85 / (1.0 + min(far, 8.0)))

    settings = AdaptSettings(spec.tolerance, features=spec.features)
    adapted = adapt(part, ports, laws, settings, progress=report)
    return _Solution(
        adapted.model,
        adapted.mesh,
        adapted.level.orders[1],
        _told(adapted.estimate),
        _steps(adapted),
        adapted.converged,
        adapted.stopped,
    )


def _steps(adapted: Adapted) -> tuple[Step, ...]:
    best = adapted.level.compliance
    return tuple(
        Step(
            mesh=level.mesh + 1,
            lowest_order=level.orders[0],
            order=level.orders[1],
            elements=level.n_tets,
            unknowns=level.n_unknowns,
            seconds=level.seconds,
            estimate=_told(level.estimate),
            change=float(relative_difference(level.compliance - best, best)),
        )
        for level in adapted.history
    )


def _on_one_mesh(
    part: Part, ports: Sequence[Port], laws: Sequence[Law], size: float, order: int
) -> _Solution:
    mesh = mesh_part(part, MeshSettings(size))
    model = reduce_part(mesh, ports, laws, SolveSettings(order), BASE)
    step = Step(1, order, order, mesh.check.n_tets, model.n_unknowns, mesh.seconds, None, 0.0)
    return _Solution(model, mesh, order, None, (step,), False, "one mesh was asked for")


def _told(estimate: float) -> float | None:
    return estimate if math.isfinite(estimate) else None


def _solved(
    part: Part, ports: Sequence[Port], laws: Sequence[Law], spec: LinkSpec, found: _Solution
) -> Solved:
    model = found.model
    T_part_link = _link_frame(model, spec)
    R = T_part_link.rotation
    mass, center, inertia = part.mass_properties(tuple(law.density for law in laws))
    return Solved(
        T_part_link=T_part_link,
        ports={
            name: Frame(
                np.eye(3) if given.axes is None else R.T @ port.axes,
                R.T @ (port.point - T_part_link.position),
            )
            for (name, given), port in zip(spec.ports[1:], ports[1:], strict=True)
        },
        element=model.to_link(spec.n_modes, R),
        mass=mass,
        center_of_mass=R.T @ (center - T_part_link.position),
        inertia=R.T @ inertia @ R,
        surface=surface_of(model, found.mesh, found.order, T_part_link),
        mesh=found.mesh,
        settings=model.solver.body.settings,
        estimate=found.estimate,
        steps=found.steps,
        facts=_facts(part, ports, laws, spec, found)
        | {"readings": describe_readings(model, T_part_link)},
    )


def _link_frame(model: PortModel, spec: LinkSpec) -> Frame:
    """Return T_part_link: as the base is turned, or with x from it to the first other port."""
    base = model.ports[BASE]
    if spec.base.axes is not None:
        return Frame(base.axes, base.point)
    return model.link_frame(None if spec.up is None else np.array(spec.up))


def _facts(
    part: Part, ports: Sequence[Port], laws: Sequence[Law], spec: LinkSpec, found: _Solution
) -> dict[str, Any]:
    return {
        "unit": part.unit,
        "size": (part.high - part.low).tolist(),
        "faces": len(part.faces),
        "volume": part.volume,
        "materials": {
            solid.name: describe_law(law) for solid, law in zip(part.solids, laws, strict=True)
        },
        "interfaces": {
            name: {
                "interface": port.kind,
                "faces": given.describe(),
                "numbers": list(port.faces),
                "area": math.fsum(part.faces[i].area for i in port.faces),
                "at": port.point.tolist(),
            }
            for (name, given), port in zip(spec.ports, ports, strict=True)
        },
        "mesh": found.mesh.describe(),
        "elements": found.mesh.check.n_tets,
        "volume_error": found.mesh.check.volume_error,
        "area_error": found.mesh.check.area_error,
        "failures": list(found.mesh.failures),
        "order": found.order,
        "unknowns": found.model.n_unknowns,
        "asymmetry": found.model.asymmetry,
        "tolerance": None if spec.mesh is not None else spec.tolerance,
        "converged": found.converged,
        "stopped": found.stopped,
    }


def describe_law(law: Law) -> dict[str, Any]:
    """Return a material as plain values, SI."""
    plain: dict[str, Any] = {
        key: value for key, value in vars(law).items() if isinstance(value, str | int | float)
    }
    if "axes" in vars(law):
        plain["axes"] = vars(law)["axes"].tolist()
    return plain
