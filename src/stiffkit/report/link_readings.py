"""How far the faces of a link's ports are from moving rigidly, as a section of its page."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from stiffkit.fea.cad_link import CadLink

_HEADS = ("sigma, nm", "largest, nm", "of the motion, %")


def readings_section(link: CadLink) -> str:
    """Return tables of what a rigid motion leaves at each port, and what they mean."""
    readings = link.solved.facts["readings"]
    parts = [_table(name, one["loads"]) for name, one in readings.items()]
    parts += [f'<p class="hint">{escape(text)}.</p>' for text in _meanings(readings)]
    return "".join(parts)


def _meanings(readings: Mapping[str, Any]) -> list[str]:
    """Return the sentences that the readings call for, each once."""
    found = {one["meaning"]: None for one in readings.values() if one["meaning"]}
    return [text[0].upper() + text[1:] for text in found]


def _table(port: str, loads: Mapping[str, Any]) -> str:
    heads = (
        '<th class="words" scope="col">load</th>'
        + "".join(f'<th scope="col">{head}</th>' for head in _HEADS)
        + '<th class="words" scope="col">what it looks like</th>'
    )
    rows = "".join(_row(name, load) for name, load in loads.items())
    return (
        f"<h3>{escape(port)}</h3>"
        f'<div class="scroll"><table class="figures"><thead><tr>{heads}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _row(name: str, load: Mapping[str, Any]) -> str:
    unit = "1 N" if name.startswith("F") else "1 N m"
    cells = (
        f"{1e9 * load['sigma']:.3g}",
        f"{1e9 * load['largest']:.3g}",
        f"{100.0 * load['share']:.2g}",
    )
    shown = "".join(f"<td>{cell}</td>" for cell in cells)
    words = f'<td class="words">{escape(load["residuals"])}</td>'
    return f'<tr><th scope="row" class="load">{name} = {unit}</th>{shown}{words}</tr>'
