"""The command that computes the papers' numbers again."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from stiffkit.cli.arguments import json_option, output_option

if TYPE_CHECKING:
    from stiffkit.reproduce import Entry, Reproduction

WIDTH = 98


@click.command()
@click.argument("paper", type=click.Choice(["pashkevich-2009"]))
@click.option(
    "--full",
    is_flag=True,
    help="Solve the finest mesh of Table 5 too, which takes minutes and 4 GB of memory.",
)
@output_option("Directory for reproduction.json and the figures, as SVG and PNG.")
@json_option
def reproduce(paper: str, full: bool, output: Path | None, as_json: bool) -> None:
    """Compute the tables and figures of a paper again, beside the printed numbers.

    Tables 2, 3, 5, 7 and 8, sections 3.5, 4 and 5, and figures 1 to 3 of Pashkevich et al. 2009.
    The finite elements of sections 4 and 5 take a minute or two, and the extra 'fea'.

    Example:  stiffkit reproduce pashkevich-2009 -o out/pashkevich
    """
    from stiffkit.cli.show import progress
    from stiffkit.reproduce import reproduce as compute

    with progress(sys.stderr.isatty()) as report:
        found = compute(full=full, progress=report)
    text = json.dumps(_content(paper, found), indent=1, allow_nan=False)
    figures = ""
    if output is not None:
        from stiffkit.study import REPRODUCTION, whole_directory

        with whole_directory(output, REPRODUCTION) as work:
            (work / "reproduction.json").write_text(text + "\n", encoding="utf-8")
            figures = _write_figures(found, work)
    if as_json:
        click.echo(text)
        return
    _show(found)
    if output is not None:
        click.echo(f"{figures} and reproduction.json in {output}")


def _content(paper: str, found: Reproduction) -> dict[str, Any]:
    from stiffkit.reproduce import cantilever_as_json

    content: dict[str, Any] = {
        "paper": paper,
        "entries": [entry.as_json() for entry in found.entries],
        "orthoglide": found.orthoglide.as_json(),
    }
    if found.cantilever is not None:
        content["cantilever"] = cantilever_as_json(found.cantilever)
    return content


def _show(found: Reproduction) -> None:
    from stiffkit.cli.show_rows import show_over_constraint, show_rows

    _show_entries(found)
    show_rows(found.orthoglide.rows)
    show_over_constraint(found.orthoglide.over_constraint)


def _show_entries(found: Reproduction) -> None:
    click.echo(f"{'':<38}{'printed':>9}{'ours':>11}{'converged':>11}")
    for entry in found.entries:
        _show_entry(entry)
    if found.cantilever is None:
        click.echo("section 4 and Table 5 need NGSolve: pip install 'stiffkit[fea]'")
        return
    for meshing, why in found.cantilever.left_out:
        click.echo(f"Table 5, {meshing.name}: left out, {why}; printed {meshing.printed} %")


def _show_entry(entry: Entry) -> None:
    from stiffkit.reproduce import Verdict

    converged = "" if entry.converged is None else f"{entry.converged:.3g}"
    shown = f"{entry.where:<38}{entry.printed:>9}{entry.ours:>11.3g}{converged:>11} {entry.unit:<4}"
    by = f" by {100.0 * entry.deviation:+.2g} %" if entry.verdict is Verdict.DIFFERS else ""
    click.echo(f"{shown} {entry.verdict.value}{by}")
    if entry.why and entry.verdict is Verdict.DIFFERS:
        click.echo(fill(entry.why, WIDTH, initial_indent="  ", subsequent_indent="  "))


def _write_figures(found: Reproduction, output: Path) -> str:
    """Write the figures, and return which these are, in words."""
    import numpy as np

    from stiffkit.plots import style
    from stiffkit.plots.noise import error_by_amplitude, error_histograms
    from stiffkit.plots.residuals import residual_histograms
    from stiffkit.reproduce import AMPLITUDES

    noise = found.noise
    expected = np.array([noise.translation_std] * 3 + [noise.rotation_std] * 3)
    style.save(error_histograms(noise.errors, expected), output / "figure-1")
    curves = (AMPLITUDES, noise.total, noise.linearisation, noise.rotation_std)
    style.save(error_by_amplitude(*curves), output / "figure-2")
    level = None if found.cantilever is None else found.cantilever.finest
    if level is None:
        return "Figures 1 and 2"
    figure = residual_histograms(
        level.residuals.before,
        level.residuals.outlier,
        level.found.case_names,
        f"Residuals of the loaded end, {level.meshing.name} mesh",
    )
    style.save(figure, output / "figure-3")
    return "Figures 1 to 3"
