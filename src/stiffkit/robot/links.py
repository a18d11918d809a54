"""The links of a robot file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from stiffkit.errors import LinkError
from stiffkit.files.entry import Entry
from stiffkit.files.frames import read_frame
from stiffkit.files.names import suggest
from stiffkit.files.problems import Problems
from stiffkit.link.beam import beam_compliance, beam_inertia
from stiffkit.link.checks import doubts_compliance, doubts_inertia
from stiffkit.link.file import LinkFile, find_link_file, is_link_file, read_link_file
from stiffkit.link.given import read_compliance, read_inertia
from stiffkit.link.line import beam_line
from stiffkit.link.materials import Material
from stiffkit.link.ports import TIP, read_ports
from stiffkit.link.stretch import Stretch, read_stretch
from stiffkit.link.written import read_material, read_section
from stiffkit.progress import Progress
from stiffkit.robot.families import Families, WithOthers
from stiffkit.robot.memo import PartMemo
from stiffkit.robot.model import BASE, Array, Link
from stiffkit.spatial import Frame
from stiffkit.units import LENGTH, MASS

BODIES = ("beam", "rigid", "compliance", "cad")

Fields = dict[str, Entry]
"""What a link says, its own keys and those copied from others."""


def read_links(
    entries: Mapping[str, Entry],
    materials: Mapping[str, Material],
    progress: Progress | None = None,
    memo: PartMemo | None = None,
    with_others: WithOthers | None = None,
) -> tuple[dict[str, Link], list[str]]:
    """Return the links by name, and notes on repairs and doubts.

    ``progress`` is called while parts from CAD are solved; ``memo`` knows links read before;
    ``with_others`` gives all parameters with some replaced. Raises FileError where one of the links
    cannot exist.
    """
    memo = memo or PartMemo()
    fields = _with_copies(entries)
    links: dict[str, Link] = {}
    notes: list[str] = []
    problems = Problems()
    for name, entry in entries.items():
        with problems.collect():
            families = Families(name, materials, progress, memo, with_others)
            reader = _LinkReader(name, entry, fields[name], materials, progress, families)
            links[name], found = memo.get(
                f"links.{name}", fields[name].values(), reader.read, *materials.values()
            )
            notes.extend(f"links.{name}: {note}" for note in found)
    problems.check()
    return links, notes


def _with_copies(entries: Mapping[str, Entry]) -> dict[str, Fields]:
    """Return the keys of each link, those of the link that it is like filled in."""
    originals = {name: _original(name, entry, entries) for name, entry in entries.items()}
    graph = {name: [] if other is None else [other] for name, other in originals.items()}
    try:
        order = list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        circle = list(reversed(error.args[1]))
        raise entries[circle[0]]["like"].error(
            f"link '{circle[0]}' is like itself: {' -> '.join(circle)}",
            "describe one of them by 'beam', 'rigid', 'compliance' or 'cad'",
        ) from None
    fields: dict[str, Fields] = {}
    for name in order:
        own = {key: value for key, value in entries[name].items() if key != "like"}
        other = originals[name]
        copied = {} if other is None else dict(fields[other])
        if any(body in own for body in BODIES):
            copied = {key: value for key, value in copied.items() if key not in BODIES}
        fields[name] = copied | own
    return fields


def _original(name: str, entry: Entry, entries: Mapping[str, Entry]) -> str | None:
    like = entry.get("like")
    if like is None:
        return None
    if like.text() not in entries:
        others = [other for other in entries if other != name]
        raise like.error(f"there is no link '{like.text()}'", suggest(like.text(), others))
    return like.text()


class _LinkReader:
    """Reads one link; the notes gather on the way."""

    def __init__(
        self,
        name: str,
        entry: Entry,
        fields: Fields,
        materials: Mapping[str, Material],
        progress: Progress | None,
        families: Families,
    ) -> None:
        self.name = name
        self.entry = entry
        self.fields = fields
        self.materials = materials
        self.progress = progress
        self.families = families
        self.notes: list[str] = []

    def read(self) -> tuple[Link, list[str]]:
        match self.body():
            case "beam":
                link = self.beam(self.fields["beam"])
            case "compliance":
                link = self.given(self.fields["compliance"])
            case "cad":
                link = self.from_cad(self.fields["cad"])
            case _:
                link = self.rigid(self.fields["rigid"])
        self.doubt(link)
        return link, self.notes

    def body(self) -> str:
        given = [body for body in BODIES if body in self.fields]
        if len(given) > 1:
            raise self.entry.error(
                f"'{given[0]}' and '{given[1]}' cannot stand together", "remove one of the two"
            )
        if not given:
            raise self.entry.error(
                "nothing says what the link is",
                "add one of 'beam', 'rigid', 'compliance', 'cad', or 'like: ANOTHER_LINK'",
            )
        return given[0]

    def beam(self, entry: Entry) -> Link:
        length = entry["length"].positive(LENGTH)
        section = read_section(entry["section"])
        material = read_material(entry["material"], self.materials)
        try:
            compliance = beam_compliance(length, section, material)
            mass, center, inertia = beam_inertia(length, section, material)
        except LinkError as error:
            raise entry.blame(error) from None
        own_mass = self.mass()
        if own_mass is not None and "inertia" not in self.fields:
            inertia = inertia * (own_mass / mass)
            self.notes.append(
                f"the beam's inertia is scaled to the given mass, {mass:.6g} -> {own_mass:.6g} kg"
            )
        actual_mass = mass if own_mass is None else own_mass
        return Link(
            self.name,
            {BASE: Frame(), TIP: Frame.at(length)},
            compliance=compliance,
            mass=actual_mass,
            center_of_mass=self.center(center),
            inertia=self.inertia(inertia),
            origin="beam",
            line=beam_line(length, section, material, actual_mass),
        )

    def given(self, entry: Entry) -> Link:
        if isinstance(entry.node.value, str):
            return self.from_file(read_link_file(find_link_file(entry)), entry.text())
        ports = read_ports(entry)
        compliance, repairs = read_compliance(entry, list(ports))
        self.notes.extend(repairs)
        link = Link(
            self.name,
            {BASE: Frame(), **ports},
            compliance=compliance,
            mass=self.mass(),
            center_of_mass=self.center(None),
            inertia=self.inertia(None),
            origin="compliance",
        )
        scale = entry.get("scale")
        return link if scale is None else self.stretched(link, read_stretch(scale, ports))

    def stretched(self, link: Link, by: Stretch) -> Link:
        if by.is_none or link.compliance is None:
            return link
        self.notes.append(by.words)
        center, inertia = link.center_of_mass, link.inertia
        return replace(
            link,
            compliance=by.compliance(link.compliance),
            mass=None if link.mass is None else by.mass(link.mass),
            center_of_mass=None if center is None else by.point(center),
            inertia=None if inertia is None else by.inertia(inertia),
        )

    def from_cad(self, entry: Entry) -> Link:
        # It takes long to import, and few robots need it.
        from stiffkit.fea import link_from_cad, read_inline_spec, read_link_spec

        if isinstance(entry.node.value, str):
            spec = read_link_spec(_find_spec(entry))
        elif "between" in entry:
            return self.from_file(self.families.link(entry), "cad, interpolated")
        else:
            spec = read_inline_spec(entry, self.name, self.materials)
        found = link_from_cad(spec, self.progress)
        return replace(self.from_file(found.link, f"cad {spec.cad.name}"), cad=found)

    def from_file(self, found: LinkFile, origin: str) -> Link:
        self.notes.extend(found.notes)
        own = [key for key in ("mass", "center_of_mass", "inertia") if key in self.fields]
        if own and found.superelement is not None:
            raise self.fields[own[0]].error(
                f"the superelement of {origin} has a mass of its own", "leave this out"
            )
        mass = self.mass()
        return Link(
            self.name,
            {BASE: Frame(), **found.ports},
            compliance=found.compliance,
            mass=found.mass if mass is None else mass,
            center_of_mass=self.center(found.center_of_mass),
            inertia=self.inertia(found.inertia),
            origin=origin,
            superelement=found.superelement,
            covariance=found.covariance,
            content_hash=found.content_hash,
        )

    def rigid(self, entry: Entry) -> Link:
        ports = {BASE: Frame()}
        length = entry.get("length")
        if length is not None:
            ports[TIP] = Frame.at(length.positive(LENGTH))
        given = entry.get("ports")
        for name, port in [] if given is None else given.items():
            if name == TIP and length is not None:
                raise port.error(
                    "'length' gives the port 'tip' already", "remove one, or rename the port"
                )
            ports[name] = read_frame(port)
        return Link(
            self.name,
            ports,
            mass=self.mass(),
            center_of_mass=self.center(None),
            inertia=self.inertia(None),
            origin="rigid",
        )

    def mass(self) -> float | None:
        return self.fields["mass"].not_negative(MASS) if "mass" in self.fields else None

    def center(self, default: Array | None) -> Array | None:
        entry = self.fields.get("center_of_mass")
        return default if entry is None else entry.vector(LENGTH)

    def inertia(self, default: Array | None) -> Array | None:
        entry = self.fields.get("inertia")
        if entry is None:
            return default
        inertia, notes = read_inertia(entry, self.mass())
        self.notes.extend(notes)
        return inertia

    def doubt(self, link: Link) -> None:
        """Note what is possible but looks like a wrong unit."""
        if link.compliance is not None:
            self.notes.extend(doubts_compliance(link.compliance))
        if link.mass and link.inertia is not None:
            self.notes.extend(doubts_inertia(link.mass, link.inertia))


def _find_spec(entry: Entry) -> Path:
    """Return the path of the link specification that a text names."""
    name = entry.text()
    if not is_link_file(name):
        raise entry.error(
            f"'{name}' is not the name of a link specification",
            "interfaces and material belong to a part: write 'cad: {file: PART.step, material: "
            "..., base: ..., tip: ...}', or the name of a file with these, ending in .yaml",
        )
    path = entry.path.parent / name
    if not path.is_file():
        raise entry.error(
            f"there is no file '{path}'", "its name is taken relative to the robot file"
        )
    return path
