"""What papers print beside ours, as the rows of a page."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import TYPE_CHECKING

from stiffkit.report.reproduction_page import PageRow, PageTable

if TYPE_CHECKING:
    from stiffkit.reproduce import Entry, PrintedRow, Statement


def entry_table(entries: Iterable[Entry]) -> PageTable:
    """Return printed numbers as a table."""
    rows = [
        PageRow(
            entry.where,
            f"{entry.printed} {entry.unit}",
            f"{entry.ours:.3g} {entry.unit}",
            "" if entry.is_bound else _percent(entry.deviation),
            entry.verdict.value,
            entry.why if entry.verdict.name == "DIFFERS" else "",
        )
        for entry in entries
    ]
    return PageTable("Numbers", tuple(rows))


def row_tables(rows: Iterable[PrintedRow]) -> list[PageTable]:
    """Return printed rows as one table for each of the paper's."""
    return [
        PageTable(f"{name}", tuple(_page_row(row) for row in group))
        for name, group in groupby(rows, key=lambda row: row.table)
    ]


def _page_row(row: PrintedRow) -> PageRow:
    remarks = (("known", row.known), ("assumed", row.assumed), ("", row.why))
    return PageRow(
        row.row,
        f"{', '.join(row.printed)} ({row.unit})",
        "" if row.ours is None else ", ".join(f"{value:.3g}" for value in row.ours),
        "" if row.deviation is None else f"up to {_percent(row.deviation)}",
        row.standing.value,
        "; ".join(f"{name}: {text}" if name else text for name, text in remarks if text),
    )


def statement_table(statements: Iterable[Statement]) -> PageTable:
    """Return sentences of a paper as a table."""
    rows = [
        PageRow(one.where, one.printed, one.ours, "", one.outcome.value, one.why)
        for one in statements
    ]
    return PageTable("What the text says", tuple(rows))


def _percent(share: float) -> str:
    return f"{100.0 * share:+.2g} %"
