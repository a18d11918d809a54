"""Specifications of links from CAD: part, material, interfaces and accuracy, in a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from stiffkit.errors import CadError, LinkError
from stiffkit.fea.beams import BeamApproximation, read_beams
from stiffkit.fea.interfaces import FacePick
from stiffkit.fea.material import Law
from stiffkit.fea.sources import PartSource, read_source_of_part
from stiffkit.fea.written import read_law
from stiffkit.files import Entry, check_shape, read_frame, read_source, read_tree
from stiffkit.files.shares import read_share
from stiffkit.link import MATERIALS, Material
from stiffkit.link.ports import BASE, TIP, other_ports
from stiffkit.spatial.rotation import Array
from stiffkit.units import LENGTH, NUMBER

SCHEMA_FILE = Path(__file__).with_name("schema.json")
"""The published schema of specifications."""

TOLERANCE = 1e-3
"""Relative error of the compliance that is asked for if nothing is said."""

MODES = 6
"""Modes of the superelement if nothing is said."""

_MOST_MODES = 100
_MOST_FACES = 1_000_000
_HIGHEST_ORDER = 8


@dataclass(frozen=True, eq=False)
class PortSpec:
    """An interface as a specification describes it; part axes."""

    place: Entry
    """Where the specification says so."""
    picks: tuple[FacePick, ...]
    """Each means faces of its own; together they are the interface's."""
    kind: str
    """clamped, rigid or average."""
    point: tuple[float, float, float] | None
    """m; the centroid of the faces if None."""
    axes: Array | None
    """(3, 3), columns are the port's axes in the part's."""

    def describe(self) -> str:
        """Return the faces in words."""
        return "; ".join(pick.describe() for pick in self.picks)


@dataclass(frozen=True)
class FixedMesh:
    """One mesh and order that is asked for instead of refinement."""

    size: float
    """m, the largest element."""
    order: int


@dataclass(frozen=True, eq=False)
class LinkSpec:
    """A specification of a link from CAD: all in SI, places in the part's axes."""

    path: Path
    title: str
    cad: PartSource
    """What gives the part."""
    scale: float | None
    """What the part's lengths are multiplied by; 1, with a check of its size, if None."""
    material: Law
    solids: Mapping[str, Law]
    """Materials of solids, by the solid's name, that differ."""
    ports: tuple[tuple[str, PortSpec], ...]
    """The interfaces by name, "base" first; the others in the order of the link's compliance."""
    up: tuple[float, float, float] | None
    """What the link's z is nearest to."""
    tolerance: float
    features: float | None
    """m: smaller features do not refine the mesh; chosen from the part's size if None."""
    n_modes: int
    mesh: FixedMesh | None
    content_hash: str
    """SHA-256 of the file; empty if it stands in another file."""
    cad_place: Entry
    """Where the specification names the part."""
    beams: tuple[BeamApproximation, ...] = ()
    """Approximations to compare with; the result does not depend on them."""

    @property
    def base(self) -> PortSpec:
        """The interface that is held."""
        return self.ports[0][1]

    @property
    def name(self) -> str:
        """The file's name without what follows its first dot; results are called so."""
        return self.path.name.partition(".")[0] or "link"


def read_link_spec(path: Path | str, part: PartSource | None = None) -> LinkSpec:
    """Return the specification of a file; ``part`` takes the place of the one that it names.

    Raises FileError, with the place and how to mend it, where anything is wrong.
    """
    source = read_source(Path(path))
    root = read_tree(source, "link: TITLE")
    check_shape(root, source.path, SCHEMA_FILE)
    entry = Entry(source.path, (), root)
    title = entry["link"].text()
    return _spec(entry, entry["cad"], title, MATERIALS, source.content_hash, part)


def read_inline_spec(entry: Entry, title: str, materials: Mapping[str, Material]) -> LinkSpec:
    """Return the specification that stands in another file, whose shape has been checked.

    Its part stands under ``file``, or under ``part`` and ``dimensions``. Raises FileError where
    anything is wrong.
    """
    if ("file" in entry) == ("part" in entry):
        which = "both 'file' and 'part' are" if "file" in entry else "neither 'file' nor 'part' is"
        raise entry.error(
            f"{which} given", "name a CAD file by 'file', or a parametric part by 'part'"
        )
    if "file" in entry and "dimensions" in entry:
        raise entry["dimensions"].error("a file has no dimensions to give", "remove them")
    file = entry.get("file")
    return _spec(entry, entry if file is None else file, title, materials, "")


@contextmanager
def blamed_on(entry: Entry) -> Iterator[None]:
    """Tell what is wrong with a part, inside, as an error of the place in the specification."""
    try:
        yield
    except (CadError, LinkError) as error:
        raise entry.error(error.what, error.mend) from None


def _spec(
    entry: Entry,
    cad: Entry,
    title: str,
    materials: Mapping[str, Material],
    content_hash: str,
    part: PartSource | None = None,
) -> LinkSpec:
    scale, up, solids = entry.get("scale"), entry.get("up"), entry.get("solids")
    tolerance, beams = entry.get("tolerance"), entry.get("beams")
    features = entry.get("features")
    material = read_law(entry["material"], materials)
    if beams is not None and "tip" not in entry:
        raise beams.error("beams lead from the base to a tip, and the link has none", "remove them")
    return LinkSpec(
        path=entry.path,
        title=title,
        cad=read_source_of_part(cad) if part is None else part,
        scale=None if scale is None else scale.positive(NUMBER),
        material=material,
        solids={
            name: read_law(given, materials)
            for name, given in ([] if solids is None else solids.items())
        },
        ports=_ports(entry),
        up=None if up is None else _triple(up.vector(NUMBER)),
        tolerance=TOLERANCE
        if tolerance is None
        else read_share(tolerance, most=0.5, example=0.001),
        features=None if features is None else features.positive(LENGTH),
        n_modes=_whole(entry.get("modes"), MODES, 0, _MOST_MODES),
        mesh=_mesh(entry.get("mesh")),
        content_hash=content_hash,
        cad_place=cad,
        beams=read_beams(beams, material),
    )


def _ports(entry: Entry) -> tuple[tuple[str, PortSpec], ...]:
    """Return the base, and the tip or the ports that stand in its place."""
    tip, given = entry.get("tip"), entry.get("ports")
    if (tip is None) == (given is None):
        what = "neither 'tip' nor 'ports' is" if tip is None else "'tip' and 'ports' are both"
        raise entry.error(
            f"{what} given",
            f"write 'tip' where the link has one port beside its {BASE}, 'ports' where it has more",
        )
    others = other_ports(entry["ports"]) if tip is None else [(TIP, tip)]
    return (BASE, _port(entry[BASE])), *((name, _port(port)) for name, port in others)


def _port(entry: Entry) -> PortSpec:
    faces, at = entry["faces"], entry.get("at")
    given = faces.elements() if isinstance(faces.node.value, list) else [faces]
    axes = read_frame(entry).rotation if "rotate" in entry else None
    return PortSpec(
        place=entry,
        picks=tuple(_pick(one) for one in given),
        kind=entry["interface"].text(),
        point=None if at is None else _triple(at.vector(LENGTH)),
        axes=axes,
    )


def _pick(entry: Entry) -> FacePick:
    name, kind, near = entry.get("name"), entry.get("kind"), entry.get("near")
    colour, box, number = entry.get("colour"), entry.get("box"), entry.get("number")
    return FacePick(
        names=() if name is None else (name.text(),),
        colour=None if colour is None else _triple(colour.vector(NUMBER)),
        kind=None if kind is None else kind.text(),
        box=None
        if box is None
        else (_triple(box[0].vector(LENGTH)), _triple(box[1].vector(LENGTH))),
        near=() if near is None else (_triple(near.vector(LENGTH)),),
        indices=() if number is None else (_whole(number, 0, 0, _MOST_FACES),),
        count=_count(entry.get("count")),
    )


def _count(entry: Entry | None) -> int | None:
    """Return how many faces a description means; None for any number."""
    if entry is not None and entry.is_text("any"):
        return None
    return _whole(entry, 1, 1, _MOST_FACES)


def _mesh(entry: Entry | None) -> FixedMesh | None:
    if entry is None:
        return None
    return FixedMesh(
        size=entry["size"].positive(LENGTH),
        order=_whole(entry["order"], 2, 1, _HIGHEST_ORDER),
    )


def _whole(entry: Entry | None, default: int, least: int, most: int) -> int:
    """Return a whole number between two others, both included."""
    if entry is None:
        return default
    number = entry.quantity(NUMBER)
    if number != int(number) or not least <= number <= most:
        raise entry.error(f"'{entry.text()}' is not a whole number from {least} to {most}")
    return int(number)


def _triple(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
