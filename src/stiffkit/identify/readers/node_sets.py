"""Abaqus-style input decks: named node sets, surfaces, nodes and elements.

CalculiX, Gmsh, PrePoMax and others write them beside their results, whose files do not know the
names. Read are *NODE, *ELEMENT, *NSET, *ELSET (both with GENERATE) and *SURFACE; a surface is the
set of its nodes. Names do not distinguish upper and lower case; sets of one name merge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers.content import Array, FieldFile, Integers
from stiffkit.identify.readers.keywords import Keyword, read_keywords

MOST_GENERATED = 10**8
"""Numbers in one line of GENERATE; more can only be a mistake."""
LARGEST = 10**15

_SHELLS = ("S", "M3D", "CPS", "CPE", "SFM3D")
KINDS = {
    "C3D4": "tetra",
    "C3D10": "tetra10",
    "C3D6": "wedge",
    "C3D15": "wedge15",
    "C3D8": "hexahedron",
    "C3D20": "hexahedron20",
    **{f"{family}3": "triangle" for family in (*_SHELLS, "STRI", "R3D")},
    **{f"{family}4": "quad" for family in (*_SHELLS, "R3D")},
    **{f"{family}6": "triangle6" for family in _SHELLS},
    **{f"{family}8": "quad8" for family in _SHELLS},
}
"""Kinds of elements by type, without the letters for their integration at the end."""
FACES = {4: (3, 0, 1, 2), 6: (0, 1, 2, 3, 4), 8: (4, 5, 2, 1, 3, 0)}
"""Where the faces S1, S2, ... of a solid with so many corners stand among those of its kind."""


@dataclass(frozen=True, eq=False)
class Deck:
    """Nodes (n,) at their places (n, 3), elements (m, k) by kind, and node sets by name."""

    ids: Integers
    points: Array
    facets: Mapping[str, Integers]
    sets: Mapping[str, Integers]


def read_node_sets(path: Path | str) -> Deck:
    """Return what an input deck says of nodes, elements and sets.

    Raises ``FileError`` for numbers that cannot be read, for names that are not there, and for
    decks of several parts, whose node numbers are not unique.
    """
    keywords: dict[str, list[Keyword]] = {}
    for keyword in read_keywords(Path(path)):
        keywords.setdefault(keyword.name, []).append(keyword)
    for second in keywords.get("INSTANCE", [])[1:]:
        raise second.error(
            "the deck has several parts, so that node numbers are not unique",
            "write a flat deck: *Preprint or 'Do not use parts and assemblies in input files'",
        )
    return _Reading(keywords).deck


def with_node_sets(file: FieldFile, deck: Deck) -> FieldFile:
    """Return a field with the deck's sets, and with its elements where it has none of its own."""
    return replace(file.with_sets(deck.sets), facets=file.facets or deck.facets)


class _Sets:
    """Numbers by name, upper and lower case alike; one name merges."""

    def __init__(self) -> None:
        self.numbers: dict[str, list[Integers]] = {}
        self.spelt: dict[str, str] = {}

    def add(self, name: str, numbers: Integers) -> None:
        spelt = self.spelt.setdefault(name.casefold(), name)
        self.numbers.setdefault(spelt, []).append(numbers)

    def get(self, name: str) -> Integers | None:
        spelt = self.spelt.get(name.casefold())
        return None if spelt is None else np.concatenate(self.numbers[spelt])

    def merged(self) -> dict[str, Integers]:
        return {name: np.unique(np.concatenate(parts)) for name, parts in self.numbers.items()}


class _Reading:
    """The content of a deck: nodes and elements first, so that sets can refer to them."""

    def __init__(self, keywords: Mapping[str, list[Keyword]]) -> None:
        self.node_sets, self.element_sets = _Sets(), _Sets()
        self.elements: dict[str, list[Integers]] = {}
        nodes = [self._nodes(keyword) for keyword in keywords.get("NODE", [])]
        table = np.concatenate([np.empty((0, 4)), *nodes])
        self.ids = table[:, 0].astype(np.int64)
        for keyword in keywords.get("ELEMENT", []):
            self._elements(keyword)
        for keyword in keywords.get("ELSET", []):
            self._numbers(keyword, self.element_sets)
        for keyword in keywords.get("NSET", []):
            self._node_set(keyword)
        for keyword in keywords.get("SURFACE", []):
            self._surface(keyword)
        self.deck = Deck(
            self.ids,
            table[:, 1:],
            {kind: np.concatenate(parts)[:, 1:] for kind, parts in self.elements.items()},
            self.node_sets.merged(),
        )

    def _nodes(self, keyword: Keyword) -> Array:
        """Return numbers and coordinates (n, 4); coordinates that are left out are zero."""
        rows = [[*row, "0", "0"][:4] for row in keyword.rows()]
        try:
            table = np.array(rows, dtype=float).reshape(-1, 4)
            _whole(keyword, [row[0] for row in rows])
        except ValueError:
            raise keyword.error(
                "a line is not a node number and its coordinates", "write 7, 1.0, 0.0, 2.5"
            ) from None
        if "NSET" in keyword.options:
            self.node_sets.add(keyword.options["NSET"], table[:, 0].astype(np.int64))
        return table

    def _elements(self, keyword: Keyword) -> None:
        """Keep the elements of a known kind, their numbers in front."""
        kind = KINDS.get(keyword.options.get("TYPE", "").upper().rstrip("RIHMTSE"))
        if kind is None:
            return
        width = 1 + ELEMENTS[kind].size
        words = [word for row in keyword.rows() for word in row]
        if len(words) % width:
            raise keyword.error(
                f"elements of type {keyword.options['TYPE']} have {width - 1} nodes, "
                "and the lines do not hold so many each",
                "the deck is cut off or damaged: export it again",
            )
        rows = _whole(keyword, words).reshape(-1, width)
        self.elements.setdefault(kind, []).append(rows)
        if "ELSET" in keyword.options:
            self.element_sets.add(keyword.options["ELSET"], rows[:, 0])

    def _node_set(self, keyword: Keyword) -> None:
        """Keep a node set, which may be given by the elements of an element set."""
        if "ELSET" in keyword.options:
            numbers = self._known(keyword, self.element_sets, keyword.options["ELSET"])
            self.node_sets.add(_name(keyword, "NSET"), self._nodes_of(numbers))
        else:
            self._numbers(keyword, self.node_sets)

    def _numbers(self, keyword: Keyword, sets: _Sets) -> None:
        """Keep a set of numbers, of ranges, or of other sets."""
        name = _name(keyword, keyword.name)
        parts = [np.empty(0, np.int64)]
        if "GENERATE" in keyword.options:
            ranges = [_generated(keyword, row) for row in keyword.rows()]
            parts += [self._there(numbers, sets) for numbers in ranges]
        else:
            words = [word for row in keyword.rows() for word in row]
            named = [word for word in words if not word.lstrip("+").isdigit()]
            parts += [self._known(keyword, sets, word) for word in named]
            parts.append(_whole(keyword, [word for word in words if word.lstrip("+").isdigit()]))
        sets.add(name, np.concatenate(parts))

    def _there(self, numbers: Integers, sets: _Sets) -> Integers:
        """Return the numbers of a range that the deck has; all where it defines no nodes."""
        if sets is self.node_sets and len(self.ids):
            return np.intersect1d(numbers, self.ids)
        return numbers

    def _surface(self, keyword: Keyword) -> None:
        """Keep the nodes of a surface of nodes or of faces of elements."""
        kind = keyword.options.get("TYPE", "ELEMENT").upper()
        if kind not in ("NODE", "ELEMENT"):
            return
        name = _name(keyword, "NAME")
        parts = [np.empty(0, np.int64)]
        for first, *rest in keyword.rows():
            sets = self.node_sets if kind == "NODE" else self.element_sets
            numbers = (
                _whole(keyword, [first]) if first.isdigit() else self._known(keyword, sets, first)
            )
            label = rest[0].upper() if rest else ""
            parts.append(numbers if kind == "NODE" else self._nodes_of(numbers, label))
        self.node_sets.add(name, np.unique(np.concatenate(parts)))

    def _nodes_of(self, numbers: Integers, label: str = "") -> Integers:
        """Return the nodes of elements, or of their face such as ``S3``."""
        nodes = [np.empty(0, np.int64)]
        for kind, blocks in self.elements.items():
            element = ELEMENTS[kind]
            order = FACES.get(element.corners, ()) if element.dimension == 3 else ()
            corners: tuple[int, ...] = tuple(range(element.size))
            if label[:1] == "S" and label[1:].isdigit() and 0 < int(label[1:]) <= len(order):
                corners = element.faces[order[int(label[1:]) - 1]][1]
            for rows in blocks:
                wanted = rows[np.isin(rows[:, 0], numbers), 1:]
                nodes.append(wanted[:, corners].ravel())
        return np.unique(np.concatenate(nodes))

    def _known(self, keyword: Keyword, sets: _Sets, name: str) -> Integers:
        """Return the numbers of a set that is there already."""
        numbers = sets.get(name)
        if numbers is None:
            raise keyword.error(
                f"there is no set '{name[:80]}' above, and it is no whole number",
                "define the set first, and give also the file that holds it",
            )
        return numbers


def _name(keyword: Keyword, option: str) -> str:
    """Return the name that a set must have."""
    name = keyword.options.get(option, "")
    if not name:
        raise keyword.error("the set has no name", f"write *{keyword.name}, {option}=TIP")
    return name


def _whole(keyword: Keyword, words: list[str]) -> Integers:
    """Return whole numbers."""
    try:
        return np.array(words, dtype=np.str_).astype(np.int64)
    except (ValueError, OverflowError):
        wrong = next((word for word in words if not word.isdigit()), max(words, key=len))
        raise keyword.error(
            f"'{wrong[:80]}' is not the number of a node or an element",
            "the deck is cut off or damaged: export it again",
        ) from None


def _generated(keyword: Keyword, row: list[str]) -> Integers:
    """Return the numbers of a line ``first, last, step``, the step being one if left out."""
    first, last, step = (_whole(keyword, row).tolist() + [1] * 3)[:3] if len(row) > 1 else (1, 0, 1)
    if not (0 < first <= last and step > 0 and (last - first) // step < MOST_GENERATED):
        raise keyword.error(
            f"'{', '.join(row)[:80]}' is no range", "write first, last, step, such as 1, 99, 2"
        )
    return np.arange(first, last + 1, step)
