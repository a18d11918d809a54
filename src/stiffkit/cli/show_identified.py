"""Identified compliances and advice on loads as text for a terminal."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from stiffkit.cli.show import heading

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stiffkit.identify import IdentifiedLink, LinkAdvice

WIDTH = 98


def show_identified(link: IdentifiedLink) -> None:
    """Print what was identified: the compliance with its errors, the load cases, the verdicts."""
    from stiffkit.identify import estimator_word, outlier_words

    found = link.found
    heading(link.spec.title)
    _fact("nodes", link.chosen.words)
    _fact("weights", link.chosen.weights_words)
    _fact("estimator", estimator_word(found))
    _fact("outliers", outlier_words(found))
    _fact("sigma", f"{1e6 * link.sigma:.4g} um, noise of a node's displacement along an axis")
    heading("compliance (m/N, 1/N; 1/N, rad/(N m)) of the tip, link axes")
    _show_marked(link.compliance, link.significant)
    stand_out = int(link.significant.sum())
    click.echo(
        f"  * the {stand_out} of 36 elements whose {100.0 * found.options.level:.6g} % interval "
        "does not hold zero"
    )
    heading("standard errors of its elements")
    _show_marked(link.standard_error, np.zeros((6, 6), dtype=bool))
    _show_cases(link)
    _show_alternatives(link)
    for doubt in link.doubts:
        _remark("doubt: ", "red", doubt)
    for note in link.notes:
        _remark("note: ", "yellow", note)


def _fact(name: str, value: str) -> None:
    click.echo(fill(f"{name:<12}{value}", WIDTH, subsequent_indent=" " * 12))


def _remark(word: str, colour: str, text: str) -> None:
    told = fill(word + text, WIDTH, subsequent_indent="  ")
    click.echo(click.style(word, fg=colour, bold=True) + told.removeprefix(word))


def _show_marked(matrix: NDArray[np.float64], marked: NDArray[np.bool_]) -> None:
    for row, marks in zip(matrix, marked, strict=True):
        cells = zip(row, marks, strict=True)
        text = "".join(f"{x + 0.0:>14.4e}{'*' if mark else ' '}" for x, mark in cells)
        click.echo("  " + text.rstrip())


def _show_cases(link: IdentifiedLink) -> None:
    found = link.found
    heading("load cases")
    heads = ("", "translation", "rotation", "sigma", "largest residual", "")
    units = ("", "um", "urad", "um", "um at node", "residuals")
    for line in (heads, units):
        click.echo(("  {:<16}{:>12}{:>12}{:>10}{:>22}  {}".format(*line)).rstrip())
    for j, name in enumerate(found.case_names):
        d = 1e6 * found.estimate.deflections[j]
        largest = f"{1e6 * found.estimate.largest[j]:.3g} {found.estimate.largest_node[j]:>8}"
        shape = "a shape" if found.structure[j].structured else "like noise"
        click.echo(
            f"  {name:<16}{np.linalg.norm(d[:3]):>12.5g}{np.linalg.norm(d[3:]):>12.5g}"
            f"{1e6 * found.estimate.sigma[j]:>10.4g}{largest:>22}  {shape}"
        )


def _show_alternatives(link: IdentifiedLink) -> None:
    heading("found in other ways: differences of elements k_ij, relative to sqrt(k_ii k_jj)")
    click.echo(f"  {'':<16}{'sigma, um':>12}{'difference':>12}")
    for other in link.alternatives:
        click.echo(f"  {other.name:<16}{1e6 * other.sigma:>12.4g}{other.largest_difference:>12.2g}")


def show_advice(found: LinkAdvice) -> None:
    """Print how large each load should be, and why."""
    heading(f"{found.title}: loads for an accuracy of {found.accuracy:.3g}")
    _fact("field", found.basis)
    click.echo(
        f"  {'load':<6}{'at least':>12}{'best':>12}{'at most':>12}{'':>6}"
        f"{'translation':>14}{'rotation':>12}"
    )
    click.echo(f"  {'':<48}{'um':>14}{'deg':>12}")
    for advice in found.loads:
        unit = "N" if advice.load.startswith("F") else "N m"
        most = f"{advice.highest:.4g}" if np.isfinite(advice.highest) else "-"
        click.echo(
            f"  {advice.load:<6}{advice.lowest:>12.4g}{advice.best:>12.4g}{most:>12}{unit:>6}"
            f"{1e6 * advice.translation:>14.4g}{np.degrees(advice.rotation):>12.4g}"
        )
    heading("why")
    for advice in found.loads:
        text = "; ".join(advice.reasoning)
        click.echo(fill(text, WIDTH, initial_indent="  ", subsequent_indent="      "))


def advice_as_json(found: LinkAdvice) -> dict[str, Any]:
    """Return the advice as plain values, SI; an upper limit that there is not is None."""
    return {
        "link": found.title,
        "field": found.basis,
        "accuracy": found.accuracy,
        "loads": [
            {
                "load": advice.load,
                "lowest": float(advice.lowest),
                "best": float(advice.best),
                "highest": float(advice.highest) if np.isfinite(advice.highest) else None,
                "translation": float(advice.translation),
                "rotation": float(advice.rotation),
                "reasoning": list(advice.reasoning),
            }
            for advice in found.loads
        ],
    }
