"""The directive ``room``: the public names of a package, each documented in one place.

A name that several packages pass on is documented where users are to take it from: in `stiffkit`
itself if it is there, else in the package that it is written in. The others refer to that place.
"""

from __future__ import annotations

import ast
import inspect
import re
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from docutils import nodes  # type: ignore[import-untyped]
from docutils.statemachine import StringList  # type: ignore[import-untyped]
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer
from sphinx.util.docutils import SphinxDirective
from sphinx.util.inspect import TypeAliasForwardRef
from sphinx.util.nodes import find_pending_xref_condition
from sphinx.util.typing import ExtensionMetadata

_TOP = "stiffkit"
_LONGEST_VALUE = 90

# Bars, asterisks, underscores behind words, and addresses of other kinds than those of pages.
_MARKUP = re.compile(r"[|*]|(?<=\w)_(?!\w)|(?<!http)(?<!https):(?=//)")


@cache
def _imports(package: str) -> dict[str, str]:
    """Return the modules that the public names of a package are imported from."""
    file = import_module(package).__file__
    tree = ast.parse(Path(file).read_text("utf-8")) if file else ast.Module([], [])
    return {
        alias.asname or alias.name: node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }


def written_in(package: str, name: str) -> str:
    """Return the module that a public name of a package is written in."""
    while name in _imports(package):
        package = _imports(package)[name]
        if not hasattr(import_module(package), "__path__"):
            break
    return package


def home_of(package: str, name: str) -> str:
    """Return the package whose page documents a public name."""
    if name in import_module(_TOP).__all__:
        return _TOP
    module = written_in(package, name)
    while name not in getattr(import_module(module), "__all__", ()):
        if "." not in module:
            return package
        module = module.rpartition(".")[0]
    return module


def _entry(package: str, name: str) -> list[str]:
    """Return the lines that document one name."""
    value = getattr(import_module(package), name)
    if inspect.isclass(value):
        return [f".. autoclass:: {package}.{name}", ""]
    if inspect.isroutine(value):
        return [f".. autofunction:: {package}.{name}", ""]
    return _data(package, name, value)


def _data(package: str, name: str, value: Any) -> list[str]:
    written = ModuleAnalyzer.for_module(written_in(package, name)).find_attr_docs()
    docstring = [as_prose(line) for line in written.get(("", name), [])]
    lines = [f".. py:data:: {name}", f"   :module: {package}"]
    shown = repr(value)
    if len(shown) <= _LONGEST_VALUE and " at 0x" not in shown:
        lines.append(f"   :value: {shown}")
    return [*lines, "", *(f"   {line}" for line in docstring), ""]


class _Room(SphinxDirective):
    """The public names of one package."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the documentation of the names, and references to those documented elsewhere."""
        package = self.arguments[0]
        public = getattr(import_module(package), "__all__", [])
        names = [name for name in public if name != "__version__"]
        names.sort(key=str.lower)
        here = [name for name in names if home_of(package, name) == package]
        lines = [f".. automodule:: {package}", "   :no-members:", ""]
        elsewhere = [f"`{home_of(package, name)}.{name}`" for name in names if name not in here]
        if here:
            lines += [" · ".join(f"`~{package}.{name}`" for name in here), ""]
        if elsewhere:
            lines += [f"Documented elsewhere: {', '.join(elsewhere)}.", ""]
        for name in here:
            lines += _entry(package, name)
        found = nodes.Element()
        self.state.nested_parse(StringList(lines, source=package), 0, found)
        return list(found.children)


def as_prose(line: str) -> str:
    """Return a line of a docstring, whose only markup is that of code, as reStructuredText."""
    parts = re.split(r"(``.+?``|`[^`]+`)", line)
    return "".join(part if i % 2 else _MARKUP.sub(r"\\\g<0>", part) for i, part in enumerate(parts))


def _prose(
    _app: Sphinx, _what: str, _name: str, _obj: Any, _options: Any, lines: list[str]
) -> None:
    """Make a docstring of prose one of reStructuredText."""
    if lines and lines[0].startswith("Alias for field number"):
        lines.clear()
    lines[:] = [as_prose(line) for line in lines]


def _left_out(
    _app: Sphinx, _what: str, name: str, obj: Any, _skip: bool, _options: Any
) -> bool | None:
    """Leave out constructors without words of their own: those of dataclasses take all fields."""
    generated = name == "__init__" and not obj.__doc__
    return True if generated or name in {"__new__", "__post_init__"} else None


def _own_types_only(_app: Sphinx, doctree: nodes.document) -> None:
    """Look up no types of other packages: they have no pages here, and there are thousands."""
    for node in list(doctree.findall(pending_xref)):
        target = node["reftarget"]
        if node.get("refdomain") == "py" and node["reftype"] == "class" and _TOP not in target:
            shown = find_pending_xref_condition(node, "resolved") or node
            node.replace_self(shown.children)


def _by_name(alias: TypeAliasForwardRef) -> str:
    return alias.name


def setup(app: Sphinx) -> ExtensionMetadata:
    """Add the directive."""
    app.add_directive("room", _Room)
    # Inside generic types of the standard library Sphinx prints type aliases by this.
    TypeAliasForwardRef.__repr__ = _by_name  # type: ignore[method-assign]
    app.connect("autodoc-process-docstring", _prose, priority=400)
    app.connect("autodoc-skip-member", _left_out)
    app.connect("doctree-read", _own_types_only)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
