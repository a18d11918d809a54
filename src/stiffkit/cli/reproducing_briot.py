"""What the command that reproduces papers shows and writes of Briot 2009."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from stiffkit.plots.panels import Lines
    from stiffkit.reproduce import Briot2009, Statement

    Array = NDArray[np.float64]

WIDTH = 98


def show_statements(statements: tuple[Statement, ...]) -> None:
    """Print each sentence of the paper with what comes out here."""
    for statement in statements:
        click.echo(f"{statement.where}: {statement.outcome.value}")
        for name, text in (
            ("paper", statement.printed),
            ("ours", statement.ours),
            ("why", statement.why),
        ):
            if text:
                head = f"  {name:<7}"
                click.echo(fill(text, WIDTH, initial_indent=head, subsequent_indent=" " * 9))
    counts = {one.outcome.value: 0 for one in statements}
    for statement in statements:
        counts[statement.outcome.value] += 1
    click.echo(", ".join(f"{count} {name}" for name, count in counts.items()))


def write_figures(found: Briot2009, output: Path, stem: str) -> str:
    """Write figures 3, 5 to 7, 10, 12 and 13 as ``stem``-3 and so on; return which, in words."""
    from stiffkit.plots import style
    from stiffkit.plots.panels import panel_figure

    for number, (lines, heading) in _figures(found).items():
        style.save(panel_figure(lines, heading), output / f"{stem}-{number}")
    return "Figures 3, 5, 6, 7, 10, 12 and 13"


def _figures(found: Briot2009) -> dict[int, tuple[Lines, str]]:
    return {**_of_the_machine(found), **_of_the_family(found)}


def _of_the_machine(found: Briot2009) -> dict[int, tuple[Lines, str]]:
    from stiffkit.plots.panels import Lines

    machine = found.machine
    simplified, refined = machine.deflections["simplified"], machine.deflections["refined"]
    along, deflection, frequency = "x (mm)", "deflection (µm)", "frequency (Hz)"
    x = 1e3 * machine.x
    return {
        3: (
            Lines(
                x,
                {
                    "f_x, in plane": 1e6 * simplified["f_x"],
                    "f_y, in plane": 1e6 * simplified["f_y"],
                },
                along,
                deflection,
            ),
            "Deflection under 1000 N, simplified model",
        ),
        5: (
            Lines(x, _deflections(refined), along, deflection),
            "Deflection under 1000 N, refined model",
        ),
        7: (
            Lines(x, {"first": machine.simplified}, along, frequency),
            "First natural frequency, simplified model",
        ),
        10: (
            Lines(
                1e3 * machine.places,
                dict(zip(("first", "second"), machine.refined, strict=True)),
                along,
                frequency,
            ),
            "Natural frequencies, refined model",
        ),
    }


def _of_the_family(found: Briot2009) -> dict[int, tuple[Lines, str]]:
    from stiffkit.plots.panels import Lines
    from stiffkit.reproduce import PLACES

    family = found.family
    loads = {load: family.deflection("refined", load) for load in ("f_x", "f_y", "f_z")}
    panels = tuple(f"({letter}) {place}" for letter, place in zip("abc", PLACES, strict=True))

    def over_alpha(curves: dict[str, Array], y_label: str, *, is_log: bool = False) -> Lines:
        return Lines(
            family.alphas,
            curves,
            "legs' length over the machine's, α",
            y_label,
            panels,
            mark=1.0,
            mark_label="the machine",
            is_log=is_log,
        )

    simplified = family.curve(lambda member: member.simplified)
    modes = {
        "bending along z": family.curve(lambda member: member.along_z),
        "in the plane": family.curve(lambda member: member.in_plane),
    }
    return {
        6: (
            over_alpha(_deflections(loads), "deflection (µm)", is_log=True),
            "Deflection under 1000 N over the length of the legs, refined model",
        ),
        12: (
            over_alpha({"first": simplified}, "frequency (Hz)"),
            "First natural frequency over the length of the legs, simplified model",
        ),
        13: (
            over_alpha(modes, "frequency (Hz)"),
            "Natural frequencies over the length of the legs, refined model",
        ),
    }


def _deflections(loads: Mapping[str, Array]) -> dict[str, Array]:
    names = {"f_x": "f_x, in plane", "f_y": "f_y, in plane", "f_z": "f_z, along z"}
    return {name: 1e6 * loads[load] for load, name in names.items()}
