"""Results as text for a terminal."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any, TypeVar

import click
import numpy as np

from stiffkit.progress import Progress, no_progress
from stiffkit.robot import DIRECTIONS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from stiffkit.stiffness import PrincipalAxes
    from stiffkit.study import ModesResult, PoseResult, Summary

R = TypeVar("R")


def heading(text: str) -> None:
    """Print a heading."""
    click.echo(click.style(text, bold=True))


def tell(
    result: R,
    show: Callable[[R], None],
    plain: Callable[[R], Any],
    *,
    as_json: bool,
    written: Sequence[str] = (),
) -> None:
    """Print a result and lines on what was ``written``, or only JSON of its plain values."""
    if as_json:
        click.echo(json_text(plain(result)))
        return
    show(result)
    for line in written:
        click.echo(line)


def json_text(plain: Any) -> str:
    """Return plain values as JSON. Raises ValueError if a number is not finite."""
    return json.dumps(plain, indent=1, allow_nan=False)


def write_json(path: Path, plain: Any) -> None:
    """Write plain values as JSON. Raises ValueError if a number is not finite."""
    path.write_text(json_text(plain) + "\n", encoding="utf-8")


def show_summary(summary: Summary) -> None:
    """Print the facts about a robot, and the warnings."""
    width = max(len(name) for name, _ in summary.facts)
    for name, value in summary.facts:
        click.echo(f"{name:<{width}}  {value}")
    show_notes(summary.warnings)


def show_notes(notes: Sequence[str]) -> None:
    """Print what is worth knowing before the numbers are used."""
    for note in notes:
        click.echo(click.style("note: ", fg="yellow", bold=True) + note)


def show_pose(result: PoseResult) -> None:
    """Print what is known of one posture."""
    heading(f"{result.robot}, {result.model} model")
    if result.reason:
        click.echo(f"status      {result.status.word}: {result.reason}")
    if np.isfinite(result.tool).all():
        click.echo("tool        " + _values(DIRECTIONS, result.tool, "mm", "deg"))
        for name, value in result.joints.items():
            unit = "deg" if name.rpartition(".")[2].startswith("r") else "mm"
            click.echo(f"  {name:<24} {round(value * _FACTOR[unit], 4) + 0.0:>12.4f} {unit}")
    if result.deflections:
        heading("deflection of the tool, world axes")
        click.echo(f"  {'load':<16}" + "".join(f"{d:>11}" for d in DIRECTIONS) + f"{'|xyz|':>11}")
        click.echo(f"  {'':<16}" + f"{'um':>11}" * 3 + f"{'urad':>11}" * 3 + f"{'um':>11}")
        for name, d in result.deflections.items():
            cells = [*(1e6 * d), 1e6 * np.linalg.norm(d[:3])]
            click.echo(f"  {name:<16}" + "".join(f"{x + 0.0:>11.4g}" for x in cells))
    _show_axes("translational stiffness, N/um", result.translation, 1e-6)
    _show_axes("rotational stiffness, N m/mrad", result.rotation, 1e-3)
    if result.compliance is not None:
        heading("compliance (m/N, 1/N; 1/N, rad/(N m)), world axes at the tool point")
        _show_matrix(result.compliance)
    if result.stiffness is not None:
        heading("stiffness (N/m, N; N, N m/rad), world axes at the tool point")
        _show_matrix(result.stiffness)
    elif result.compliance is not None:
        click.echo("stiffness   infinite in some directions: this model holds them rigidly")


def show_modes(result: ModesResult) -> None:
    """Print the modes of one posture."""
    heading(f"{result.robot}, {result.model} model")
    if result.reason:
        click.echo(f"status      {result.status.word}: {result.reason}")
    if np.isfinite(result.tool).all():
        click.echo("tool        " + _values(DIRECTIONS, result.tool, "mm", "deg"))
    if result.modes:
        heading(f"{'mode':>4}{'frequency':>13}   description")
    for number, mode in enumerate(result.modes, start=1):
        lines = wrap(mode.description, 76)
        click.echo(f"{number:>4}{mode.frequency_hz:>10.2f} Hz   {lines[0]}")
        for line in lines[1:]:
            click.echo(" " * 20 + line)
    for motion in result.free_motions:
        click.echo(f"free        {motion}")
    for motion in result.idle_motions:
        click.echo(f"idle        {motion}")
    if result.rules:
        heading("masses")
    alike: dict[str, list[str]] = {}
    for name, rule in result.rules.items():
        alike.setdefault(rule, []).append(name)
    for rule, names in alike.items():
        text = f"{', '.join(names)}: {rule}"
        click.echo(fill(text, 98, initial_indent="  ", subsequent_indent="    "))
    show_notes(result.notes)


def tool_in_words(tool: NDArray[np.float64]) -> str:
    """Return a tool pose (6,), m and rad, in mm and degrees."""
    return _values(DIRECTIONS, tool, "mm", "deg")


_FACTOR = {"mm": 1e3, "deg": 180.0 / np.pi}


def _values(names: tuple[str, ...], values: NDArray[np.float64], length: str, angle: str) -> str:
    words = []
    for name, value in zip(names, values, strict=True):
        unit = angle if name.startswith("r") else length
        rounded = round(float(value * _FACTOR[unit]), 6) + 0.0
        words.append(f"{name} {rounded:.6g} {unit}")
    return ", ".join(words)


def _show_axes(title: str, axes: PrincipalAxes | None, factor: float) -> None:
    if axes is None:
        return
    heading(f"{title}, along its principal directions (weakest first)")
    for value, direction in zip(axes.stiffness, axes.directions.T, strict=True):
        words = ", ".join(f"{x + 0.0:6.3f}" for x in direction)
        shown = f"{factor * value:>12.5g}" if np.isfinite(value) else f"{'rigid':>12}"
        click.echo(f"  {shown}   ({words})")


_ROUNDING = 1e-13
"""Share of what an entry of a symmetric matrix can be beside its diagonal that is rounding."""


def _show_matrix(matrix: NDArray[np.float64]) -> None:
    diagonal = np.sqrt(np.abs(np.diag(matrix)))
    rounding = np.abs(matrix) <= _ROUNDING * np.outer(diagonal, diagonal)
    for row in np.where(rounding, 0.0, matrix):
        click.echo("  " + "".join(f"{x + 0.0:>13.4e}" for x in row))


@contextmanager
def progress(enabled: bool) -> Iterator[Progress]:
    """Show a bar on a terminal, and nothing elsewhere."""
    if not enabled:
        yield no_progress
        return
    from rich import progress as bars
    from rich.console import Console

    columns = (
        bars.TextColumn("{task.description:<24}"),
        bars.BarColumn(),
        bars.TimeElapsedColumn(),
    )
    with bars.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=1.0)
        yield lambda what, share: bar.update(task, description=what, completed=share)
