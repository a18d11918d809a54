"""Which parameters of a robot file follow from others, and which ones parts from CAD depend on."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass

from stiffkit.files.entry import Entry
from stiffkit.files.expressions import Expression, is_expression
from stiffkit.files.parameters import Given
from stiffkit.robot.memo import names_in
from stiffkit.robot.parts import read_parts


@dataclass(frozen=True)
class Dependence:
    """What hangs on the parameters of a robot file beside the robot's numbers."""

    following: frozenset[str]
    """Those that are expressions of others."""
    solved: frozenset[str]
    """Those with whose values a part from CAD is solved anew, which takes its time."""
    ranges: Mapping[str, tuple[float, float]]
    """SI, of those between whose ends a part from CAD was solved; it has no values outside."""


def dependence(root: Entry, given: Mapping[str, Given]) -> Dependence:
    """Return what depends on the parameters ``given`` in a file whose values are in scope."""
    behind = {name: _roots(name, given) for name in given}
    solved: set[str] = set()
    ranges: dict[str, tuple[float, float]] = {}
    for link in read_parts(root, "links").values():
        cad = link.get("cad")
        if cad is None:
            continue
        names = set(names_in(cad))
        if (materials := root.get("materials")) is not None:
            names |= set(names_in(materials))
        own = _ranges(cad)
        for name, (low, high) in own.items():
            before = ranges.get(name, (low, high))
            ranges[name] = max(low, before[0]), min(high, before[1])
        for name in names & given.keys():
            solved |= behind[name] - own.keys()
    following = frozenset(name for name, roots in behind.items() if roots != {name})
    return Dependence(following, frozenset(solved - following), ranges)


def _ranges(cad: Entry) -> dict[str, tuple[float, float]]:
    between = cad.get("between")
    if between is None:
        return {}
    ends = {name: [end.value().si for end in one.elements()] for name, one in between.items()}
    return {name: (min(values), max(values)) for name, values in ends.items()}


def _roots(name: str, given: Mapping[str, Given]) -> Set[str]:
    """Return the parameters that one follows from in the end; itself if from none."""
    text = given[name]
    if not (isinstance(text, str) and is_expression(text)):
        return {name}
    used = Expression(text).names & given.keys()
    return {root for other in used for root in _roots(other, given)} or {name}
