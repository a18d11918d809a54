"""The links and joints of a robot file as it stands, repeated sections written out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from stiffkit.files.entry import Entry, Scope
from stiffkit.files.expressions import RESERVED_NAMES, is_expression
from stiffkit.robot.model import BASE

MOST_PARTS = 500
"""Links, and joints, of one robot."""


def read_parts(root: Entry, section: str) -> dict[str, Entry]:
    """Return the ``links`` or the ``joints`` by name, in the order of the file.

    Those of repeated sections come after the plain ones. Raises FileError where a name stands
    twice or is reserved, and at wrong repeated sections.
    """
    parts: dict[str, Entry] = {}
    for name, entry in _all_parts(root, section):
        if name in parts:
            raise entry.error(
                f"the name '{name}' is used twice (first in line {parts[name].node.line})",
                "rename one of the two",
            )
        if section == "links" and name == BASE:
            raise entry.error(
                f"'{BASE}' is the name of the body that stands still", "choose another name"
            )
        if not set(name).isdisjoint("{}"):
            raise entry.error(
                f"the name '{name}' has braces", "variables are known in 'repeat' sections only"
            )
        parts[name] = entry
        if len(parts) > MOST_PARTS:
            raise entry.error(f"these are more than {MOST_PARTS} {section}")
    return parts


def _all_parts(root: Entry, section: str) -> Iterator[tuple[str, Entry]]:
    if (plain := root.get(section)) is not None:
        yield from plain.items()
    if (repeat := root.get("repeat")) is not None:
        for repeated in repeat.elements():
            for scope in _rounds(repeated["for"]):
                if (parts := repeated.get(section)) is not None:
                    yield from replace(parts, scope=scope).items()


def _rounds(entry: Entry) -> Iterator[Scope]:
    """Yield a scope for each round of a repeated section."""
    variables = dict(entry.items())
    lengths = {name: len(values.elements()) for name, values in variables.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        raise entry.error(
            f"the lists differ in length: {listed}", "give one value of each for each round"
        )
    for name, values in variables.items():
        if name in entry.scope.values or name in RESERVED_NAMES:
            raise values.error(f"the name '{name}' is taken already", "choose another name")
    for index in range(min(lengths.values())):
        yield _round({name: values[index] for name, values in variables.items()}, entry.scope)


def _round(entries: Mapping[str, Entry], scope: Scope) -> Scope:
    texts = {name: entry.text() for name, entry in entries.items()}
    values = {name: entry.value() for name, entry in entries.items() if not _is_word(entry)}
    return Scope({**scope.values, **values}, texts)


def _is_word(entry: Entry) -> bool:
    """Tell whether a value is a word such as "left", which only stands in names and texts."""
    text = entry.text()
    return text[:1].isalpha() and not is_expression(text)
