"""The command that computes the papers' numbers again."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import click

from stiffkit.cli.arguments import json_option, output_option
from stiffkit.errors import how_to_install

if TYPE_CHECKING:
    from stiffkit.progress import Progress
    from stiffkit.report.reproduction_page import PageTable
    from stiffkit.reproduce import Briot2009, Entry, Reproduction

T = TypeVar("T")

WIDTH = 98


PAPERS = ("pashkevich-2009", "briot-2009")


@click.command()
@click.argument("paper", type=click.Choice(PAPERS), required=False)
@click.option(
    "--full",
    is_flag=True,
    help="Solve the finest mesh of Table 5 too, which takes minutes and 4 GB of memory.",
)
@output_option("Directory for reproduction.html and .json, and the figures, as SVG and PNG.")
@json_option
def reproduce(paper: str | None, full: bool, output: Path | None, as_json: bool) -> None:
    """Compute the tables and figures of a paper again, beside the printed numbers.

    Without PAPER both, on one page. Of Pashkevich et al. 2009: Tables 2, 3, 5, 7 and 8, sections
    3.5, 4 and 5, and figures 1 to 3. The finite elements of sections 4 and 5 take a minute or two,
    and the extra 'fea'.

    Of Briot et al. 2009: what the text says of the machine and of longer legs, and figures 3, 5 to
    7, 10, 12 and 13.

    Example:  stiffkit reproduce -o out/papers
    """
    from stiffkit.cli.show import heading, json_text, progress

    papers = PAPERS if paper is None else (paper,)
    done: dict[str, _Done[Any]] = {}
    with progress(sys.stderr.isatty()) as report:
        for name in papers:
            if name == "briot-2009":
                done[name] = _briot(report)
            else:
                done[name] = _pashkevich(report, full=full)
    command = " ".join(["stiffkit reproduce", *([] if paper is None else [paper])])
    written = [] if output is None else [_written(done, command, output)]
    if as_json:
        click.echo(json_text(_plain(done)))
        return
    for one in done.values():
        if paper is None:
            heading(one.name)
        one.show(one.found)
    for line in written:
        click.echo(line)


@dataclass(frozen=True)
class _Done(Generic[T]):
    """The reproduction of a paper, and how it is told."""

    found: T
    show: Callable[[T], None]
    plain: Callable[[T], dict[str, Any]]
    """Plain data for JSON."""
    write_figures: Callable[[T, Path, str], str]
    """Writes them into a directory, under names that begin so, and returns which, in words."""
    tables: Callable[[T], Sequence[PageTable]]
    """What the page shows."""
    name: str
    """The paper's, for people."""
    source: str


def _plain(done: Mapping[str, _Done[Any]]) -> dict[str, Any]:
    """Return plain data for JSON: that of the only paper, or of all."""
    papers = [{"paper": name, **one.plain(one.found)} for name, one in done.items()]
    return papers[0] if len(papers) == 1 else {"papers": papers}


def _written(done: Mapping[str, _Done[Any]], command: str, output: Path) -> str:
    """Write page, JSON and figures, and return in words what was written."""
    from stiffkit.cli.show import write_json
    from stiffkit.report.reproduction_page import PaperOnPage, write_reproduction_page
    from stiffkit.study import REPRODUCTION, whole_directory

    with whole_directory(output, REPRODUCTION) as work:
        write_json(work / "reproduction.json", _plain(done))
        figures, pages = [], []
        for name, one in done.items():
            figures.append(one.write_figures(one.found, work, f"{name}-figure"))
            drawings = sorted(work.glob(f"{name}-figure-*.svg"), key=_number)
            pages.append(PaperOnPage(one.name, one.source, one.tables(one.found), drawings))
        write_reproduction_page(pages, command, work / "reproduction.html")
    shown = "; ".join(figures)
    return f"{shown}, reproduction.html and reproduction.json in {output}"


def _number(figure: Path) -> int:
    return int(figure.stem.rpartition("-")[2])


def _pashkevich(progress: Progress, *, full: bool) -> _Done[Reproduction]:
    from stiffkit.cli.reproduced import entry_table, row_tables
    from stiffkit.reproduce import reproduce as compute

    return _Done(
        compute(full=full, progress=progress),
        _show,
        _content,
        _write_figures,
        lambda found: [entry_table(found.entries), *row_tables(found.orthoglide.rows)],
        "Pashkevich et al. 2009",
        "A. Pashkevich, A. Klimchik, D. Chablat, P. Wenger, Accuracy improvement for stiffness"
        " modeling of parallel manipulators, 42nd CIRP Conference on Manufacturing Systems, 2009",
    )


def _briot(progress: Progress) -> _Done[Briot2009]:
    from stiffkit.cli.reproduced import statement_table
    from stiffkit.cli.reproducing_briot import show_statements, write_figures
    from stiffkit.reproduce import reproduce_briot_2009

    return _Done(
        reproduce_briot_2009(progress=progress),
        lambda found: show_statements(found.statements),
        lambda found: found.as_json(),
        write_figures,
        lambda found: [statement_table(found.statements)],
        "Briot et al. 2009",
        "S. Briot, A. Pashkevich, D. Chablat, On the optimal design of parallel robots taking into"
        " account their deformations and natural frequencies, ASME IDETC/CIE 2009",
    )


def _content(found: Reproduction) -> dict[str, Any]:
    from stiffkit.reproduce import cantilever_as_json

    content: dict[str, Any] = {
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
        click.echo(f"section 4 and Table 5 need NGSolve: {how_to_install('fea')}")
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


def _write_figures(found: Reproduction, output: Path, stem: str) -> str:
    """Write the figures as ``stem``-1 and so on, and return which these are, in words."""
    import numpy as np

    from stiffkit.plots import style
    from stiffkit.plots.noise import error_by_amplitude, error_histograms
    from stiffkit.plots.residuals import residual_histograms
    from stiffkit.reproduce import AMPLITUDES

    noise = found.noise
    expected = np.array([noise.translation_std] * 3 + [noise.rotation_std] * 3)
    style.save(error_histograms(noise.errors, expected), output / f"{stem}-1")
    curves = (AMPLITUDES, noise.total, noise.linearisation, noise.rotation_std)
    style.save(error_by_amplitude(*curves), output / f"{stem}-2")
    level = None if found.cantilever is None else found.cantilever.finest
    if level is None:
        return "Figures 1 and 2"
    figure = residual_histograms(
        level.residuals.before,
        level.residuals.outlier,
        level.found.case_names,
        f"Residuals of the loaded end, {level.meshing.name} mesh",
    )
    style.save(figure, output / f"{stem}-3")
    return "Figures 1 to 3"
