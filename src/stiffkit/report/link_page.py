"""A link from CAD as one page that needs nothing but a browser."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.fea.cad_link import CadLink
from stiffkit.report.page import asset, write_text
from stiffkit.report.tables import bullet_list, card, pair_table
from stiffkit.robot import DIRECTIONS


def write_link_page(link: CadLink, figures: Sequence[Path], path: Path) -> None:
    """Write a link as one self-contained page; the PNG ones of ``figures`` are shown in it.

    Raises OutputError if a figure cannot be read or the page cannot be written.
    """
    write_text(_page(link, figures), path, "report")


def _page(link: CadLink, figures: Sequence[Path]) -> str:
    shown = {path.stem: path for path in figures if path.suffix == ".png"}
    millimetres = np.ones((6, 6))
    millimetres[:3, :3], millimetres[3:, 3:] = 1e3, 1e-3
    kinds = {name: one["interface"] for name, one in link.solved.facts["interfaces"].items()}
    scope = f"Tip {kinds['tip']}, base {kinds['base']}, from {link.spec.cad.name}."
    return Template(asset("link.html")).substitute(
        title=escape(link.spec.title),
        scope=escape(scope),
        version=escape(__version__),
        style=asset("page.css"),
        cards=_cards(link),
        compliance_mm=_matrix(millimetres * link.compliance),
        compliance_si=_matrix(link.compliance),
        interfaces=pair_table(_interfaces(link)),
        steps=_steps(link),
        convergence=_image(shown, "convergence"),
        mesh=_image(shown, "mesh"),
        shapes=_image(shown, "shapes"),
        notes=bullet_list(link.notes, otherwise="None."),
        provenance=pair_table(_provenance(link)),
    )


def _cards(link: CadLink) -> str:
    solved = link.solved
    wanted = solved.facts["tolerance"]
    asked = "one mesh was asked for" if wanted is None else f"{_percent(wanted)} % was asked for"
    values = solved.element.mode_stiffness
    first = f"{np.sqrt(values[0]) / (2.0 * np.pi):.4g}" if values.size else "–"
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
            card("First mode", first, "Hz", "with base and tip held"),
        ]
    )


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.2g}"


def _matrix(k: NDArray[np.float64]) -> str:
    heads = "".join(f'<th scope="col">{name}</th>' for name in DIRECTIONS)
    rows = "".join(
        f'<tr><th scope="row">{name}</th>' + "".join(f"<td>{x:.4e}</td>" for x in row) + "</tr>"
        for name, row in zip(DIRECTIONS, k, strict=True)
    )
    head = f"<thead><tr><th></th>{heads}</tr></thead>"
    return f'<table class="figures">{head}<tbody>{rows}</tbody></table>'


def _interfaces(link: CadLink) -> list[tuple[str, str]]:
    pairs = []
    for name, one in link.solved.facts["interfaces"].items():
        numbers = ", ".join(map(str, one["numbers"]))
        place = ", ".join(f"{1e3 * x:.6g}" for x in one["at"])
        words = f"{one['interface']}: face {numbers} ({one['faces']}), {1e6 * one['area']:.5g} mm²"
        pairs.append((name, f"{words}, at ({place}) mm in part axes"))
    return pairs


def _steps(link: CadLink) -> str:
    heads = ("mesh", "order", "elements", "unknowns", "seconds", "estimate, %", "from last, %")
    top = "".join(f'<th scope="col">{head}</th>' for head in heads)
    rows = "".join(
        f"<tr><td>{step.mesh}</td><td>{step.order}</td><td>{step.elements}</td>"
        f"<td>{step.unknowns}</td><td>{step.seconds:.1f}</td><td>{_percent(step.estimate)}</td>"
        f"<td>{_percent(step.change)}</td></tr>"
        for step in link.solved.steps
    )
    return f'<table class="figures"><thead><tr>{top}</tr></thead><tbody>{rows}</tbody></table>'


def _image(shown: dict[str, Path], name: str) -> str:
    if name not in shown:
        return ""
    content = base64.b64encode(shown[name].read_bytes()).decode("ascii")
    return f'<figure><img alt="{name}" src="data:image/png;base64,{content}"></figure>'


def _provenance(link: CadLink) -> list[tuple[str, str]]:
    facts = link.solved.facts
    size = " x ".join(f"{1e3 * length:.5g}" for length in facts["size"])
    materials = "; ".join(f"{law['name']} ({name})" for name, law in facts["materials"].items())
    return [
        ("Tool", f"stiffkit {__version__}"),
        (link.spec.cad.name, f"SHA-256 {link.cad_hash}"),
        ("Part", f"{size} mm, {facts['faces']} faces, unit of the file: {facts['unit']}"),
        ("Material", materials),
        ("Mesh", f"{facts['mesh']}; {facts['elements']} elements"),
        ("Volume, area against CAD", f"{facts['volume_error']:.1e}, {facts['area_error']:.1e}"),
    ]
