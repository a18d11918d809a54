"""The shape of a file: JSON Schema's findings in an engineer's words."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffkit.errors import FileError
from stiffkit.files.names import Key, key_path, suggest
from stiffkit.files.problems import raise_all
from stiffkit.files.tree import Node, Plain
from stiffkit.units import shorten

if TYPE_CHECKING:
    from jsonschema import Draft202012Validator
    from jsonschema.exceptions import ValidationError

_MOST_ERRORS = 5


def check_shape(root: Node, path: Path, schema_file: Path) -> None:
    """Check that a file has the keys and the kinds of values that its JSON Schema asks for.

    Raises FileError at the first wrong place, with the others in ``others``.
    """
    validator, schema = _validator(schema_file)
    errors = islice(validator.iter_errors(root.plain()), _MOST_ERRORS)
    found = [_Finding(error, root, path, schema).translate() for error in errors]
    raise_all(found)


@cache
def _validator(schema_file: Path) -> tuple[Draft202012Validator, Mapping[str, Any]]:
    # Slow to import, and not needed before the first file.
    from jsonschema import Draft202012Validator

    schema = json.loads(schema_file.read_text(encoding="utf-8"))
    return Draft202012Validator(schema), schema


def line_of(root: Node, keys: Iterable[Key]) -> int:
    """Return the line of the deepest value that exists along a path of keys."""
    node = root
    for key in keys:
        child = node.child(key)
        if child is None:
            break
        node = child
    return node.line


class _Finding:
    """One error of the schema, at its place in the file."""

    def __init__(
        self, error: ValidationError, root: Node, path: Path, schema: Mapping[str, Any]
    ) -> None:
        self.error = error
        self.root = root
        self.path = path
        self.schema = schema
        self.subschema: Any = error.schema
        self.value: Any = error.instance
        self.limit: Any = error.validator_value
        self.keys: list[Key] = list(error.absolute_path)

    def translate(self) -> FileError:
        match self.error.validator:
            case "additionalProperties":
                return self.unknown_key()
            case "required":
                return self.missing_key()
            case "pattern" | "maxLength" if "propertyNames" in self.error.absolute_schema_path:
                return self.wrong_name()
        return self.tell(self.words(), self.example())

    def tell(self, what: str, mend: str, *further: Key) -> FileError:
        keys = [*self.keys, *further]
        return FileError(
            what,
            path=self.path,
            line=line_of(self.root, keys),
            key=key_path(keys),
            mend=mend,
        )

    def unknown_key(self) -> FileError:
        known = self.subschema.get("properties", {})
        name = next(key for key in self.value if key not in known)
        return self.tell(f"unknown key '{shorten(name)}'", suggest(name, known), name)

    def missing_key(self) -> FileError:
        name = next(key for key in self.limit if key not in self.value)
        example = _example_of(self.subschema.get("properties", {}).get(name, {}), self.schema)
        return self.tell(f"'{name}' is missing", f"add it, for example '{example}'")

    def wrong_name(self) -> FileError:
        name = self.value
        return self.tell(
            f"'{shorten(name)}' is not allowed here", str(self.subschema["description"]), name
        )

    def words(self) -> str:
        """Say what is wrong with the value."""
        value, limit = self.value, self.limit
        match self.error.validator:
            case "type":
                return f"{_say(value)} stands here, {_expected(limit)} is expected"
            case "enum":
                return f"{_say(value)} stands here, it must be one of {', '.join(limit)}"
            case "const":
                return f"{_say(value)} stands here, only 'true' makes sense"
            case "minItems" | "maxItems":
                return f"the list has {len(value)} values, {self.length()} are expected"
            case "minProperties":
                return "nothing is given here, one of these is needed: " + self.choices()
            case "maxProperties":
                return f"{' and '.join(value)} are given, only one of them can stand here"
            case "minLength":
                return "the text is empty"
            case "uniqueItems":
                return "the values must differ"
        return shorten(self.error.message)

    def length(self) -> str:
        fewest = self.subschema.get("minItems", 0)
        most = self.subschema.get("maxItems")
        if most is None:
            return f"at least {fewest}"
        return f"{fewest}" if most == fewest else f"{fewest} to {most}"

    def choices(self) -> str:
        return ", ".join(self.subschema.get("properties", {})) or "a name"

    def example(self) -> str:
        example = self.nearest_example()
        return f"for example '{example}'" if example else ""

    def nearest_example(self) -> str:
        """Return the example of the innermost schema on the way to the error that has one.

        Beside a reference stands the example of the key; it is better than that of its target.
        """
        node: Any = self.schema
        example = ""
        # The path leaves out the references that it goes through.
        for step in self.error.absolute_schema_path:
            if "$ref" in node and step not in node:
                own = node.get("examples")
                node = _target(node["$ref"], self.schema)
                example = (own or node.get("examples") or [example])[0]
            node = node[step]
            if isinstance(node, dict) and "examples" in node:
                example = node["examples"][0]
        return example


def _target(reference: str, schema: Mapping[str, Any]) -> Mapping[str, Any]:
    target: Mapping[str, Any] = schema["$defs"][reference.removeprefix("#/$defs/")]
    return target


def _example_of(node: Mapping[str, Any], schema: Mapping[str, Any]) -> str:
    if "examples" not in node and "$ref" in node:
        node = _target(node["$ref"], schema)
    return str(node.get("examples", [""])[0])


_KINDS = {
    "object": "a mapping",
    "array": "a list",
    "string": "a text",
    "number": "a number",
    "boolean": "true or false",
}


def _expected(kinds: str | Sequence[str]) -> str:
    if isinstance(kinds, str):
        return _KINDS[kinds]
    if list(kinds) == ["number", "string"]:
        return "a quantity"
    return " or ".join(
        "a quantity" if kind == "number" else _KINDS[kind] for kind in kinds if kind != "string"
    )


def _say(value: Plain) -> str:
    match value:
        case None:
            return "nothing"
        case bool():
            return f"'{str(value).lower()}'"
        case dict():
            return "a mapping"
        case list():
            return "a list"
        case str():
            return f"the text '{shorten(value)}'"
    return f"the number {value:g}"
