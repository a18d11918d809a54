"""The reproduction of a paper as one page that needs nothing but a browser."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from stiffkit import __version__
from stiffkit.report.pictures import figure
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
    """Write what a paper prints beside ours, with ``figures`` (SVG), as one page.

    Raises OutputError if a figure cannot be read or the page cannot be written.
    """
    counts = Counter(row.verdict for table in tables for row in table.rows)
    cards = "".join(card(verdict, str(count), "", "") for verdict, count in counts.most_common())
    main = (
        f'<section class="cards">{cards}</section>'
        + "".join(_section(table) for table in tables)
        + "".join(_section_of(drawing) for drawing in figures)
    )
    text = page(
        "reproduction",
        title=paper,
        scope=f"{source}. The printed beside ours, computed again.",
        version=__version__,
        styles=("reproduction.css",),
        main=main,
        made=[("made by", f"stiffkit reproduce {paper}"), ("stiffkit version", __version__)],
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


def _section_of(drawing: Path) -> str:
    name = drawing.stem.replace("-", " ").capitalize()
    return f"<section><h2>{escape(name)}</h2>{figure(drawing)}</section>"
