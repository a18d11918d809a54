"""Parts and links from CAD as text for a terminal."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from stiffkit.cli.show import heading
from stiffkit.link.ports import BASE, in_words

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stiffkit.fea import Face, Part
    from stiffkit.fea.cad_link import CadLink

WIDTH = 98


def show_faces(part: Part) -> None:
    """Print what the part is, and its faces, one a line."""
    size = " x ".join(f"{1e3 * length:.6g}" for length in part.high - part.low)
    heading(f"{part.name}: {size} mm, {1e6 * part.volume:.6g} cm3")
    click.echo(f"  unit of the file: {part.unit}; {len(part.solids)} solids: ", nl=False)
    click.echo(", ".join(solid.name for solid in part.solids))
    heads = ("face", "kind", "area mm2", "centre mm", "normal", "radius, axis mm", "name, colour")
    row = "{:>5}  {:<9}{:>11}  {:<28}{:<23}{:<30}{}"
    click.echo(row.format(*heads).rstrip())
    for face in part.faces:
        cells = (
            face.index,
            face.kind,
            f"{1e6 * face.area:.5g}",
            _vector(1e3 * face.centre, 6),
            _vector(face.normal, 3),
            _round(face),
            _marks(face),
        )
        click.echo(row.format(*cells).rstrip())


def _round(face: Face) -> str:
    if face.radius is None or face.axis is None:
        return ""
    return f"{1e3 * face.radius:.5g} along {_vector(face.axis, 3)}"


def _marks(face: Face) -> str:
    colour = "" if face.colour is None else "({:.3g}, {:.3g}, {:.3g})".format(*face.colour)
    return " ".join(word for word in (face.name, colour) if word)


def _vector(values: NDArray[np.float64], digits: int) -> str:
    return "({})".format(", ".join(f"{round(float(x), 4) + 0.0:.{digits}g}" for x in values))


def faces_as_json(part: Part) -> dict[str, Any]:
    """Return a part and its faces as plain values, SI."""
    return {
        "part": part.name,
        "unit": part.unit,
        "low": part.low.tolist(),
        "high": part.high.tolist(),
        "volume": part.volume,
        "solids": [solid.name for solid in part.solids],
        "faces": [
            {
                "number": face.index,
                "kind": face.kind,
                "area": face.area,
                "centre": face.centre.tolist(),
                "normal": face.normal.tolist(),
                "radius": face.radius,
                "axis": None if face.axis is None else face.axis.tolist(),
                "axis_point": None if face.axis_point is None else face.axis_point.tolist(),
                "name": face.name,
                "colour": None if face.colour is None else list(face.colour),
            }
            for face in part.faces
        ],
    }


def show_link(link: CadLink) -> None:
    """Print what was found: interfaces, compliance with its estimated error, the way there."""
    solved, facts = link.solved, link.solved.facts
    heading(link.spec.title)
    _fact("part", f"{link.spec.cad.name}, {facts['faces']} faces")
    for name, one in facts["interfaces"].items():
        numbers = ", ".join(map(str, one["numbers"]))
        place = _vector(1e3 * np.array(one["at"]), 6)
        _fact(name, f"{one['interface']}, face {numbers} ({one['faces']}), at {place} mm")
    for name, law in facts["materials"].items():
        _fact("material", f"{law['name']} ({name})")
    _fact("mass", f"{solved.mass:.6g} kg, centre {_vector(1e3 * solved.center_of_mass, 6)} mm")
    for name, frame in solved.ports.items():
        _fact(name, f"{_vector(1e3 * frame.position, 6)} mm in link axes")
    for at, name in enumerate(solved.ports):
        heading(f"compliance (m/N, 1/N; 1/N, rad/(N m)) of {name} with the base held, link axes")
        own = slice(6 * at, 6 * at + 6)
        for row in link.compliance[own, own]:
            click.echo("  " + "".join(f"{x + 0.0:>14.4e}" for x in row))
    if len(solved.ports) > 1:
        click.echo("  each port under loads at itself; the link file holds the whole matrix")
    click.echo(f"  estimated error, over all loads: {_percent(solved.estimate)}")
    for name, one in facts["readings"].items():
        load, left = max(one["loads"].items(), key=lambda item: float(item[1]["share"]))
        told = "as one rigid body" if one["rigid"] else f"rigidly but for {_percent(left['share'])}"
        click.echo(f"  the faces of {name} move {told}" + ("" if one["rigid"] else f" ({load})"))
    _show_beams(link)
    if solved.element.mode_stiffness.size:
        hertz = np.sqrt(solved.element.mode_stiffness) / (2.0 * np.pi)
        shown = ", ".join(f"{f:.5g}" for f in hertz)
        heading(f"natural frequencies with {in_words([BASE, *solved.ports])} held, Hz")
        click.echo(fill(shown, WIDTH, initial_indent="  ", subsequent_indent="  "))
    heading("solutions")
    click.echo(
        f"  {'mesh':>4}{'order':>8}{'elements':>10}{'unknowns':>10}{'seconds':>9}"
        f"{'estimate':>11}{'from result':>13}"
    )
    for step in solved.steps:
        click.echo(
            f"  {step.mesh:>4}{step.orders:>8}{step.elements:>10}{step.unknowns:>10}"
            f"{step.seconds:>9.1f}{_percent(step.estimate):>11}{_percent(step.change):>13}"
        )
    if link.from_cache:
        click.echo("  solved before, taken from the cache")
    for note in link.notes:
        told = fill(f"note: {note}", WIDTH, subsequent_indent="  ")
        click.echo(click.style("note: ", fg="yellow", bold=True) + told.removeprefix("note: "))


def _show_beams(link: CadLink) -> None:
    """Print the diagonals of approximations by beams beside that of the solution."""
    if not link.beams:
        return
    heading("diagonal of the compliance (mm/N; rad/(N mm)), and of beams over it")
    millimetres = np.repeat([1e3, 1e-3], 3)
    rows = [("finite elements", millimetres * np.diag(link.compliance), "{:.3e}")]
    for one in link.beams:
        rows.append((one.name, millimetres * np.diag(one.compliance), "{:.3e}"))
        rows.append(("  ratio", one.ratios(link.compliance), "{:.3f}"))
    width = max(len(name) for name, _, _ in rows)
    names = "".join(f"{f'k{i}{i}':>12}" for i in range(1, 7))
    click.echo(f"  {'':<{width}}{names}")
    for name, values, form in rows:
        click.echo(f"  {name:<{width}}" + "".join(f"{form.format(x):>12}" for x in values))
    for one in link.beams:
        if one.has_gap:
            click.echo(f"  {one.name} ends {1e3 * one.gap:.3g} mm from the tip, a rigid way")


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100.0 * share:.2g} %"


def _fact(name: str, value: str) -> None:
    click.echo(fill(f"{name:<12}{value}", WIDTH, subsequent_indent=" " * 12))
