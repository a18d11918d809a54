"""The meshes of a robot's parts: each distinct part once, and together not too large."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea import CadLink, MeshSettings, SolveSettings
from stiffkit.fea.discretisation import node_count
from stiffkit.fea.same_mesh import MeshedPart, mesh_spec, meshed_part
from stiffkit.fea.solved import Solved
from stiffkit.link import Superelement
from stiffkit.progress import Progress
from stiffkit.robot import Robot

MOST_UNKNOWNS = 700_000
"""That the whole robot may have before orders are lowered; about 8 GB."""


@dataclass(frozen=True, eq=False)
class Resolution:
    """How finely parts are meshed; as each link was itself, where nothing is said."""

    size: float | None = None
    """m, the largest element."""
    order: int | None = None


@dataclass(frozen=True, eq=False)
class Meshed:
    """A distinct part of a robot, on the mesh that it is verified with."""

    link: CadLink
    part: MeshedPart
    settings: SolveSettings
    """Of which orders its elements are."""
    links: tuple[str, ...]
    """Names of the robot's links that are this part."""

    @property
    def n_unknowns(self) -> int:
        """Displacement components of one of these parts."""
        return 3 * node_count(self.part.mesh, self.settings)

    @property
    def is_own(self) -> bool:
        """Whether the link was reduced on this very mesh with these orders."""
        solved, mesh = self.link.solved, self.part.mesh
        return mesh is solved.mesh and _same_orders(self.settings, solved.settings)

    def reduced(self) -> Superelement:
        """Return the part reduced on this very mesh. Raises FileError where it cannot be."""
        solved = self.link.solved
        if self.is_own:
            return solved.element
        return self.part.reduced(self.settings, solved.T_part_link)


def check_links(robot: Robot) -> None:
    """Raise CadError, which names them, if elastic links do not come from CAD."""
    lacking = [
        f"{name} ({link.origin})"
        for name, link in robot.links.items()
        if link.cad is None and link.compliance is not None
    ]
    if lacking:
        raise CadError(
            f"{robot.name} has elastic links that are not given by CAD: {', '.join(lacking)}",
            mend="give each of them by 'cad', or make it rigid; nothing can be meshed otherwise",
        )
    if all(link.cad is None for link in robot.links.values()):
        raise CadError(
            f"no link of {robot.name} is given by CAD, so there is nothing to mesh",
            mend="give the elastic ones by 'cad'",
        )


def mesh_parts(robot: Robot, resolution: Resolution, progress: Progress) -> list[Meshed]:
    """Return the distinct parts of a robot, meshed.

    Where all of them together have too many unknowns and no order is asked for, the highest orders
    are lowered. Raises FileError where a part cannot be meshed, CadError where even the lowest
    order has too many.
    """
    alike: dict[str, list[str]] = {}
    cads: dict[str, CadLink] = {}
    for name, link in robot.links.items():
        if link.cad is not None:
            cads[link.cad.key] = link.cad
            alike.setdefault(link.cad.key, []).append(name)
    found = []
    for i, (key, names) in enumerate(alike.items()):
        progress(f"meshing {names[0]}", 0.2 * i / len(alike))
        solved = cads[key].solved
        if resolution.size is None:
            part = meshed_part(cads[key].spec, solved.mesh)
        else:
            part = mesh_spec(cads[key].spec, MeshSettings(resolution.size))
        found.append(Meshed(cads[key], part, _settings(solved, part, resolution), tuple(names)))
    return found if resolution.order else _affordable(found)


def _settings(solved: Solved, part: MeshedPart, resolution: Resolution) -> SolveSettings:
    """Return orders as asked for, or as the link has them; where they differ, on its own mesh."""
    orders = solved.settings.orders
    if resolution.order or (orders is not None and len(orders) != len(part.mesh.tets)):
        return SolveSettings(resolution.order or solved.settings.order)
    return SolveSettings(solved.settings.order, orders)


def _same_orders(a: SolveSettings, b: SolveSettings) -> bool:
    if a.orders is None or b.orders is None:
        return a.orders is b.orders and a.order == b.order
    return np.array_equal(a.orders, b.orders)


def _at_most(highest: int, settings: SolveSettings) -> SolveSettings:
    """Return orders that are no higher."""
    orders = settings.orders
    lowered = None if orders is None else np.minimum(orders, highest)
    return SolveSettings(min(settings.order, highest), lowered)


def _affordable(parts: list[Meshed]) -> list[Meshed]:
    """Return the parts with the highest orders lowered until the whole is not too large."""
    for highest in range(max(part.settings.order for part in parts), 0, -1):
        lowered = [replace(part, settings=_at_most(highest, part.settings)) for part in parts]
        total = sum(len(part.links) * part.n_unknowns for part in lowered)
        if total <= MOST_UNKNOWNS:
            return lowered
    raise CadError(
        f"the meshes of all parts have {total} unknowns even at order 1, and at most "
        f"{MOST_UNKNOWNS} can be solved",
        mend="ask for larger elements by --size",
    )
