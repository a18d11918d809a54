"""Pages as code hosts show them: equations in a line, and the pages of the folder above `docs`."""

from __future__ import annotations

import os
import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

MIRRORED = {
    "overview": "README.md",
    "changelog": "CHANGELOG.md",
    "contributing": "CONTRIBUTING.md",
}
"""Pages of the site that are files of the folder above."""

_INLINE_EQUATION = re.compile(r"\$(`[^`]+`)\$")
_LINK = re.compile(r"\]\((?!https:|#)([^)#\s]+)")


def _translate(app: Sphinx, docname: str, source: list[str]) -> None:
    docs = Path(app.srcdir)
    page = docs / docname
    if docname in MIRRORED:
        page = docs.parent / MIRRORED[docname]
        source[0] = page.read_text("utf-8")
        app.env.note_dependency(str(page))
    mirrors = {docs.parent / file: docs / f"{name}.md" for name, file in MIRRORED.items()}

    def in_site(match: re.Match[str]) -> str:
        target = (page.parent / match[1]).resolve()
        return f"]({os.path.relpath(mirrors.get(target, target), (docs / docname).parent)}"

    source[0] = _LINK.sub(in_site, _INLINE_EQUATION.sub(r"{math}\1", source[0]))


def setup(app: Sphinx) -> ExtensionMetadata:
    """Translate each page before it is read."""
    app.connect("source-read", _translate)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
