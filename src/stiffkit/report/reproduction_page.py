"""The reproduction of a paper as one page that needs nothing but a browser."""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from stiffkit import __version__
from stiffkit.errors import OutputError
from stiffkit.report.tables import card
from stiffkit.report.template import page, write_text


@dataclass(frozen=True)
class PageRow:
    """What a paper prints, ours, and what to think of them, in words."""

    where: str
    printed: str
    ours: str
    deviation: str
    verdict: str
    why: str = ""


@dataclass(frozen=True)
class PageTable:
    """Rows under a heading."""

    heading: str
    rows: tuple[PageRow, ...]


def write_reproduction_page(
    paper: str, source: str, tables: Sequence[PageTable], figures: Sequence[Path], path: Path
) -> None:
    """Write what a paper prints beside ours, with ``figures`` (PNG), as one page.

    Raises OutputError if a figure cannot be read or the page cannot be written.
    """
    counts = Counter(row.verdict for table in tables for row in table.rows)
    cards = "".join(card(verdict, str(count), "", "") for verdict, count in counts.most_common())
    main = (
        f'<section class="cards">{cards}</section>'
        + "".join(_section(table) for table in tables)
        + "".join(_image(figure) for figure in figures)
    )
    text = page(
        "reproduction",
        title=paper,
        scope=f"{source}. The printed beside ours, computed again.",
        version=__version__,
        styles=("page.css", "reproduction.css"),
        main=main,
    )
    write_text(text, path, "page")


def _section(table: PageTable) -> str:
    names = ("where", "printed", "ours", "deviation", "verdict", "why")
    shown = [name for name in names if any(getattr(row, name) for row in table.rows)]
    head = "".join(f'<th scope="col">{name}</th>' for name in shown)
    body = "".join(
        "<tr>"
        + "".join(f'<td class="{name}">{escape(getattr(row, name))}</td>' for name in shown)
        + "</tr>"
        for row in table.rows
    )
    return (
        f"<section><h2>{escape(table.heading)}</h2>"
        f'<div class="scroll"><table class="reproduced"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div></section>"
    )


def _image(figure: Path) -> str:
    try:
        content = figure.read_bytes()
    except OSError as error:
        raise OutputError(f"cannot read the figure {figure}: {error.strerror or error}") from error
    data = base64.b64encode(content).decode("ascii")
    # The first chunk of a PNG begins with its width; at half of it a print's fonts suit a screen.
    width = int.from_bytes(content[16:20], "big") // 2
    name = figure.stem.replace("-", " ").capitalize()
    return (
        f"<section><h2>{escape(name)}</h2>"
        f'<img src="data:image/png;base64,{data}" width="{width}"'
        f' alt="{escape(name)} of the paper, ours">'
        "</section>"
    )
