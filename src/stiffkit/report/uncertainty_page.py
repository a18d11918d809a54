"""A study of uncertainty as one page that needs nothing but a browser."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from stiffkit.design.uncertainty.summary import (
    PartRow,
    Summary,
    asked_names,
    part_rows,
    summaries,
)
from stiffkit.plots import display_unit, format_value, position_text
from stiffkit.plots.quantities import kind_of
from stiffkit.plots.uncertainty_maps import title_of
from stiffkit.report.pictures import figure, is_drawing
from stiffkit.report.tables import bullet_list, card, provenance
from stiffkit.report.template import fill, page, write_text
from stiffkit.units import format_quantity

_WORDS = ("model", "kind", "where", "sources of the variance")
"""Columns that hold words, and no numbers."""

_LIMIT = (
    "Where two directions of a posture are equally weak, the weakest stiffness has a kink, and "
    "a band of the first order is too narrow or too wide there: the check by samples tells by how "
    "much."
)


def write_uncertainty_page(dataset: xr.Dataset, figures: Sequence[Path], path: Path) -> None:
    """Write a study as one self-contained page; the drawings among ``figures`` are shown.

    Raises OutputError if a figure cannot be read or the page cannot be written.
    """
    write_text(_page(dataset, figures), path, "report")


def _page(dataset: xr.Dataset, figures: Sequence[Path]) -> str:
    found = summaries(dataset)
    options = json.loads(str(dataset.attrs["options"]))
    shown = [path for path in figures if is_drawing(path)]
    main = fill(
        "uncertainty.html",
        cards="".join(_cards(dataset, found)),
        uncertain=bullet_list(_uncertain(options)),
        reading=bullet_list(_reading(dataset)),
        bands=_bands(found),
        sources=_gallery(shown, "sources-"),
        workspace=_gallery(shown, "map-", "band-"),
        ranking="".join(_rankings(dataset, shown)),
        check=_check(found, shown, dataset),
    )
    models = " and ".join(str(model) for model in dataset["model"].values)
    return page(
        "study of uncertainty",
        title=str(dataset.attrs["title"]),
        scope=f"{dataset.attrs['robot_title']}, {models} model, bands of {_confidence(dataset)}.",
        version=str(dataset.attrs["stiffkit_version"]),
        styles=(),
        main=main,
        made=provenance(dataset.attrs),
    )


def _confidence(dataset: xr.Dataset) -> str:
    return f"{100.0 * float(dataset.attrs['confidence']):g} %"


def _amount(summary: Summary, value: float) -> str:
    """Return a value of a quantity in a unit for reading."""
    return display_unit(kind_of(summary.quantity), [value]).text(float(f"{value:.4g}"))


def _band(summary: Summary, value: float, half: float) -> str:
    unit = display_unit(kind_of(summary.quantity), [value])
    middle, width = (float(f"{x / unit.size:.{n}g}") for x, n in ((value, 4), (half, 2)))
    return f"{format_value(middle)} ± {format_value(width)} {unit.symbol}"


def _place(summary: Summary) -> str:
    return position_text(summary.worst_at.items())


def _cards(dataset: xr.Dataset, found: Sequence[Summary]) -> Iterator[str]:
    for one in found[:3]:
        kind = "largest" if one.quantity.worst_is_largest else "smallest"
        share = 100.0 * one.worst_half / abs(one.worst) if one.worst else 0.0
        details = f"band of {_confidence(dataset)}, {one.model} model, at {_place(one)}"
        title = f"{one.title}, {kind}"
        yield card(title, _amount(one, one.worst), f"± {share:.2g} %", details)
    if found:
        source, share = next(iter(found[0].causes.items()))
        details = f"of the variance of {found[0].name}, mean over the workspace"
        yield card("Largest source", source, f"{100.0 * share:.0f} %", details)


def _uncertain(options: dict[str, Any]) -> Iterator[str]:
    """Yield in words what is uncertain."""
    for one in options["parameters"]:
        value = format_quantity(one["value"], one["unit"])
        size = one["sigma"] * (np.sqrt(3.0) if one["distribution"] == "uniform" else 1.0)
        error = format_quantity(size, one["unit"], digits=4)
        if one["distribution"] == "uniform":
            yield f"{one['name']}: {value}, within ± {error}, evenly distributed"
        else:
            yield f"{one['name']}: {value}, standard deviation {error}, normally distributed"
    for one in options["links"]:
        if one["relative"] is None:
            yield f"link {one['name']}: the covariance that it was identified with"
        else:
            yield (
                f"link {one['name']}: one factor for its compliance, standard deviation "
                f"{100.0 * one['relative']:.4g} %"
            )


def _reading(dataset: xr.Dataset) -> list[str]:
    return [
        "All of these are independent of each other. The tool is at the same pose in all robots: "
        "they differ in stiffness, not in accuracy.",
        f"Bands hold {_confidence(dataset)} of robots where errors are small enough for the first "
        "order.",
        _LIMIT,
    ]


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table whose first column names the rows."""
    top = "".join(f'<th scope="col"{_words(head)}>{escape(head)}</th>' for head in heads)
    body = "".join(
        f'<tr><th scope="row">{escape(row[0])}</th>'
        + "".join(
            f"<td{_words(head)}>{escape(x)}</td>"
            for head, x in zip(heads[1:], row[1:], strict=True)
        )
        + "</tr>"
        for row in rows
    )
    return (
        f'<div class="scroll"><table class="figures"><thead><tr>{top}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _words(head: str) -> str:
    return ' class="words"' if head in _WORDS else ""


def _bands(found: Sequence[Summary]) -> str:
    if not found:
        return "<p>No posture of the workspace has an answer.</p>"
    rows = [
        (
            f"{one.title} ({one.name})",
            one.model,
            _band(one, one.mean, one.mean_half),
            _band(one, one.worst, one.worst_half),
            _place(one),
            _causes(one),
        )
        for one in found
    ]
    heads = ("quantity", "model", "mean", "worst", "where", "sources of the variance")
    return _table(heads, rows)


def _causes(one: Summary) -> str:
    told = [f"{name} {100.0 * share:.0f} %" for name, share in one.causes.items() if share > 0.005]
    return ", ".join(told[:4]) + (", others" if len(told) > 4 else "") or "nothing scatters"


def _rankings(dataset: xr.Dataset, shown: Sequence[Path]) -> Iterator[str]:
    for name in asked_names(dataset):
        rows = part_rows(dataset, name)
        if not rows:
            continue
        heads = ("part", "kind", "share, %", "at the worst, %", "mass, kg", "gain, %/kg")
        table = _table(heads, [_part(row) for row in rows])
        yield (
            f"<h3>{escape(title_of(dataset, name))}</h3>{_gallery(shown, f'ranking-{name}.')}"
            f"<details><summary>All parts</summary>{table}</details>"
        )


def _part(row: PartRow) -> tuple[str, ...]:
    shares = (f"{round(100.0 * x, 2) + 0.0:.2f}" for x in (row.share, row.share_at_worst))
    others = (round(x, 4) + 0.0 for x in (row.mass, 100.0 * row.gain_per_kg))
    return (row.name, row.kind, *shares, *(format_value(float(f"{x:.3g}")) for x in others))


def _check(found: Sequence[Summary], shown: Sequence[Path], dataset: xr.Dataset) -> str:
    sampled = [(one, one.coverage) for one in found if one.coverage is not None]
    if not sampled:
        return "<p>Nothing was sampled.</p>"
    rows = [
        (one.name, one.model, *(f"{100.0 * x:.1f}" for x in (c.mean, c.lowest, c.highest)))
        for one, c in sampled
    ]
    heads = ("quantity", "model", "coverage, %", "lowest", "highest")
    refused = int(dataset.attrs["samples_refused"])
    told = f" {refused} more cannot be built or assembled." if refused else ""
    hint = (
        f"Of {dataset.attrs['samples']} robots drawn at random, so many lie within the bands of "
        f"the first order; {_confidence(dataset)} are asked.{told}"
    )
    return f'{_gallery(shown, "check-")}{_table(heads, rows)}<p class="hint">{hint}</p>'


def _gallery(shown: Sequence[Path], *beginnings: str) -> str:
    """Return those of some pictures whose names begin so, inside the page."""
    return "".join(figure(path) for path in shown if path.name.startswith(beginnings))
