"""Changing single values in the text of a YAML file: comments, order and all else stay."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import yaml

from stiffkit.errors import FileError
from stiffkit.files.names import Key, key_path
from stiffkit.files.source import Source
from stiffkit.files.tree import read_tree

Keys = tuple[Key, ...]

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_QUOTES = ("'", '"')

_PLAIN = re.compile(r"(?:= )?[\w.+/-][\w.+/*^()°·²³-]*( [\w.+/*^()°·²³-]+)*")
"""What is text wherever it stands, in quotes of any kind and without them."""

_COMMENT_BEHIND = re.compile(r" {2,}(?=#)")


def replace_values(source: Source, values: Mapping[Keys, str]) -> str:
    """Return the text of a file with other scalars under some paths of keys.

    A value that stands in quotes keeps them, and a comment behind a value its column where there is
    room. Raises FileError where nothing stands under such a path, where it is no scalar,
    and where the value is shared with other places by an anchor, or comes from one.
    """
    # What is no valid file is told by the reader that knows how to tell it.
    read_tree(source)
    places = _scalars(source.text)
    edits = []
    for keys, value in values.items():
        place = places.get(keys)
        if place is None:
            raise FileError(
                "there is no value here that could be replaced",
                path=source.path,
                key=key_path(keys),
                mend="write it out as a plain value, without anchors and aliases",
            )
        edits.append((place, value))
    text = source.text
    # From the end, so that the places before it stay where they are.
    for place, value in sorted(edits, key=lambda edit: edit[0].start, reverse=True):
        text = _replaced(text, place, value)
    return text


@dataclass(frozen=True)
class _Place:
    """Where a scalar stands in a text."""

    start: int
    end: int
    quote: str
    """The sign that it is quoted by, or nothing."""


def _replaced(text: str, place: _Place, value: str) -> str:
    old = text[place.start : place.end]
    new = _written(value, place.quote)
    behind = text[place.end :]
    if comment := _COMMENT_BEHIND.match(behind):
        blanks = max(2, len(old) + comment.end() - len(new))
        behind = " " * blanks + behind[comment.end() :]
    # A block of text ends with its line breaks.
    line_breaks = old[len(old.rstrip()) :]
    return text[: place.start] + new + line_breaks + behind


def _written(value: str, quote: str) -> str:
    """Return a scalar that says ``value``, in the quotes that it had before if that can be."""
    if _PLAIN.fullmatch(value):
        return f"{quote}{value}{quote}"
    return "'{}'".format(value.replace("'", "''"))


@dataclass
class _Open:
    """A mapping or a list whose end has not come yet."""

    keys: Keys
    is_mapping: bool
    key: str | None = None
    """Of a mapping, the key whose value comes next."""
    count: int = 0
    """Of a list, the values before the one that comes next."""

    def next_keys(self) -> Keys:
        """Return the path of the value that comes now."""
        if not self.is_mapping:
            self.count += 1
            return (*self.keys, self.count - 1)
        key, self.key = self.key, None
        return (*self.keys, key or "")


@dataclass
class _Finder:
    """Takes the events of a valid YAML text one by one."""

    places: dict[Keys, _Place] = field(default_factory=dict)
    stack: list[_Open] = field(default_factory=list)

    def take(self, event: yaml.Event) -> None:
        match event:
            case yaml.MappingStartEvent() | yaml.SequenceStartEvent():
                is_mapping = isinstance(event, yaml.MappingStartEvent)
                self.stack.append(_Open(self.next_keys(), is_mapping))
            case yaml.MappingEndEvent() | yaml.SequenceEndEvent():
                self.stack.pop()
            case yaml.ScalarEvent() if self.is_key():
                self.stack[-1].key = event.value
            case yaml.AliasEvent() if self.is_key():
                self.stack[-1].key = f"*{event.anchor}"
            case yaml.AliasEvent():
                self.next_keys()
            case yaml.ScalarEvent():
                self.put(self.next_keys(), event)

    def put(self, keys: Keys, event: yaml.ScalarEvent) -> None:
        """Remember where a scalar stands, if it can be replaced there."""
        start, end = event.start_mark, event.end_mark
        if event.anchor is not None or start is None or end is None:
            return
        # Where nothing is written there is nothing to replace.
        if end.index > start.index:
            style = event.style or ""
            self.places[keys] = _Place(start.index, end.index, style if style in _QUOTES else "")

    def is_key(self) -> bool:
        return bool(self.stack) and self.stack[-1].is_mapping and self.stack[-1].key is None

    def next_keys(self) -> Keys:
        return self.stack[-1].next_keys() if self.stack else ()


def _scalars(text: str) -> dict[Keys, _Place]:
    """Return where each scalar stands that has no anchor and is no alias."""
    finder = _Finder()
    for event in yaml.parse(text, Loader=_Loader):
        finder.take(event)
    return finder.places
