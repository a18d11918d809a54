"""What all pages share: a head, a title, and scripts that need no other place."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib import resources
from pathlib import Path
from string import Template

from stiffkit.errors import OutputError
from stiffkit.report.tables import pair_table

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
    """JSON."""
    files: tuple[str, ...]
    """JavaScript files, in the order in which they build on each other."""
    uses_plotly: bool = False

    @property
    def html(self) -> str:
        """The elements at the end of the page."""
        return fill(
            "script.html",
            data=packed(self.data),
            plotly=_plotly() if self.uses_plotly else "",
            unpack=asset("unpack.js"),
            script="\n".join(asset(name) for name in self.files),
        )

    @property
    def policy(self) -> str:
        """What the browser lets the page do."""
        return _PLOTTED if self.uses_plotly else _SCRIPTED


def page(
    kind: str,
    *,
    title: str,
    scope: str,
    version: str,
    styles: tuple[str, ...],
    main: str,
    made: Sequence[tuple[str, str]],
    script: Script | None = None,
) -> str:
    """Return a page: what kind it is, its title and scope as text, and what it shows as HTML.

    It needs nothing but a browser, which is told to load nothing from any other place. ``styles``
    are CSS files besides the one that all pages share. ``made`` tells how to make the same again.
    What only ``script`` can show has the class ``needs-script``; what stands in for it where no
    script runs, ``without-script``.
    """
    return fill(
        "base.html",
        policy=_STATIC if script is None else script.policy,
        version=escape(version),
        title=escape(title),
        kind=escape(kind),
        kicker=escape(kind[:1].upper() + kind[1:]),
        scope=escape(scope),
        style="".join(asset(name) for name in ("page.css", *styles)),
        unscripted="" if script is None else asset("unscripted.html"),
        notice="" if script is None else fill("notice.html", draws=escape(script.draws)),
        main=main,
        made=pair_table(made),
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


def packed(text: str) -> str:
    """Return text as base64 of gzip, the same on every run, for ``unpack.js`` to read."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode("ascii")


@cache
def _plotly() -> str:
    # It takes a second to import, and only pages with plots need it.
    from plotly.offline import get_plotlyjs

    return f'<script type="application/gzip" id="plotly">{packed(get_plotlyjs())}</script>\n'
