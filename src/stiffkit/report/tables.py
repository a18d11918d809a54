"""The parts of the page that are plain HTML: cards, tables, lists. All text is escaped here."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stiffkit.plots import (
    Quantity,
    cases_of,
    format_value,
    is_planar,
    main_quantities,
    models_of,
    position_text,
    sweep_of,
    unit_of,
    values_of,
)
from stiffkit.report.payload import worst_postures
from stiffkit.report.words import KeyFigure, Spread

Array = NDArray[np.float64]


def bullet_list(texts: Iterable[str], *, otherwise: str = "") -> str:
    """Return texts as an HTML list, or the paragraph ``otherwise`` if there are none."""
    items = "".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>{items}</ul>" if items else f"<p>{escape(otherwise)}</p>"


def pair_table(pairs: Sequence[tuple[str, str]], *, otherwise: str = "") -> str:
    """Return names and values as an HTML table of two columns."""
    if not pairs:
        return f"<p>{escape(otherwise)}</p>"
    rows = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td>{escape(value)}</td></tr>'
        for name, value in pairs
    )
    return f'<table class="pairs"><tbody>{rows}</tbody></table>'


def key_figure_table(rows: Sequence[KeyFigure], models: Sequence[str]) -> str:
    """Return best, median and worst of every quantity for each model."""
    has_both = set(models) == {"refined", "simplified"}
    top = "".join(f'<th colspan="3" scope="colgroup">{escape(m)} model</th>' for m in models)
    ratio_head = '<th rowspan="2" scope="col">refined /<br>simplified</th>' if has_both else ""
    names = '<th scope="col">best</th><th scope="col">median</th><th scope="col">worst</th>'
    body = []
    for row in rows:
        load = f", load {row.load}" if row.load is not None else ""
        cells = "".join(_spread_cells(row.spreads[model]) for model in models)
        ratio = f"<td>{_ratio_text(row.ratio)}</td>" if has_both else ""
        body.append(
            f'<tr><th scope="row">{escape(row.quantity.label + load)}</th>'
            f'<td class="unit">{escape(row.unit)}</td>{cells}{ratio}</tr>'
        )
    return (
        '<table class="figures"><thead>'
        '<tr><th rowspan="2" scope="col">quantity</th>'
        f'<th rowspan="2" scope="col" class="words">unit</th>{top}'
        f"{ratio_head}</tr><tr>{names * len(models)}</tr></thead>"
        f"<tbody>{''.join(body)}</tbody></table>"
    )


def cards(dataset: xr.Dataset, rows: Sequence[KeyFigure]) -> str:
    """Return the headline: the weakest stiffness, the largest deflections, what drives explain."""
    model = models_of(dataset)[0]
    shown = [_stiffness_card(dataset, model), *_deflection_cards(dataset, model), _ratio_card(rows)]
    return "".join(card for card in shown if card)


def _stiffness_card(dataset: xr.Dataset, model: str) -> str:
    stiffnesses = [
        q for q in main_quantities(dataset, planar=False) if q.name == "stiffness_translation_min"
    ]
    for quantity in stiffnesses:
        return _worst_card(dataset, quantity, model, None, "Lowest stiffness")
    return ""


def _deflection_cards(dataset: xr.Dataset, model: str) -> list[str]:
    """Return a card for each main deflection, under the load that makes it largest."""
    made = []
    for quantity in main_quantities(dataset, planar=is_planar(dataset)):
        if not quantity.per_load:
            continue
        largest = {
            load: np.max(values[np.isfinite(values)], initial=0.0)
            for load in cases_of(dataset, quantity)
            for values in [values_of(dataset, quantity, model, load)]
        }
        load = max(largest, key=lambda name: largest[name], default=None)
        if load is not None and largest[load] > 0.0:
            made.append(_worst_card(dataset, quantity, model, load, f"Largest {_lower(quantity)}"))
    return made


def _worst_card(
    dataset: xr.Dataset, quantity: Quantity, model: str, load: str | None, title: str
) -> str:
    values = values_of(dataset, quantity, model, load)
    worst = worst_postures(values, worst_is_largest=quantity.worst_is_largest, count=1)
    if not worst:
        return ""
    unit = unit_of(dataset, quantity, load)
    value = format_value(float(f"{unit.of(values.flat[worst[0]]):.3g}"))
    where = f"at {_place(dataset, worst[0])}"
    details = where if load is None else f"load {load}, {where}"
    return card(title, value, unit.symbol, f"{model} model, {details}")


def _ratio_card(rows: Sequence[KeyFigure]) -> str:
    for row in rows:
        if row.quantity.per_load and np.isfinite(row.ratio) and row.ratio > 0.0:
            share = format_value(float(f"{100.0 / row.ratio:.2g}"))
            text = (
                f"{_lower(row.quantity)}, load {row.load}, median: the drives account for "
                f"{share} % of it, links and joints for the rest"
            )
            return card("Refined / simplified model", _ratio_text(row.ratio), "times", text)
    return ""


def card(title: str, value: str, unit: str, details: str) -> str:
    """Return one key figure: its title, value, unit and what belongs to it."""
    return (
        f'<div class="card"><h2>{escape(title)}</h2>'
        f'<p class="value">{escape(value)} <span>{escape(unit)}</span></p>'
        f"<p>{escape(details)}</p></div>"
    )


def _place(dataset: xr.Dataset, index: int) -> str:
    """Return the swept coordinates of a posture in words."""
    sweep = sweep_of(dataset)
    where = np.unravel_index(index, sweep.shape)
    return position_text(
        (axis, float(sweep.coordinates[axis][where[i] if sweep.is_grid else where[0]]))
        for i, axis in enumerate(sweep.axes)
    )


def _spread_cells(spread: Spread) -> str:
    if np.isinf(spread.worst):
        return '<td colspan="3" class="none">rigid</td>'
    if spread.is_trivial:
        text = "zero" if spread.worst == 0.0 else "no answer"
        return f'<td colspan="3" class="none">{text}</td>'
    return "".join(
        f"<td>{format_value(value)}</td>" for value in (spread.best, spread.median, spread.worst)
    )


def _ratio_text(ratio: float) -> str:
    return format_value(float(f"{ratio:.3g}")) if np.isfinite(ratio) else "–"


def _lower(quantity: Quantity) -> str:
    return quantity.label[0].lower() + quantity.label[1:]


def provenance(attrs: Mapping[str, object]) -> list[tuple[str, str]]:
    """Return what a reader needs in order to compute the same map again."""
    names = {
        "robot": "robot",
        "robot_hash": "SHA-256 of the robot file",
        "stiffkit_version": "stiffkit version",
        "created": "computed",
        "options": "options",
    }
    return [(name, str(attrs[key])) for key, name in names.items() if attrs.get(key)]
