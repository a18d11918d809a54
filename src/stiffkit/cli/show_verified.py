"""Verifications as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterable
from textwrap import fill
from typing import TYPE_CHECKING

import click

from stiffkit.cli.show import heading, tool_in_words

if TYPE_CHECKING:
    from stiffkit.verify import Compared, Verification, VerifiedPosture

_WIDTH = 98

_ROUNDING = 1e-8
"""Differences below this are told to be below it."""


def show_verification(found: Verification) -> None:
    """Print what was meshed, and the reduced model beside the whole, at each posture."""
    heading(f"{found.robot}: the reduced model beside finite elements of the whole robot")
    _show_parts(found)
    for posture in found.postures:
        click.echo()
        _show_posture(posture)
    click.echo()
    click.echo(
        f"{found.n_unknowns} unknowns, {found.seconds:.0f} s, {found.peak_memory / 1e9:.1f} GB"
    )


def _show_posture(posture: VerifiedPosture) -> None:
    click.echo("tool        " + tool_in_words(posture.tool))
    _show_compared(
        "compliance (m/N, 1/N, rad/(N m)), world axes at the tool point; elements above a "
        "thousandth of sqrt(kii kjj)",
        "element",
        posture.elements,
    )
    if posture.frequencies:
        _show_compared("natural frequencies, Hz", "", posture.frequencies)
    largest = posture.largest
    words = [f"compliance {_percent(largest['compliance'])}"]
    if posture.frequencies:
        words.append(f"frequencies {_percent(largest['frequencies'])}")
    click.echo(
        f"largest difference: {', '.join(words)}; residual {posture.residual:.1e}, "
        f"{posture.seconds:.0f} s"
    )
    for note in posture.notes:
        told = fill(f"note: {note}", _WIDTH, subsequent_indent="  ")
        click.echo(click.style("note: ", fg="yellow", bold=True) + told.removeprefix("note: "))


def _show_parts(found: Verification) -> None:
    heading(
        f"{'part':<24}{'elements':>10}{'order':>7}{'unknowns':>10}{'estimate':>10}  mesh"
        "            links"
    )
    for part in found.parts:
        estimate = "-" if part.estimate is None else f"{100.0 * part.estimate:.2g} %"
        mesh = "the link's own" if part.own_mesh else "another"
        line = (
            f"{part.part:<24}{part.elements:>10}{part.order:>7}{part.unknowns:>10}{estimate:>10}"
            f"  {mesh:<16}{', '.join(part.links)}"
        )
        click.echo(
            fill(line, _WIDTH, subsequent_indent=" " * 79, break_on_hyphens=False)
            if len(part.links) < 3
            else f"{line[:79]}{len(part.links)} links"
        )
    if found.rigid:
        click.echo(fill(f"rigid: {', '.join(found.rigid)}", _WIDTH, subsequent_indent="  "))


def _show_compared(title: str, what: str, numbers: Iterable[Compared]) -> None:
    click.echo(fill(click.style(title, bold=True), _WIDTH + 8, subsequent_indent="  "))
    click.echo(
        f"  {what:<9}{'reduced':>14}{'whole':>14}{'difference':>13}   "
        f"{'of it the meshes':>17}{'the rest':>11}"
    )
    for one in numbers:
        click.echo(
            f"  {one.name:<9}{one.reduced:>14.6g}{one.whole:>14.6g}{_percent(one.difference):>13}"
            f"   {_percent(one.discretisation):>17}{_percent(one.modelling):>11}"
        )


def _percent(share: float) -> str:
    """Return a share in percent; what is smaller than that is rounding."""
    return f"{100.0 * share:.2g} %" if abs(share) > _ROUNDING else f"< {100.0 * _ROUNDING:.0e} %"
