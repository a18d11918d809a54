"""The report: one HTML file that needs nothing but a browser."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import xarray as xr

from stiffkit.plots import models_of
from stiffkit.report.payload import json_text, payload_of
from stiffkit.report.pictures import figure, is_drawing
from stiffkit.report.tables import (
    bullet_list,
    cards,
    key_figure_table,
    pair_table,
    provenance,
)
from stiffkit.report.template import Script, fill, page, write_text
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
    write_text(_page(dataset, summary, figures), path, "report")


def _page(dataset: xr.Dataset, summary: Sequence[tuple[str, str]], figures: Sequence[Path]) -> str:
    rows = key_figures(dataset)
    payload = payload_of(dataset)
    attrs = dataset.attrs
    version = str(attrs.get("stiffkit_version", ""))
    models = (" and ".join(models_of(dataset)) + " model").capitalize()
    main = fill(
        "map.html",
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
    )
    return page(
        "stiffness map",
        title=str(attrs.get("title") or attrs.get("robot") or "Robot"),
        scope=f"{scope_in_words(dataset)}. {models}.",
        version=version,
        styles=(),
        main=main,
        made=provenance(attrs),
        script=Script("The maps on this page are", json_text(payload), _SCRIPTS, uses_plotly=True),
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
    """Return the figures inside the page, or nothing if there are none."""
    # The names are those of the files that a paper takes.
    shown = [figure(path, caption=path.stem) for path in figures if is_drawing(path)]
    if not shown:
        return ""
    return (
        f'<section><details class="drawn-too" open><summary>Figures for print ({len(shown)})'
        f"</summary>{''.join(shown)}</details></section>"
    )
