"""The directive ``file-keys``: every key of a kind of file, from the JSON Schema that checks it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any

from docutils import nodes  # type: ignore[import-untyped]
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.typing import ExtensionMetadata

Schema = Mapping[str, Any]

SCHEMAS = {
    "robot": ("stiffkit.robot", "schema.json"),
    "link": ("stiffkit.link", "schema.json"),
    "cad": ("stiffkit.fea", "schema.json"),
    "identify": ("stiffkit.identify", "schema.json"),
    "study": ("stiffkit.study", "schema.json"),
    "design": ("stiffkit.design", "schema.json"),
    "uncertainty": ("stiffkit.design.uncertainty", "schema.json"),
}
"""Package and file of each schema."""

_SI = {
    "length": "m",
    "angle": "rad",
    "length or angle": "m or rad",
    "mass": "kg",
    "inertia": "kg m²",
    "density": "kg/m³",
    "force": "N",
    "moment": "N m",
    "pressure": "Pa",
    "area": "m²",
    "second moment of area": "m⁴",
    "stiffness": "N/m or N m/rad",
    "translational stiffness": "N/m",
    "rotational stiffness": "N m/rad",
    "compliance": "m/N, 1/N, rad/(N m)",
}

# An apostrophe stands behind a letter.
_QUOTED = re.compile(r"(?<!\w)'([^']+)'(?!\w)")

_WORDS = {
    "object": "mapping",
    "array": "list",
    "string": "text",
    "number": "number",
    "integer": "whole number",
    "boolean": "true or false",
}


def read_schema(kind: str) -> dict[str, Any]:
    """Return the schema of a kind of file."""
    package, name = SCHEMAS[kind]
    schema: dict[str, Any] = json.loads(files(package).joinpath(name).read_text("utf-8"))
    return schema


def anchor(kind: str, *path: str) -> str:
    """Return the anchor of a key, or of a part of the schema that is used by name."""
    return str(nodes.make_id("-".join([kind, *path])))


class _Keys:
    """Writes the schema of one kind of file."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.schema = read_schema(kind)
        self.parts: Mapping[str, Schema] = self.schema.get("$defs", {})

    def sections(self) -> Iterator[nodes.section]:
        """Yield a section for the file, for each part with keys, and for kinds of values."""
        yield self.section("The file", self.schema, ())
        order = self.in_order_of_use()
        for name in order:
            if "properties" in self.parts[name]:
                yield self.section(name.replace("_", " "), self.parts[name], (name,))
        yield self.values([name for name in order if "properties" not in self.parts[name]])

    def in_order_of_use(self) -> list[str]:
        order: list[str] = []

        def visit(node: Any) -> None:
            if isinstance(node, list):
                for one in node:
                    visit(one)
            if not isinstance(node, dict):
                return
            if "$ref" in node and (name := _target(node)) not in order:
                order.append(name)
                visit(self.parts[name])
            for key, one in node.items():
                if key not in {"$defs", "examples", "default", "enum"}:
                    visit(one)

        visit(self.schema)
        return order

    def section(self, title: str, node: Schema, path: tuple[str, ...]) -> nodes.section:
        name = anchor(self.kind, *path) if path else anchor(self.kind, "the file")
        section = nodes.section(ids=[name], names=[name])
        section += nodes.title("", title)
        section += self.text(node)
        section += self.keys(node, path)
        return section

    def values(self, names: list[str]) -> nodes.section:
        """Return a section of the parts that have no keys."""
        name = anchor(self.kind, "kinds of values")
        section = nodes.section(ids=[name], names=[name])
        section += nodes.title("", "Kinds of values")
        items = nodes.definition_list(classes=["keys"])
        for one in names:
            items += self.item(one, self.parts[one], (one,), required=False)
        section += items
        return section

    def keys(self, node: Schema, path: tuple[str, ...]) -> nodes.definition_list:
        items = nodes.definition_list(classes=["keys"])
        for key, value in node["properties"].items():
            items += self.item(key, value, (*path, key), required=key in node.get("required", ()))
        return items

    def item(
        self, key: str, value: Schema, path: tuple[str, ...], *, required: bool
    ) -> nodes.definition_list_item:
        name = anchor(self.kind, *path)
        term = nodes.term(ids=[name])
        term += [nodes.literal(key, key), nodes.Text(" ")]
        term += nodes.inline("", "", *self.sort(value), classes=["key-kind"])
        if required:
            term += [nodes.Text(" "), nodes.inline("", "required", classes=["key-required"])]
        link = nodes.reference("", "¶", refid=name, internal=True, classes=["headerlink"])
        link["reftitle"] = "Link to this key"
        term += link
        body = nodes.definition()
        body += self.text(value)
        if "properties" in value:
            body += self.keys(value, path)
        inner = value.get("additionalProperties")
        if isinstance(inner, dict) and "properties" in inner:
            body += self.keys(inner, path)
        return nodes.definition_list_item("", term, body)

    def text(self, node: Schema) -> list[nodes.Node]:
        """Return description, default, bounds and an example."""
        found: list[nodes.Node] = [nodes.paragraph("", "", *_words(node["description"]))]
        facts = nodes.paragraph(classes=["key-facts"])
        if "default" in node:
            default = json.dumps(node["default"]).strip('"').replace('"', "")
            facts += [nodes.Text("Default: "), nodes.literal(default, default), nodes.Text(". ")]
        if bounds := _bounds(node):
            facts += nodes.Text(f"{bounds}. ")
        if node.get("examples"):
            facts += nodes.Text("Example: " if len(node["examples"]) == 1 else "Examples: ")
            for i, example in enumerate(node["examples"]):
                facts += [nodes.Text(", " if i else ""), nodes.literal(example, example)]
        return [*found, facts] if facts.children else found

    def sort(self, node: Schema) -> list[nodes.Node]:
        """Return what kind of value stands there."""
        dimension = node.get("dimension", "")
        if "$ref" in node:
            name = _target(node)
            link = nodes.reference("", name.replace("_", " "), internal=True)
            link["refid"] = anchor(self.kind, name)
            return [link, nodes.Text(_of(dimension))]
        if "enum" in node:
            return [nodes.Text(" | ".join(map(str, node["enum"])))]
        if "const" in node:
            return [nodes.Text(json.dumps(node["const"]))]
        kinds = [node["type"]] if isinstance(node.get("type"), str) else list(node.get("type", []))
        if {"number", "string"} <= set(kinds):
            kinds = ["quantity", *(kind for kind in kinds if kind not in {"number", "string"})]
        found: list[nodes.Node] = []
        for i, kind in enumerate(kinds):
            found += [nodes.Text(" or " if i else ""), *self.one_kind(kind, node)]
        return [*found, nodes.Text(_of(dimension))]

    def one_kind(self, kind: str, node: Schema) -> list[nodes.Node]:
        words: nodes.Node = nodes.Text(_WORDS.get(kind, kind))
        inner = node.get({"array": "items", "object": "additionalProperties"}.get(kind, ""))
        if kind == "object" and "properties" in node:
            inner = None
        if not isinstance(inner, dict):
            return [words]
        if kind == "array" and {"properties", "required"} & set(node):
            return [words, nodes.Text(" of "), *self.sort(inner)]
        between = " of " if kind == "array" else " from names to "
        bare = {key: value for key, value in inner.items() if key != "dimension"}
        return [words, nodes.Text(between), *self.sort(bare if "dimension" in node else inner)]


def _words(description: str) -> list[nodes.Node]:
    """Return a description, what stands between single quotes as code."""
    parts = _QUOTED.split(description)
    return [nodes.literal(one, one) if i % 2 else nodes.Text(one) for i, one in enumerate(parts)]


def _target(node: Schema) -> str:
    return str(node["$ref"]).removeprefix("#/$defs/")


def _of(dimension: str) -> str:
    """Return a dimension in words, with its unit in SI."""
    if dimension in {"", "any"}:
        return ""
    unit = _SI.get(dimension)
    return f": {dimension} ({unit})" if unit else f": {dimension}"


def _bounds(node: Schema) -> str:
    """Return how many there may be, or how large the value may be."""
    low, high = node.get("minimum"), node.get("maximum")
    if low is not None and high is not None:
        return f"From {low} to {high}"
    low, high = node.get("minItems"), node.get("maxItems")
    if low is not None and high == low:
        return f"The list has {low} values"
    if low is not None and high is not None:
        return f"The list has {low} to {high} values"
    return ""


class _FileKeys(SphinxDirective):
    """Every key of one kind of file."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        return list(_Keys(self.arguments[0]).sections())


def setup(app: Sphinx) -> ExtensionMetadata:
    """Add the directive."""
    app.add_directive("file-keys", _FileKeys)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
