"""Rows of a paper's tables, and what over-constraints do, as text for a terminal."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import click

from stiffkit.cli.show import heading

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stiffkit.reproduce import OverConstraint, PrintedRow

WIDTH = 98


def show_rows(rows: Sequence[PrintedRow]) -> None:
    """Print each printed row beside ours, with what was known and what was assumed."""
    table = ""
    for row in rows:
        if row.table != table:
            table = row.table
            heading(f"{table}: {', '.join(row.columns)} in {row.unit}")
        standing = row.standing.value
        if row.deviation is not None:
            standing += f"; by at most {100.0 * row.deviation:.2g} %"
        click.echo(f"{row.row}: {standing}")
        click.echo(_numbers("printed", row.printed))
        if row.ours is not None:
            click.echo(_numbers("ours", [f"{x:.3g}" for x in row.ours]))
        for name, text in (("known", row.known), ("assumed", row.assumed), ("why", row.why)):
            if text:
                click.echo(
                    fill(f"{name}: {text}", WIDTH, initial_indent="  ", subsequent_indent="    ")
                )


def show_over_constraint(found: OverConstraint) -> None:
    """Print where an Orthoglide gets softer without its over-constraints, and by how much."""
    heading("the same Orthoglide without its over-constraints")
    (counted, counted_free), (true, true_free) = found.counted, found.mobility
    click.echo(
        f"  mobility {true}, counted {counted}; without them {true_free}, counted {counted_free}"
    )
    click.echo("  compliance without over that with them, on the diagonal of the cube")
    names = "".join(f"{name:>9}" for name in ("x = y = z", "along x", "about x", "least", "most"))
    click.echo(f"  {names}")
    for one in found.postures:
        place = f"{1e3 * one.at['x']:.4g} mm"
        shown = (one.ratios[0], one.ratios[3], one.least, one.most)
        click.echo(f"  {place:>9}" + "".join(f"{x:>9.3f}" for x in shown))
    click.echo("  (all axes are alike there; least and most over all combinations of directions)")


def _numbers(name: str, texts: Sequence[str]) -> str:
    return f"  {name:<8}" + "".join(f"{text:>12}" for text in texts)
