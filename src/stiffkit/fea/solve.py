"""From a specification to a solution: read the part, find its ports, solve, reduce."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.adapt import Adapted, AdaptSettings, Level, adapt
from stiffkit.fea.elasticity import SolveSettings
from stiffkit.fea.estimate import relative_difference
from stiffkit.fea.geometry import Part, read_step
from stiffkit.fea.interfaces import FacePick, Interface, Port, find_ports, pick_faces
from stiffkit.fea.link_spec import LinkSpec, PortSpec, blamed_on
from stiffkit.fea.material import Law
from stiffkit.fea.mesh import MeshSettings, PartMesh, mesh_part
from stiffkit.fea.solved import Solved, Step
from stiffkit.fea.superelement import PortModel, reduce_part
from stiffkit.fea.surface_fields import surface_of
from stiffkit.link import Superelement
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array

Progress = Callable[[str, float], None]
"""Is told what is being done, and the share that is done."""

BASE, TIP = 0, 1


@dataclass(frozen=True, eq=False)
class _Solution:
    model: PortModel
    mesh: PartMesh
    order: int
    steps: tuple[Step, ...]
    converged: bool
    stopped: str


def read_part(spec: LinkSpec) -> Part:
    """Return the part of a specification.

    Raises FileError, at the place in the specification, if it is no single solid body.
    """
    check_installed()
    with blamed_on(spec.cad_place):
        return read_step(spec.cad, scale=spec.scale)


def check_installed() -> None:
    """Raise CadError if the library that reads, meshes and solves is missing."""
    if find_spec("netgen") is None or find_spec("ngsolve") is None:
        raise CadError(
            "links from CAD need NGSolve, which is not installed",
            mend="pip install 'stiffkit[fea]'",
        )


def solve_spec(spec: LinkSpec, progress: Progress) -> Solved:
    """Return the solution that a specification asks for.

    Raises FileError, with its place, where the part, its faces or its materials are wrong, or
    where no mesh or no solution can be found.
    """
    progress("reading the part", 0.0)
    part = read_part(spec)
    ports = _ports(part, spec)
    with blamed_on(spec.cad_place):
        laws = _laws(part, spec)
        progress("meshing", 0.05)
        found = _refined(part, ports, laws, spec, progress)
        progress("modes", 0.9)
        return _solved(part, ports, laws, spec, found)


def _ports(part: Part, spec: LinkSpec) -> tuple[Port, ...]:
    interfaces = [_interface(part, name, port) for name, port in _named(spec)]
    with blamed_on(spec.tip.place):
        return find_ports(part, interfaces)


def _named(spec: LinkSpec) -> tuple[tuple[str, PortSpec], ...]:
    return ("base", spec.base), ("tip", spec.tip)


def _interface(part: Part, name: str, port: PortSpec) -> Interface:
    """Return an interface with its faces by number, found one description after another."""
    indices: list[int] = []
    for pick in port.picks:
        with blamed_on(port.place["faces"]):
            faces = pick_faces(part, pick, what=name)
        indices.extend(face.index for face in faces if face.index not in indices)
    return Interface(name, FacePick(indices=tuple(indices)), port.kind, port.point, port.axes)


def _laws(part: Part, spec: LinkSpec) -> list[Law]:
    names = [solid.name for solid in part.solids]
    for name in spec.solids:
        if name not in names:
            raise CadError(
                f"the part has no solid '{name}'", mend=f"its solids are {', '.join(names)}"
            )
    return [spec.solids.get(name, spec.material) for name in names]


def _refined(
    part: Part, ports: Sequence[Port], laws: Sequence[Law], spec: LinkSpec, progress: Progress
) -> _Solution:
    if spec.mesh is not None:
        return _on_one_mesh(part, ports, laws, spec.mesh.size, spec.mesh.order)

    def report(level: Level) -> None:
        words = f"order {level.order}, {level.n_unknowns} unknowns"
        if math.isfinite(level.estimate):
            words += f", error {100.0 * level.estimate:.2g} %"
        # How far it is to go is not known; each solution takes about as long as all before.
        progress(words, 0.85 * (1.0 - 0.8 ** (level.order + 4 * level.mesh)))

    adapted = adapt(part, ports, laws, AdaptSettings(spec.tolerance), progress=report)
    return _Solution(
        adapted.model,
        adapted.mesh,
        adapted.history[-1].order,
        _steps(adapted),
        adapted.converged,
        adapted.stopped,
    )


def _steps(adapted: Adapted) -> tuple[Step, ...]:
    last = adapted.history[-1].compliance
    return tuple(
        Step(
            mesh=level.mesh + 1,
            order=level.order,
            elements=level.n_tets,
            unknowns=level.n_unknowns,
            seconds=level.seconds,
            estimate=level.estimate if math.isfinite(level.estimate) else None,
            change=float(relative_difference(level.compliance - last, last)),
        )
        for level in adapted.history
    )


def _on_one_mesh(
    part: Part, ports: Sequence[Port], laws: Sequence[Law], size: float, order: int
) -> _Solution:
    mesh = mesh_part(part, MeshSettings(size))
    model = reduce_part(mesh, ports, laws, SolveSettings(order), BASE)
    step = Step(1, order, mesh.check.n_tets, model.n_unknowns, mesh.seconds, None, 0.0)
    return _Solution(model, mesh, order, (step,), False, "one mesh was asked for")


def _solved(
    part: Part, ports: Sequence[Port], laws: Sequence[Law], spec: LinkSpec, found: _Solution
) -> Solved:
    model = found.model
    T_part_link = _link_frame(model, spec)
    R = T_part_link.rotation
    tip = ports[TIP]
    tip_axes = np.eye(3) if spec.tip.axes is None else R.T @ tip.axes
    mass, center, inertia = part.mass_properties(tuple(law.density for law in laws))
    return Solved(
        T_part_link=T_part_link,
        T_link_tip=Frame(tip_axes, R.T @ (tip.point - T_part_link.position)),
        element=_superelement(model, R, spec.n_modes),
        mass=mass,
        center_of_mass=R.T @ (center - T_part_link.position),
        inertia=R.T @ inertia @ R,
        surface=surface_of(model, found.mesh, found.order, T_part_link),
        steps=found.steps,
        facts=_facts(part, ports, laws, spec, found),
    )


def _link_frame(model: PortModel, spec: LinkSpec) -> Frame:
    """Return T_part_link: as the base is turned, or with x from base to tip."""
    base = model.ports[BASE]
    if spec.base.axes is not None:
        return Frame(base.axes, base.point)
    return model.link_frame(None if spec.up is None else np.array(spec.up))


def _superelement(model: PortModel, R: Array, n_modes: int) -> Superelement:
    """Return the superelement in axes that are the columns of R (3, 3) in the part's."""
    turn = np.kron(np.eye(2), R)
    values, M = model.modes(n_modes)
    whole = np.eye(12 + n_modes)
    whole[:12, :12] = np.kron(np.eye(2), turn)
    M = whole.T @ M @ whole
    k = turn.T @ model.compliance @ turn
    rule = f"finite elements, {model.n_unknowns} unknowns"
    return Superelement(0.5 * (k + k.T), values, 0.5 * (M + M.T), rule)


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
            for (name, given), port in zip(_named(spec), ports, strict=True)
        },
        "mesh": found.mesh.settings.describe(),
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
