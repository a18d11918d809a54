"""The command about parametric parts."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from stiffkit.cli.arguments import json_option, output_option, set_option, set_values
from stiffkit.errors import CadError

if TYPE_CHECKING:
    from stiffkit.fea.parts import ParametricPart
    from stiffkit.fea.sources import RegisteredPart

_WIDTH = 98


@click.command()
@click.argument("name", metavar="[NAME]", required=False)
@set_option("a dimension", "length=160mm")
@output_option("STEP file to write.")
@json_option
def parts(name: str | None, settings: tuple[str, ...], output: Path | None, as_json: bool) -> None:
    """List the parametric parts, or show one of them with its dimensions and faces.

    Link specifications and robot files take a part by its name and the dimensions that differ from
    the defaults. With -o it is written as STEP.

    Example:  stiffkit parts orthoglide-foot --set length=160mm -o foot.step
    """
    from stiffkit.cli.show import tell
    from stiffkit.fea.parts import PARTS, find_part

    if name is None:
        if settings or output is not None:
            raise CadError("no part is named", mend=f"name one of {', '.join(PARTS)}")
        tell(list(PARTS.values()), _show_list, _plain_list, as_json=as_json)
        return
    part = find_part(name)
    made = _made(part, settings)
    if output is not None:
        from stiffkit.fea.sources import write_step

        write_step(made, output)
    written = [] if output is None else [f"part: {output}"]
    tell(made, partial(_show, part), partial(_plain, part), as_json=as_json, written=written)


def _made(part: ParametricPart, settings: tuple[str, ...]) -> RegisteredPart:
    """Return the part with the dimensions that were set."""
    from stiffkit.fea.sources import RegisteredPart
    from stiffkit.units import to_si

    values = {
        key: to_si(value, part.dimension(key).unit) for key, value in set_values(settings).items()
    }
    return RegisteredPart(part.name, values)


def _plain_list(found: list[ParametricPart]) -> list[dict[str, str]]:
    return [{"part": part.name, "title": part.title} for part in found]


def _show_list(found: list[ParametricPart]) -> None:
    width = max(len(part.name) for part in found)
    for part in found:
        click.echo(f"{part.name:<{width}}  {part.title}")


def _show(part: ParametricPart, made: RegisteredPart) -> None:
    from stiffkit.cli.show import heading

    heading(part.title)
    click.echo(fill(part.description, _WIDTH, initial_indent="  ", subsequent_indent="  "))
    heading("dimensions")
    wide = max(len(one.name) for one in part.dimensions)
    for one in part.dimensions:
        value = f"{1e3 * made.dimensions[one.name]:.6g} mm"
        source = one.source if made.dimensions[one.name] == one.default else "given"
        click.echo(f"  {one.name:<{wide}}{value:>11}  {one.means}")
        indent = " " * (wide + 15)
        click.echo(fill(source, _WIDTH, initial_indent=indent, subsequent_indent=indent))
    heading("faces")
    for name, what in part.faces.items():
        click.echo(f"  {name:<{wide}}  {what}")


def _plain(part: ParametricPart, made: RegisteredPart) -> dict[str, Any]:
    return {
        "part": part.name,
        "title": part.title,
        "description": part.description,
        "dimensions": [
            {
                "name": one.name,
                "value": made.dimensions[one.name],
                "default": one.default,
                "means": one.means,
                "source": one.source,
            }
            for one in part.dimensions
        ],
        "faces": dict(part.faces),
    }
