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


@dataclass(frozen=True)
class PaperOnPage:
    """A paper, and everything of it that was computed again."""

    name: str
    """Such as Briot et al. 2009."""
    source: str
    tables: Sequence[PageTable]
    figures: Sequence[Path]
    """SVG."""


def write_reproduction_page(papers: Sequence[PaperOnPage], command: str, path: Path) -> None:
    """Write what papers print beside ours as one page; ``command`` is what makes it again.

    Raises OutputError if a figure cannot be read or the page cannot be written.
    """
    rows = [row for paper in papers for table in paper.tables for row in table.rows]
    counts = Counter(row.verdict for row in rows)
    cards = "".join(card(verdict, str(count), "", "") for verdict, count in counts.most_common())
    text = page(
        "reproduction",
        title=" and ".join(paper.name for paper in papers),
        scope="What is printed beside ours, computed again. Nothing but the printed numbers is"
        " typed in.",
        version=__version__,
        styles=("reproduction.css",),
        main=f'<section class="cards">{cards}</section>' + "".join(map(_paper, papers)),
        made=[("made by", command), ("stiffkit version", __version__)],
    )
    write_text(text, path, "page")


def _paper(paper: PaperOnPage) -> str:
    return (
        f"<section><h2>{escape(paper.name)}</h2><p>{escape(paper.source)}</p></section>"
        + "".join(_section(table) for table in paper.tables)
        + "".join(_section_of(drawing) for drawing in paper.figures)
    )


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
        f"<section><h3>{escape(table.heading)}</h3>"
        f'<div class="scroll"><table class="reproduced"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div></section>"
    )


def _section_of(drawing: Path) -> str:
    number = drawing.stem.rpartition("-")[2]
    return f"<section><h3>Figure {escape(number)}</h3>{figure(drawing)}</section>"
