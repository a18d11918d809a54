"""Links as solids: beams with their sections, parts from CAD, rods and plates for the rest."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from stiffkit.link import Outline
from stiffkit.robot import BASE, Link
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array
from stiffkit.studio.mesh import Mesh, ball, frame_along, joined, rounded_hull, sweep
from stiffkit.studio.seats import Seat
from stiffkit.studio.solid import Bend, Follow, Ride, Solid
from stiffkit.studio.thinning import thinned

if TYPE_CHECKING:
    from stiffkit.fea.surface_fields import Surface

_SHARES = np.linspace(0.0, 1.0, 13)
"""Where a bar has sections, so that it can bend."""

_ROD = 0.7
"""Radius of a rigid rod over the gauge."""

_STAND_IN = 0.9
"""Radius of a rod that stands for a link of unknown shape, over the gauge."""

_SAME = 1e-6
"""Points nearer than this, over the gauge, are one."""

_FLAT = 0.1
"""Points nearer to a plane than this, over the gauge, lie in it."""


def link_solids(link: Link, seats: list[Seat], tool: Seat | None, gauge: float) -> Iterator[Solid]:
    """Yield the solids of a link.

    ``seats`` are where joints are attached, ``tool`` where the tool is if the link carries it,
    ``gauge`` (m) is half the thickness of what has no thickness of its own.
    """
    if link.compliance is None:
        points = _distinct([seat.point for seat in seats], gauge)
        mesh = rigid_body(points, None if tool is None else tool.point, gauge)
        yield Solid(f"link {link.name}", "link", link.name, mesh, Ride(BASE))
        return
    if link.cad is not None:
        yield _part(link, link.cad.solved.surface)
    else:
        for port in link.other_ports:
            yield _bar(link, port, gauge)
    yield from _lugs(link, [*seats, *([] if tool is None else [tool])], gauge)


def _bar(link: Link, port: str, gauge: float) -> Solid:
    """Return the bar from an elastic link's base to a port."""
    name = f"link {link.name}" if len(link.other_ports) == 1 else f"link {link.name}, {port}"
    tip = link.ports[port].position
    length = float(np.linalg.norm(tip))
    if length <= _SAME * gauge:
        mesh = ball(gauge, tip)
        return Solid(name, "link", link.name, mesh, Ride(port), elastic=True, is_equivalent=True)
    outline = None if link.line is None else link.line.outline
    frame = Frame()
    if outline is None:
        thick = 2.0 * _STAND_IN * gauge
        outline = Outline("ellipse", thick, thick, is_equivalent=True)
        frame = frame_along(np.zeros(3), tip)
    mesh = sweep(outline, length * _SHARES).placed(frame)
    section = np.rint(mesh.vertices @ tip / length**2 * (_SHARES.size - 1)).astype(np.intp)
    motion = Bend(link, port, _SHARES, section)
    return Solid(
        name, "link", link.name, mesh, motion, elastic=True, is_equivalent=outline.is_equivalent
    )


@lru_cache(maxsize=100)
def _part(link: Link, surface: Surface) -> Solid:
    """Return the part from CAD that a link is, once for all robots that have it in common."""
    mesh, kept = thinned(Mesh(surface.points, surface.triangles.astype(np.intp)))
    motion = Follow(link, surface.displacements[kept])
    return Solid(f"link {link.name}", "link", link.name, mesh, motion, elastic=True)


def _lugs(link: Link, seats: list[Seat], gauge: float) -> Iterator[Solid]:
    """Yield what joins the ports of an elastic link to joints that are not at their origins."""
    for port, frame in link.ports.items():
        points = _distinct([frame.position, *(s.point for s in seats if s.port == port)], gauge)
        if len(points) > 1:
            mesh = rigid_body(points, None, _ROD * gauge)
            yield Solid(f"link {link.name} at {port}", "link", link.name, mesh, Ride(port))


def rigid_body(points: list[Array], tool: Array | None, gauge: float) -> Mesh:
    """Return a body with joints at distinct points: a ball, a rod, a plate, or what is convex.

    A rod also leads to the ``tool`` (3,) if that is somewhere else.
    """
    if tool is not None and len(points) < 2:
        points = _distinct([*points, tool], gauge)
    mesh = _around(points, gauge)
    middle = np.mean(points, axis=0)
    ends = [middle, *points]
    if tool is None or min(float(np.linalg.norm(tool - end)) for end in ends) < gauge:
        return mesh
    stem = rounded_hull(np.stack([middle, tool]), np.full(3, 0.6 * gauge))
    return joined([mesh, stem])


def _around(points: list[Array], gauge: float) -> Mesh:
    corners = np.array(points)
    if len(points) < 3:
        return rounded_hull(corners, np.full(3, gauge if len(points) < 2 else _ROD * gauge))
    _, sizes, axes = np.linalg.svd(corners - corners.mean(axis=0))
    if sizes[1] < _FLAT * gauge:
        return rounded_hull(corners, np.full(3, _ROD * gauge))
    if sizes.size < 3 or sizes[2] < _FLAT * gauge:
        return rounded_hull(corners, np.array([1.2, 1.2, 0.5]) * gauge, axes.T)
    return rounded_hull(corners, np.full(3, _ROD * gauge))


def _distinct(points: list[Array], gauge: float) -> list[Array]:
    """Return points without those that are others again; the origin if there are none."""
    found: list[Array] = []
    for p in points:
        if all(np.linalg.norm(p - other) > _SAME * gauge for other in found):
            found.append(p)
    return found or [np.zeros(3)]
