"""Interfaces: where a part is held, loaded and read, described so that a re-export keeps them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

import numpy as np

from stiffkit.errors import CadError
from stiffkit.fea.distance import distances_to_triangles
from stiffkit.fea.geometry import MM, Face, Part
from stiffkit.spatial.rotation import Array

KINDS = ("clamped", "rigid", "average")

_TIE = 1e-4
"""Two faces are equally near a point when their distances differ by less, over the diagonal."""

_COLOUR = 0.02
"""Colours are the same when each channel differs by less; CAD systems write 8 bits."""

_LISTED = 6


@dataclass(frozen=True)
class FacePick:
    """Which faces of a part are meant: those that satisfy all that is given."""

    names: tuple[str, ...] = ()
    """Names, with ``*`` and ``?`` as in file names."""
    colour: tuple[float, float, float] | None = None
    """Red, green, blue from 0 to 1."""
    kind: str | None = None
    """plane, cylinder or other."""
    box: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    """m, two corners; faces wholly inside."""
    near: tuple[tuple[float, float, float], ...] = ()
    """m, points; of the faces that satisfy the rest, the one nearest to each."""
    indices: tuple[int, ...] = ()
    """Numbers of faces in this very file; a re-export may renumber them."""
    count: int | None = None
    """How many faces it must be; any number if None."""

    def describe(self) -> str:
        """Return the description in words."""
        words = []
        if self.names:
            words.append(f"name {' or '.join(self.names)}")
        if self.colour is not None:
            words.append("colour ({:.3g}, {:.3g}, {:.3g})".format(*self.colour))
        if self.kind is not None:
            words.append(f"kind {self.kind}")
        if self.box is not None:
            words.append(f"inside {_mm(self.box[0])} to {_mm(self.box[1])} mm")
        if self.indices:
            words.append(f"number {', '.join(map(str, self.indices))}")
        if self.near:
            words.append(f"nearest to {' and '.join(_mm(point) for point in self.near)} mm")
        return ", ".join(words) or "every face"


@dataclass(frozen=True, eq=False)
class Interface:
    """A port of a part: its faces, how they are held or read, and the point and axes it refers to.

    ``clamped`` and ``rigid`` faces move as one rigid body: a clamped one is made to be held, a
    rigid one to be moved, and in a superelement of several ports both are the same. Of an
    ``average`` one the area-weighted mean motion is read, and its loads are spread likewise.
    """

    name: str
    pick: FacePick
    kind: str = "average"
    point: tuple[float, float, float] | None = None
    """m, the reference point; the centroid of the faces if None."""
    axes: Array | None = field(default=None)
    """(3, 3), columns are the port's axes in the part's; the part's own if None."""

    def __post_init__(self) -> None:
        """Check kind and axes."""
        if self.kind not in KINDS:
            raise CadError(
                f"interface {self.name}: unknown kind {self.kind!r}", mend=f"use {', '.join(KINDS)}"
            )
        if self.axes is not None and not np.allclose(self.axes.T @ self.axes, np.eye(3), atol=1e-9):
            raise CadError(
                f"interface {self.name}: the axes are not perpendicular unit vectors",
                mend="give the columns of a rotation matrix",
            )


@dataclass(frozen=True, eq=False)
class Port:
    """An interface found on a part."""

    name: str
    kind: str
    faces: tuple[int, ...]
    """Indices of the part's faces."""
    point: Array
    """(3,), m."""
    axes: Array
    """(3, 3), columns are the port's axes in the part's."""

    @property
    def is_rigid(self) -> bool:
        """Whether the faces move as one rigid body."""
        return self.kind != "average"


def find_ports(part: Part, interfaces: Sequence[Interface]) -> tuple[Port, ...]:
    """Return the ports that the interfaces mean.

    Raises `CadError` if there are none, two of one name, a pick that matches no face or another
    number than it must, or faces that belong to two ports.
    """
    if not interfaces:
        raise CadError("a link needs interfaces", mend="name at least two")
    names = [interface.name for interface in interfaces]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise CadError(f"two interfaces are called {', '.join(twice)}", mend="give each its own")
    ports = tuple(_port(part, interface) for interface in interfaces)
    for i, a in enumerate(ports):
        for b in ports[:i]:
            common = sorted(set(a.faces) & set(b.faces))
            if common:
                raise CadError(
                    f"interfaces {b.name} and {a.name} overlap: both have face "
                    f"{', '.join(map(str, common))}",
                    mend="let each face belong to one interface",
                )
    return ports


def named_ports(part: Part, kinds: Mapping[str, str]) -> tuple[Port, ...]:
    """Return ports at the faces of these names, each of its kind. Raises what `find_ports` does."""
    return find_ports(part, [Interface(n, FacePick(names=(n,)), kind) for n, kind in kinds.items()])


def pick_faces(part: Part, pick: FacePick, *, what: str = "the pick") -> tuple[Face, ...]:
    """Return the faces that ``pick`` means; ``what`` is its name in error messages.

    Raises `CadError`, with the candidates, if it matches none, or another number than it must.
    """
    matching = [face for face in part.faces if _matches(face, pick)]
    if pick.near and matching:
        found = [_nearest(part, matching, point, what) for point in pick.near]
        matching = [face for face in matching if face.index in {f.index for f in found}]
    wanted = pick.count
    if not matching:
        raise CadError(
            f"{what}: no face has {pick.describe()}",
            mend=f"the faces nearest to it, or largest, are:\n{_candidates(part, pick)}",
        )
    if wanted is not None and len(matching) != wanted:
        raise CadError(
            f"{what}: {len(matching)} faces have {pick.describe()}, and it must be {wanted}",
            mend=f"describe it more closely, or change the count; they are:\n{_list(matching)}",
        )
    return tuple(matching)


def _port(part: Part, interface: Interface) -> Port:
    faces = pick_faces(part, interface.pick, what=f"interface {interface.name}")
    areas = np.array([face.area for face in faces])
    centroid = areas @ np.array([face.centre for face in faces]) / areas.sum()
    return Port(
        name=interface.name,
        kind=interface.kind,
        faces=tuple(face.index for face in faces),
        point=centroid if interface.point is None else np.array(interface.point, dtype=float),
        axes=np.eye(3) if interface.axes is None else np.asarray(interface.axes, dtype=float),
    )


def _matches(face: Face, pick: FacePick) -> bool:
    """Say whether a face satisfies everything but the nearness."""
    if pick.names and not any(fnmatchcase(face.name, name) for name in pick.names):
        return False
    if pick.indices and face.index not in pick.indices:
        return False
    if pick.kind is not None and face.kind != pick.kind:
        return False
    if pick.colour is not None and (
        face.colour is None or np.abs(np.subtract(face.colour, pick.colour)).max() > _COLOUR
    ):
        return False
    if pick.box is not None:
        low, high = np.min(pick.box, axis=0), np.max(pick.box, axis=0)
        return bool(np.all(face.low >= low) and np.all(face.high <= high))
    return True


def _nearest(part: Part, faces: Sequence[Face], point: Sequence[float], what: str) -> Face:
    """Return the face nearest to a point; `CadError` if two are equally near."""
    distances = _distances(part, faces, point)
    order = np.argsort(distances)
    if len(faces) > 1 and distances[order[1]] - distances[order[0]] < _TIE * part.diagonal:
        near = [faces[i] for i in order if distances[i] <= distances[order[0]] + _TIE]
        raise CadError(
            f"{what}: more than one face is nearest to {_mm(point)} mm",
            mend=f"give a point in the middle of the face; they are:\n{_list(near[:_LISTED])}",
        )
    return faces[int(order[0])]


def _distances(part: Part, faces: Sequence[Face], point: Sequence[float]) -> Array:
    """Return the distances (f,) of faces from a point, m."""
    to_triangles = distances_to_triangles(np.asarray(point, dtype=float), part.triangles)
    nearest = np.full(len(part.faces), np.inf)
    np.minimum.at(nearest, part.triangle_face, to_triangles)
    return nearest[[face.index for face in faces]]


def _candidates(part: Part, pick: FacePick) -> str:
    """Return the faces that come nearest to what was asked for, one a line."""
    if pick.names and any(face.name for face in part.faces):
        named = sorted((face for face in part.faces if face.name), key=lambda f: f.name)
        return _list(named[: 3 * _LISTED])
    if pick.near or pick.box is not None:
        corners = pick.near[:1] or pick.box or ()
        point = np.mean(np.array(corners), axis=0)
        order = np.argsort(_distances(part, part.faces, point))
        return _list([part.faces[i] for i in order[:_LISTED]])
    return _list(sorted(part.faces, key=lambda face: -face.area)[:_LISTED])


def _list(faces: Sequence[Face]) -> str:
    return "\n".join(f"    {face.describe()}" for face in faces)


def _mm(point: Sequence[float] | Array) -> str:
    return "({})".format(", ".join(f"{x / MM:.6g}" for x in point))
