"""What all pages share: a head, a title, and scripts that need no other place."""

from __future__ import annotations

import re
from dataclasses import dataclass
from html import escape
from importlib import resources
from pathlib import Path
from string import Template

from stiffkit.errors import OutputError

_STATIC = "style-src 'unsafe-inline'; img-src data:"
_SCRIPTED = f"script-src 'unsafe-inline'; {_STATIC}"
# Plotly compiles functions for its plots in space, and saves pictures by blobs.
_PLOTTED = f"script-src 'unsafe-inline' 'unsafe-eval'; {_STATIC} blob:"


@dataclass(frozen=True)
class Script:
    """What draws a page."""

    draws: str
    """What is missing without it, as "The maps on this page are"."""
    data: str
    """JSON that is safe inside a script element."""
    files: tuple[str, ...]
    """JavaScript files, in the order in which they build on each other."""
    uses_plotly: bool = False

    @property
    def html(self) -> str:
        """The elements at the end of the page."""
        return fill(
            "script.html",
            draws=self.draws,
            data=self.data,
            plotly=_plotly() if self.uses_plotly else "",
            script=_inline("\n".join(asset(name) for name in self.files)),
        )


def page(
    kind: str,
    *,
    title: str,
    scope: str,
    version: str,
    styles: tuple[str, ...],
    main: str,
    script: Script | None = None,
) -> str:
    """Return a page: what kind it is, its title and scope as text, and what it shows as HTML.

    It needs nothing but a browser, which is told to load nothing from any other place. ``styles``
    are CSS files.
    """
    policy = _STATIC
    if script is not None:
        policy = _PLOTTED if script.uses_plotly else _SCRIPTED
    return fill(
        "base.html",
        policy=policy,
        version=escape(version),
        title=escape(title),
        kind=escape(kind),
        kicker=escape(kind[:1].upper() + kind[1:]),
        scope=escape(scope),
        style="".join(asset(name) for name in styles),
        main=main,
        script="" if script is None else script.html,
    )


def fill(template: str, **parts: str) -> str:
    """Return a template of HTML with its parts, which are HTML too."""
    return Template(asset(template)).substitute(parts)


def asset(name: str) -> str:
    """Return the text of a file that pages are made of."""
    return resources.files("stiffkit.report").joinpath("assets", name).read_text(encoding="utf-8")


def write_text(text: str, path: Path, what: str) -> None:
    """Write a page, called ``what`` in messages. Raises OutputError if it cannot be written."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(
            f"cannot write the {what} {path}: {error.strerror or error}",
            mend="give a file in a folder that exists and that you may write to",
        ) from error


def _plotly() -> str:
    # It takes a second to import, and only pages with plots need it.
    from plotly.offline import get_plotlyjs

    return f"<script>{_inline(get_plotlyjs())}</script>\n"


def _inline(code: str) -> str:
    """Return JavaScript that no HTML parser mistakes for the end of its script element."""
    return re.sub(r"<(?=/script|!--)", r"<\\", code, flags=re.IGNORECASE)
