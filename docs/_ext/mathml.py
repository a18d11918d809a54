"""Equations as MathML, which browsers draw themselves: no script, no font, no network."""

from __future__ import annotations

import re

from docutils import nodes  # type: ignore[import-untyped]
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata
from sphinx.writers.html5 import HTML5Translator

_OPENS = re.compile(r"<mo>(&#x0005B;)</mo>(?=<mtable>)")
_CLOSES = re.compile(r"(?<=</mtable>)<mo>(&#x0005D;)</mo>")


def mathml(latex: str, display: str) -> str:
    """Return an equation as MathML; brackets are as tall as the matrix between them."""
    text = convert(latex, display=display)
    text = _OPENS.sub(r'<mrow><mo form="prefix" stretchy="true">\1</mo>', text)
    return _CLOSES.sub(r'<mo form="postfix" stretchy="true">\1</mo></mrow>', text)


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(writer: HTML5Translator, node: nodes.math_block) -> None:
    writer.body.append(f'<div class="math">{mathml(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> ExtensionMetadata:
    """Add the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
