"""The command that computes the papers' numbers again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from stiffkit.reproduce import NoiseStudy


@click.command()
@click.argument("paper", type=click.Choice(["pashkevich-2009"]))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=True),
    default=None,
    help="Directory for reproduction.json and the figures, as SVG and PNG.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of text.")
def reproduce(paper: str, output: Path | None, as_json: bool) -> None:
    """Compute the tables and figures of a paper again, beside the printed numbers.

    So far Tables 2 and 3 and section 3.5 with figures 1 and 2 of Pashkevich et al. 2009.

    Example:  stiffkit reproduce pashkevich-2009 -o out/pashkevich
    """
    from stiffkit.reproduce import Verdict
    from stiffkit.reproduce import reproduce as compute

    found = compute()
    content = {"paper": paper, "entries": [entry.as_json() for entry in found.entries]}
    text = json.dumps(content, indent=1)
    if output is not None:
        from stiffkit.study import REPRODUCTION, whole_directory

        with whole_directory(output, REPRODUCTION) as work:
            (work / "reproduction.json").write_text(text + "\n", encoding="utf-8")
            _write_figures(found.noise, work)
    if as_json:
        click.echo(text)
        return
    click.echo(f"{'':<40}{'printed':>10}{'ours':>12}")
    for entry in found.entries:
        shown = f"{entry.where:<40}{entry.printed:>10}{entry.ours:>12.3g} {entry.unit:<4}"
        click.echo(f"{shown} {entry.verdict.value}")
        if entry.why and entry.verdict is Verdict.DIFFERS:
            click.echo(f"  {entry.why}")
    if output is not None:
        click.echo(f"Figures 1 and 2 and reproduction.json in {output}")


def _write_figures(noise: NoiseStudy, output: Path) -> None:
    import numpy as np

    from stiffkit.plots import style
    from stiffkit.plots.noise import error_by_amplitude, error_histograms
    from stiffkit.reproduce.pashkevich_2009 import AMPLITUDES

    expected = np.array([noise.translation_std] * 3 + [noise.rotation_std] * 3)
    style.save(error_histograms(noise.errors, expected), output / "figure-1")
    curves = (AMPLITUDES, noise.total, noise.linearisation, noise.rotation_std)
    style.save(error_by_amplitude(*curves), output / "figure-2")
