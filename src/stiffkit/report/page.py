"""The report: one HTML file that needs nothing but a browser."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from html import escape
from importlib import resources
from pathlib import Path
from string import Template

import xarray as xr

from stiffkit.errors import OutputError
from stiffkit.plots import models_of
from stiffkit.report.payload import json_for_script, payload_of
from stiffkit.report.tables import (
    bullet_list,
    cards,
    key_figure_table,
    pair_table,
    provenance,
)
from stiffkit.report.words import (
    key_figures,
    loads_in_words,
    scope_in_words,
    status_in_words,
    texts_of,
)

_SCRIPTS = (
    "numbers.js",
    "data.js",
    "look.js",
    "map.js",
    "lines.js",
    "branches.js",
    "worst.js",
    "main.js",
)
"""In the order in which they build on each other."""


def write_report(
    dataset: xr.Dataset,
    summary: Sequence[tuple[str, str]],
    path: Path,
    figures: Sequence[Path] = (),
) -> None:
    """Write a stiffness map as one self-contained interactive page.

    The page makes no request to any other place: script, style, numbers and figures are inside.
    Maps too large for a browser are shown in blocks of postures, each at its worst, and the page
    says so; tables and key figures come from all postures.

    Args:
        dataset: a stiffness map.
        summary: names and values that describe the robot, in reading order.
        path: the HTML file to write.
        figures: files of figures; those in SVG are shown in the page.

    Raises:
        OutputError: if a figure cannot be read or the page cannot be written.
    """
    # The page shows neither 6x6 matrices nor components, by far the largest part of a map.
    dataset = dataset.drop_vars(["compliance", "deflection"], errors="ignore").compute()
    page = _page(dataset, summary, figures)
    write_text(page, path, "report")


def write_text(text: str, path: Path, what: str) -> None:
    """Write a page, called ``what`` in messages. Raises OutputError if it cannot be written."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(
            f"cannot write the {what} {path}: {error.strerror or error}",
            mend="give a file in a folder that exists and that you may write to",
        ) from error


def _page(dataset: xr.Dataset, summary: Sequence[tuple[str, str]], figures: Sequence[Path]) -> str:
    # It takes a second to import, and only this function needs it.
    from plotly.offline import get_plotlyjs

    rows = key_figures(dataset)
    payload = payload_of(dataset)
    attrs = dataset.attrs
    version = str(attrs.get("stiffkit_version", ""))
    return Template(asset("page.html")).substitute(
        title=escape(str(attrs.get("title") or attrs.get("robot") or "Robot")),
        scope=escape(scope_in_words(dataset)),
        models=escape((" and ".join(models_of(dataset)) + " model").capitalize()),
        version=escape(version),
        style=asset("page.css"),
        cards=cards(dataset, rows),
        decimation=escape(_decimation(payload["blocks"])),
        status=bullet_list(status_in_words(dataset)),
        free_motions=bullet_list(
            texts_of(dataset, "free_motions"),
            otherwise="None: with all drives held, the platform cannot move.",
        ),
        loads=pair_table(loads_in_words(dataset), otherwise="No load case was given."),
        key_figures=key_figure_table(rows, models_of(dataset)),
        summary=pair_table(summary, otherwise="No summary was given."),
        notes=bullet_list(texts_of(dataset, "notes"), otherwise="None."),
        figures=_gallery(figures),
        provenance=pair_table(provenance(attrs)),
        data=json_for_script(payload),
        plotly=inline_script(get_plotlyjs()),
        script=inline_script("\n".join(asset(name) for name in _SCRIPTS)),
    )


def _decimation(blocks: Sequence[int]) -> str:
    if all(size == 1 for size in blocks):
        return ""
    sizes = " × ".join(str(size) for size in blocks)
    return (
        f"The plots show blocks of {sizes} postures, each block at the worst value of its "
        "postures and with the coordinates of the posture in its middle. The tables and the key "
        "figures come from all postures."
    )


def _gallery(figures: Sequence[Path]) -> str:
    """Return the SVG figures as images inside the page, or nothing if there are none."""
    images = []
    for figure in figures:
        if figure.suffix.lower() != ".svg":
            continue
        try:
            content = base64.b64encode(figure.read_bytes()).decode("ascii")
        except OSError as error:
            raise OutputError(
                f"cannot read the figure {figure}: {error.strerror or error}",
                mend="write the figures first, and give their paths as they were returned",
            ) from error
        name = escape(figure.name)
        images.append(
            f'<figure><img alt="{name}" src="data:image/svg+xml;base64,{content}">'
            f"<figcaption>{name}</figcaption></figure>"
        )
    if not images:
        return ""
    return (
        f"<section><details><summary>Figures for print ({len(images)})</summary>"
        f'<div class="gallery">{"".join(images)}</div></details></section>'
    )


def inline_script(code: str) -> str:
    """Return JavaScript that no HTML parser mistakes for the end of its script element."""
    return re.sub(r"<(?=/script|!--)", r"<\\", code, flags=re.IGNORECASE)


def asset(name: str) -> str:
    """Return the text of a file that pages are made of."""
    return resources.files("stiffkit.report").joinpath("assets", name).read_text(encoding="utf-8")
