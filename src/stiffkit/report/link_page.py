"""A link from CAD as one page that needs nothing but a browser."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.fea.cad_link import CadLink
from stiffkit.link.ports import BASE, in_words
from stiffkit.report.compliance import UNITS_MM, compliance_matrix, scale_of, with_power
from stiffkit.report.link_readings import readings_section
from stiffkit.report.pictures import figure, is_drawing
from stiffkit.report.tables import bullet_list, card, pair_table
from stiffkit.report.template import fill, page, write_text

_WHOLE = (
    '<p class="hint">Each port under loads at itself, the others free. The whole matrix, with what'
    " a load at one port does at another, stands in the link file.</p>"
)


def write_link_page(link: CadLink, figures: Sequence[Path], path: Path) -> None:
    """Write a link as one self-contained page; the drawings among ``figures`` are shown.

    Raises OutputError if a figure cannot be read or the page cannot be written.
    """
    write_text(_page(link, figures), path, "report")


def _page(link: CadLink, figures: Sequence[Path]) -> str:
    shown = {path.stem: figure(path) for path in figures if is_drawing(path)}
    interfaces = link.solved.facts["interfaces"].items()
    kinds = ", ".join(f"{name} {one['interface']}" for name, one in reversed(interfaces))
    scope = f"{kinds[:1].upper()}{kinds[1:]}, from {link.spec.cad.name}."
    main = fill(
        "link.html",
        cards=_cards(link),
        compliance_mm=_compliances(link, millimetres=True),
        compliance_si=_compliances(link, millimetres=False),
        whole=_WHOLE if len(link.solved.ports) > 1 else "",
        beams=_beams(link),
        interfaces=pair_table(_interfaces(link)),
        readings=readings_section(link),
        steps=_steps(link),
        convergence=shown.get("convergence", ""),
        mesh=shown.get("mesh", ""),
        shapes=shown.get("shapes", ""),
        notes=bullet_list(link.notes, otherwise="None."),
    )
    return page(
        "link from CAD",
        title=link.spec.title,
        scope=scope,
        version=__version__,
        styles=(),
        main=main,
        made=_provenance(link),
    )


def _cards(link: CadLink) -> str:
    solved = link.solved
    wanted = solved.facts["tolerance"]
    asked = "one mesh was asked for" if wanted is None else f"{_percent(wanted)} % was asked for"
    values = solved.element.mode_stiffness
    first = f"{np.sqrt(values[0]) / (2.0 * np.pi):.5g}" if values.size else "–"
    return "".join(
        [
            card(
                "Estimated error",
                _percent(solved.estimate),
                "%",
                f"of the compliance, over all loads; {asked}",
            ),
            card("Mass", f"{solved.mass:.4g}", "kg", "by the CAD kernel's volume"),
            card("Unknowns", f"{solved.facts['unknowns']}", "", f"order {solved.facts['order']}"),
            card("First mode", first, "Hz", f"with {in_words([BASE, *solved.ports])} held"),
        ]
    )


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.2g}"


def _compliances(link: CadLink, *, millimetres: bool) -> str:
    """Return the compliance of each port under loads at itself."""
    ports = list(link.solved.ports)
    tables = []
    for at, name in enumerate(ports):
        own = slice(6 * at, 6 * at + 6)
        head = f"<h3>{escape(name)}</h3>" if len(ports) > 1 else ""
        tables.append(f"{head}{_matrix(link.compliance[own, own], millimetres=millimetres)}")
    return "".join(tables)


def _matrix(k: NDArray[np.float64], *, millimetres: bool) -> str:
    k = k * scale_of(millimetres=millimetres)
    return compliance_matrix(
        lambda i, j: f"<td>{with_power(k[i, j], 5)}</td>", millimetres=millimetres
    )


def _beams(link: CadLink) -> str:
    """Return the section about approximations by beams; nothing where there are none."""
    if not link.beams:
        return ""
    millimetres = np.repeat([1e3, 1e-3], 3)
    rows = [_beam_row("finite elements", millimetres * np.diag(link.compliance), "{:.3e}")]
    for one in link.beams:
        gap = f", ends {1e3 * one.gap:.3g} mm from the tip" if one.has_gap else ""
        rows.append(_beam_row(one.name + gap, millimetres * np.diag(one.compliance), "{:.3e}"))
        rows.append(_beam_row("over finite elements", one.ratios(link.compliance), "{:.3f}"))
    units = [UNITS_MM[i // 3][i // 3] for i in range(6)]
    heads = "".join(f'<th scope="col">k{i}{i}, {unit}</th>' for i, unit in enumerate(units, 1))
    table = (
        f'<table class="figures"><thead><tr><td></td>{heads}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )
    return fill("link_beams.html", table=table)


def _beam_row(name: str, values: NDArray[np.float64], form: str) -> str:
    cells = "".join(f"<td>{form.format(x)}</td>" for x in values)
    return f'<tr><th scope="row">{escape(name)}</th>{cells}</tr>'


def _interfaces(link: CadLink) -> list[tuple[str, str]]:
    pairs = []
    for name, one in link.solved.facts["interfaces"].items():
        numbers = ", ".join(map(str, one["numbers"]))
        place = ", ".join(f"{1e3 * x:.6g}" for x in _without_noise(one["at"], link))
        words = f"{one['interface']}: face {numbers} ({one['faces']}), {1e6 * one['area']:.5g} mm²"
        pairs.append((name, f"{words}, at ({place}) mm in part axes"))
    return pairs


def _without_noise(place: Sequence[float], link: CadLink) -> NDArray[np.float64]:
    """Return a point with 0 for what rounding has left of it."""
    out = np.array(place)
    out[np.abs(out) < 1e-9 * max(link.solved.facts["size"])] = 0.0
    return out


def _steps(link: CadLink) -> str:
    heads = ("mesh", "order", "elements", "unknowns", "seconds", "estimate, %", "from result, %")
    top = "".join(f'<th scope="col">{head}</th>' for head in heads)
    rows = "".join(
        f"<tr><td>{step.mesh}</td><td>{step.orders}</td><td>{step.elements}</td>"
        f"<td>{step.unknowns}</td><td>{step.seconds:.1f}</td><td>{_percent(step.estimate)}</td>"
        f"<td>{_percent(step.change)}</td></tr>"
        for step in link.solved.steps
    )
    return f'<table class="figures"><thead><tr>{top}</tr></thead><tbody>{rows}</tbody></table>'


def _provenance(link: CadLink) -> list[tuple[str, str]]:
    facts = link.solved.facts
    size = " x ".join(f"{1e3 * length:.5g}" for length in facts["size"])
    materials = "; ".join(f"{law['name']} ({name})" for name, law in facts["materials"].items())
    return [
        ("stiffkit version", __version__),
        (link.spec.cad.name, f"SHA-256 {link.cad_hash}"),
        ("part", f"{size} mm, {facts['faces']} faces, unit of the file: {facts['unit']}"),
        ("material", materials),
        ("mesh", f"{facts['mesh']}; {facts['elements']} elements"),
        ("volume, area against CAD", f"{facts['volume_error']:.1e}, {facts['area_error']:.1e}"),
    ]
