"""What the columns of a table of displacements mean, told from their headings."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

NODE = {"node", "nodeid", "nodenumber", "nodelabel", "nodeno", "nodes", "id", "pointid", "nid"}
CASE = {"case", "loadcase", "load", "step", "subcase", "lc"}
SET = {"set", "sets", "nodeset", "nset", "group", "face"}
PLACE = {
    *("", "coord", "coords", "coordinate", "coordinates", "point", "points"),
    *("position", "pos", "location", "loc"),
}
DISPLACEMENT = {
    *("u", "d", "disp", "displ", "displacement", "displacements"),
    *("deformation", "translation"),
}
COMPONENTS = (("x", "y", "z"), ("0", "1", "2"), ("1", "2", "3"))

UNIT = re.compile(r"\s*(\[[^]]*\]|\([^)]*\))\s*$")
GAP = r"[\s_:.\-/]+"
LAST = re.compile(r"(?P<stem>.*?)[\s_:.\-]*(?P<component>[xyz0-3])", re.IGNORECASE)
FIRST = re.compile(rf"(?P<component>[xyz]){GAP}(?P<stem>.+)", re.IGNORECASE)

Triple = tuple[int, int, int]


@dataclass(frozen=True)
class Headings:
    """The columns, from zero, of each meaning; displacements by the name of their load case.

    A table of one load case, or of one with a column for the load case, has the case ``""``.
    """

    place: Triple
    displacements: Mapping[str, Triple]
    node: int | None = None
    case: int | None = None
    sets: int | None = None

    @property
    def numbers(self) -> list[int]:
        """The columns that must hold numbers, the node first."""
        node = [] if self.node is None else [self.node]
        vectors = [column for triple in self.displacements.values() for column in triple]
        return [*node, *self.place, *vectors]


def read_headings(names: Sequence[str]) -> Headings:
    """Return the meaning of headings, or raise ``ValueError`` saying what is missing or double.

    Units in brackets are left out of a heading, upper and lower case and separators count alike.
    Coordinates are ``x``, ``Points:0``, ``X Location`` and such, displacements ``ux``, ``U:0``,
    ``U1``, ``push:ux`` or ``DISP_push_x``, where ``push`` is the name of the load case.
    """
    plain = [UNIT.sub("", name.strip().strip("\"'")).strip() for name in names]
    single = [re.sub(GAP, "", name).casefold() for name in plain]
    triples = vector_columns(plain)
    places = [triple for stem, triple in triples.items() if _key(stem) in PLACE]
    if len(places) != 1:
        some = "no" if not places else "more than one set of"
        raise ValueError(f"there are {some} coordinates x, y, z")
    displacements: dict[str, Triple] = {}
    for stem, triple in triples.items():
        case = _case(stem)
        if case is None:
            continue
        if case in displacements:
            raise ValueError(f"the displacements of '{case or 'the load case'}' are there twice")
        displacements[case] = triple
    if not displacements:
        raise ValueError("there are no displacements ux, uy, uz")
    return Headings(
        places[0], displacements, _one(single, NODE), _one(single, CASE), _one(single, SET)
    )


def vector_columns(names: Sequence[str]) -> dict[str, Triple]:
    """Return the columns of vectors by what their names share: ``push`` of ``push_x``.

    Raises ``ValueError`` where a component is there twice.
    """
    found: dict[str, dict[str, int]] = {}
    for column, name in enumerate(names):
        match = FIRST.fullmatch(name) or LAST.fullmatch(name)
        if match:
            components = found.setdefault(match["stem"], {})
            component = match["component"].lower()
            if component in components:
                raise ValueError(f"the column '{name}' is there twice")
            components[component] = column
    triples = {}
    for stem, components in found.items():
        for wanted in COMPONENTS:
            if all(component in components for component in wanted):
                x, y, z = (components[component] for component in wanted)
                triples[stem] = (x, y, z)
                break
    return triples


def _key(stem: str) -> str:
    return re.sub(GAP, "", stem).casefold()


def _case(stem: str) -> str | None:
    """Return the name of the load case in the stem of a displacement; None for other vectors."""
    words = re.split(f"({GAP})", stem)
    for place in (0, -1):
        if words[place].casefold() in DISPLACEMENT:
            rest = words[2:] if place == 0 else words[:-2]
            return "".join(rest).strip()
    return None


def _one(names: Sequence[str], meaning: set[str]) -> int | None:
    """Return the first column with a meaning."""
    return next((column for column, name in enumerate(names) if name in meaning), None)
