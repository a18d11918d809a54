"""What the parts of a robot file were read as, for robots that differ in a few parameters.

A part is read again only if a parameter changes that stands in it. What comes out is what reading
it would give: the very same object.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any, TypeVar

from stiffkit.errors import ExpressionError
from stiffkit.files.entry import Entry
from stiffkit.files.expressions import Expression, is_expression
from stiffkit.files.tree import Node

T = TypeVar("T")

_MOST_KEPT = 200
"""Variants of a part that are kept."""


class PartMemo:
    """Parts of one file by their names and by what the parameters in them are."""

    def __init__(self) -> None:
        """Begin with none."""
        self._names: dict[str, list[tuple[str, ...]]] = {}
        self._read: dict[str, OrderedDict[Hashable, Any]] = {}

    def get(
        self, part: str, entries: Iterable[Entry], read: Callable[[], T], *other: Hashable
    ) -> T:
        """Return what ``read`` gives for a part, or gave when all that it depends on was the same.

        ``entries`` are all places that the part is read from; ``other`` is what else it depends on.
        """
        entries = list(entries)
        if part not in self._names:
            self._names[part] = [tuple(sorted(set(names_in(entry)))) for entry in entries]
        values = (
            entry.scope.values.get(name)
            for entry, names in zip(entries, self._names[part], strict=True)
            for name in names
        )
        key = (*(None if value is None else (value.si, value.dims) for value in values), *other)
        known = self._read.setdefault(part, OrderedDict())
        if key not in known:
            known[key] = read()
            if len(known) > _MOST_KEPT:
                known.popitem(last=False)
        result: T = known[key]
        return result


def names_in(entry: Entry) -> Iterator[str]:
    """Yield the names that stand in the expressions of an entry."""
    for text in _texts(entry.node):
        filled = entry.fill(text)
        if is_expression(filled):
            try:
                yield from Expression(filled).names
            except ExpressionError:
                # Whoever reads the part is told so, at its place.
                continue


def _texts(node: Node) -> Iterator[str]:
    if isinstance(node.value, str):
        yield node.value
    elif isinstance(node.value, dict):
        for child in node.value.values():
            yield from _texts(child)
    elif isinstance(node.value, list):
        for child in node.value:
            yield from _texts(child)
