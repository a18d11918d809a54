"""YAML text as a tree of plain values, each with the line it stands on.

The tree is built from PyYAML's events instead of its objects: no tag makes anything run, nothing
recurses, and the size of what aliases expand to is known before it is expanded.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import yaml

from stiffkit.errors import FileError
from stiffkit.files.source import Source
from stiffkit.units import shorten

MOST_NODES = 20_000
"""Values in a file, aliases expanded."""
DEEPEST = 24
"""Levels of nesting."""

Scalar = str | int | float | bool | None
Plain = Scalar | list["Plain"] | dict[str, "Plain"]

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class Node:
    """A value of the file: a mapping, a list or a scalar."""

    value: dict[str, Node] | list[Node] | Scalar
    line: int
    """From 1; of a mapping's value, the line of its key."""
    size: int = 1
    """Values in it, itself included."""
    depth: int = 1
    """Levels in it, itself included."""

    def plain(self) -> Plain:
        """Return the value without the lines."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value

    def child(self, key: str | int) -> Node | None:
        """Return the value under a key or an index, None where there is none."""
        if isinstance(self.value, dict) and isinstance(key, str):
            return self.value.get(key)
        if isinstance(self.value, list) and isinstance(key, int) and key < len(self.value):
            return self.value[key]
        return None


def read_tree(source: Source, begin: str = "robot: TITLE") -> Node:
    """Return the tree of a YAML text, whose first line is like ``begin``.

    Values are what they look like: numbers are decimal (``1e5`` and ``010`` included), only
    ``true``, ``false``, ``null``, ``~`` and nothing at all are special, and whatever else is text.
    Raises FileError at syntax errors, duplicate keys, tags, and where the text is too deep or
    expands to too much.
    """
    builder = _Builder(source)
    try:
        for event in yaml.parse(source.text, Loader=_Loader):
            builder.take(event)
    except (yaml.YAMLError, ValueError) as error:
        raise _syntax_error(source, error) from None
    if builder.root is None:
        raise FileError("is empty", path=source.path, mend=f"begin with '{begin}'")
    return builder.root


class _Open:
    """A mapping or a list whose end has not come yet."""

    def __init__(self, *, is_mapping: bool, line: int, anchor: str | None) -> None:
        self.is_mapping = is_mapping
        self.line = line
        self.anchor = anchor
        self.children: list[Node] = []
        self.entries: dict[str, Node] = {}
        self.key: tuple[str, int] | None = None
        self.size = 1
        self.depth = 1

    def close(self) -> Node:
        value = self.entries if self.is_mapping else self.children
        return Node(value, self.line, self.size, self.depth)


class _Builder:
    """Takes the events of a YAML text one by one."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.root: Node | None = None
        self.stack: list[_Open] = []
        self.anchors: dict[str, Node] = {}

    def error(self, what: str, line: int, mend: str = "") -> FileError:
        keys = [opened.key[0] for opened in self.stack if opened.key]
        return FileError(
            what, path=self.source.path, line=line, key=shorten(".".join(keys)), mend=mend
        )

    def take(self, event: yaml.Event) -> None:
        line = 1 if event.start_mark is None else event.start_mark.line + 1
        match event:
            case yaml.DocumentStartEvent() if self.root is not None:
                raise self.error("a second document begins here", line, "keep one in a file")
            case yaml.AliasEvent():
                self.put(self.aliased(event.anchor, line))
            case yaml.ScalarEvent():
                self.refuse_tag(event, line)
                self.refuse_control_characters(event.value, line)
                is_unquoted = event.implicit[0]
                scalar = read_scalar(event.value) if is_unquoted else event.value
                node = Node(scalar, line)
                self.remember(event.anchor, node)
                self.put(node, key_text=event.value)
            case yaml.MappingStartEvent() | yaml.SequenceStartEvent():
                self.refuse_tag(event, line)
                self.open(event, line)
            case yaml.MappingEndEvent() | yaml.SequenceEndEvent():
                closed = self.stack.pop()
                node = closed.close()
                self.remember(closed.anchor, node)
                self.put(node)

    def refuse_tag(self, event: yaml.NodeEvent, line: int) -> None:
        tag = getattr(event, "tag", None)
        if tag is not None:
            raise self.error(
                f"the tag '{shorten(tag)}' is not allowed", line, "write the value without a tag"
            )

    def refuse_control_characters(self, text: str, line: int) -> None:
        if _CONTROL.search(text):
            raise self.error("a text holds a control character", line, "remove it")

    def open(self, event: yaml.CollectionStartEvent, line: int) -> None:
        if len(self.stack) >= DEEPEST:
            raise self.error(f"nested more than {DEEPEST} levels deep", line)
        if self.stack and self.stack[-1].is_mapping and self.stack[-1].key is None:
            raise self.error(
                "a key is a list or a mapping", line, "write names and texts with { } in quotes"
            )
        is_mapping = isinstance(event, yaml.MappingStartEvent)
        self.stack.append(_Open(is_mapping=is_mapping, line=line, anchor=event.anchor))

    def remember(self, anchor: str | None, node: Node) -> None:
        if anchor is not None:
            self.anchors[anchor] = node

    def aliased(self, anchor: str | None, line: int) -> Node:
        if any(opened.anchor == anchor for opened in self.stack):
            raise self.error(f"the alias '*{anchor}' lies in what it stands for", line)
        if anchor is None or anchor not in self.anchors:
            raise self.error(
                f"the alias '*{anchor}' stands for nothing",
                line,
                "a text that begins with '*' goes in quotes",
            )
        return replace(self.anchors[anchor], line=line)

    def put(self, node: Node, key_text: str | None = None) -> None:
        """Give a finished value to the collection it stands in."""
        if not self.stack:
            self.root = node
            return
        parent = self.stack[-1]
        if parent.is_mapping and parent.key is None:
            parent.key = (self.key(node, key_text), node.line)
            return
        parent.size += node.size
        parent.depth = max(parent.depth, node.depth + 1)
        if parent.size > MOST_NODES:
            raise self.error(
                f"holds more than {MOST_NODES} values",
                node.line,
                "write them out without aliases of aliases, or use 'repeat'",
            )
        if len(self.stack) + node.depth > DEEPEST + 1:
            raise self.error(
                f"nested more than {DEEPEST} levels deep", node.line, "nothing needs so many"
            )
        if parent.key is None:
            parent.children.append(node)
        else:
            key, line = parent.key
            parent.entries[key] = replace(node, line=line)
            parent.key = None

    def key(self, node: Node, key_text: str | None) -> str:
        if key_text is None and isinstance(node.value, dict | list):
            raise self.error("a key is a list or a mapping", node.line)
        # A key is the text that was typed, whatever value it looks like.
        key = str(node.value) if key_text is None else key_text
        if "\n" in key:
            raise self.error("a key holds a line break", node.line)
        earlier = self.stack[-1].entries.get(key)
        if earlier is not None:
            raise self.error(
                f"the key '{shorten(key)}' stands here a second time (first in line "
                f"{earlier.line})",
                node.line,
                "rename or remove one of the two",
            )
        return key


# Escapes in double quotes can make them; on a terminal they do harm.
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_SPECIAL: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_LONGEST_NUMBER = 100


def read_scalar(text: str) -> Scalar:
    """Return what a plain scalar says: a number, a truth value, nothing, or text."""
    if text in _SPECIAL:
        return _SPECIAL[text]
    if len(text) <= _LONGEST_NUMBER and _NUMBER.fullmatch(text):
        is_whole = text.lstrip("+-").isdecimal()
        return int(text) if is_whole else float(text)
    return text


def _syntax_error(source: Source, error: Exception) -> FileError:
    mark = getattr(error, "problem_mark", None)
    problem = getattr(error, "problem", None) or getattr(error, "reason", None) or "cannot be read"
    context = getattr(error, "context", None)
    told = f" ({context})" if context else ""
    return FileError(
        f"is not valid YAML: {problem}{told}",
        path=source.path,
        line=None if mark is None else mark.line + 1,
        mend=next((mend for sign, mend in _MENDS if sign in problem), ""),
    )


_MENDS = (
    ("\\t", "indent with spaces, not with tabs"),
    ("cannot start any token", "indent with spaces, not with tabs, and put odd texts in quotes"),
    ("mapping values are not allowed", "check the indentation, and put texts with ': ' in quotes"),
    ("expected <block end>", "check the indentation of this line and the lines before it"),
    ("unexpected ':'", "write a space after ':', and then a value, if only {}"),
    ("did not find expected", "check brackets, quotes and the indentation of the lines before it"),
)
