"""Tables of designs: start against chosen ones, and the front. All text is escaped here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape

import numpy as np

from stiffkit.plots.designs import START, Designs, Parameter, Result, change_text, design_name
from stiffkit.plots.units import DisplayUnit, format_value
from stiffkit.report.words import grouped

MOST_ROWS = 50
"""Designs of a front that its table lists."""


def comparison_table(designs: Designs) -> str:
    """Return the start and the chosen designs side by side, by every model."""
    chosen = _chosen_columns(designs)
    heads = "".join(
        f'<th scope="col">{escape(title)}</th><th scope="col">change</th>' for title, _ in chosen
    )
    body = [_group(f"{'Parameters' if len(designs.parameters) > 1 else 'Parameter'}", len(chosen))]
    body += [_parameter_row(one, chosen) for one in (*designs.parameters, *designs.derived)]
    body += [_option_row(name, words, chosen) for name, words in designs.options.items()]
    for model in designs.models:
        body.append(_group(f"Judged by the {model} model", len(chosen)))
        body += [_result_row(result, model, chosen) for result in designs.results]
    return (
        '<table class="figures designs"><thead><tr><th scope="col"></th>'
        f'<th scope="col" class="words">asked</th><th scope="col" class="words">unit</th>'
        f'<th scope="col">start</th>{heads}</tr></thead><tbody>{"".join(body)}</tbody></table>'
    )


def front_table(designs: Designs, model: str) -> str:
    """Return the front of a model, best in the first objective first, below the start."""
    members = [int(design) for design in designs.front_of(model)]
    columns: list[Parameter | Result] = [*designs.parameters, *designs.derived, *designs.results]
    heads = "".join(f'<th scope="col">{_head(column)}</th>' for column in columns)
    options = "".join(f'<th scope="col">{escape(name)}</th>' for name in designs.options)
    rows = "".join(
        _front_row(designs, model, design, columns)
        for design in (START, *(d for d in members[:MOST_ROWS] if d != START))
    )
    rest = len(members) - MOST_ROWS
    more = f'<p class="hint">{grouped(rest)} more are in the dataset.</p>' if rest > 0 else ""
    return (
        '<div class="scroll"><table class="figures designs"><thead><tr><th scope="col">design</th>'
        f'<th scope="col" class="words">found by</th>{options}{heads}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>{more}"
    )


def evaluations_table(evaluations: Mapping[str, Mapping[str, float]]) -> str:
    """Return geometries and seconds of each method."""
    if not evaluations:
        return "<p>Nothing is known about the search.</p>"
    rows = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td>{grouped(int(one["geometries"]))}</td>'
        f"<td>{float(one['seconds']):.1f}</td></tr>"
        for name, one in evaluations.items()
    )
    return (
        '<table class="designs"><thead><tr><th scope="col">method</th>'
        '<th scope="col">geometries evaluated</th><th scope="col">seconds</th></tr></thead>'
        f"<tbody>{rows}</tbody></table>"
    )


Columns = Sequence[tuple[str, int]]


def _chosen_columns(designs: Designs) -> Columns:
    """Return title and number of each chosen design; one that two models choose stands once."""
    by_design: dict[int, list[str]] = {}
    for model, design in designs.chosen.items():
        by_design.setdefault(design, []).append(model)
    if len(designs.models) == 1:
        return [("chosen", design) for design in by_design]
    return [
        (f"chosen by the {' and the '.join(models)} model", design)
        for design, models in by_design.items()
    ]


def _group(title: str, chosen: int) -> str:
    return f'<tr class="group"><th scope="rowgroup" colspan="{4 + 2 * chosen}">{title}</th></tr>'


def _parameter_row(parameter: Parameter, chosen: Columns) -> str:
    low, high = (_number(parameter.unit, end) for end in (parameter.low, parameter.high))
    is_free = parameter.kind != "derived"
    cells = [_cell(_number(parameter.unit, parameter.values[START]))]
    for _, design in chosen:
        value = parameter.values[design]
        note = parameter.end(design) if is_free else ""
        cells.append(_cell(_number(parameter.unit, value), note))
        cells.append(_cell(change_text(value, parameter.values[START])))
    asked = f"{low} to {high}" if is_free else "follows"
    return _row(parameter.name, parameter.long_name, asked, parameter.unit.symbol, cells)


def _option_row(name: str, words: Sequence[str], chosen: Columns) -> str:
    cells = [_cell(words[START] or "–")]
    for _, design in chosen:
        cells += [_cell(words[design]), _cell("")]
    return _row(name, "", "choice", "", cells)


def _result_row(result: Result, model: str, chosen: Columns) -> str:
    values = result.values[model]
    cells = [_result_cell(result, model, START)]
    for _, design in chosen:
        cells.append(_result_cell(result, model, design))
        cells.append(_cell(change_text(values[design], values[START])))
    asked = result.goal
    if result.role == "constraint":
        asked = f"{result.sense} {_number(result.unit, result.bounds[model])}"
    return _row(result.title, result.long_name, asked, result.unit.symbol, cells)


def _result_cell(result: Result, model: str, design: int) -> str:
    text = _number(result.unit, result.values[model][design])
    if result.role == "objective":
        return _cell(text)
    if result.is_broken(model, design):
        return _cell(text, "breaks its bound", "broken")
    return _cell(text, "at its bound" if result.is_active(model, design) else "")


def _front_row(
    designs: Designs, model: str, design: int, columns: Sequence[Parameter | Result]
) -> str:
    choosers = [name for name, chosen in designs.chosen.items() if chosen == design]
    name = escape(design_name(design) if design == START else str(design))
    if choosers:
        name += f"<small>chosen by {' and '.join(map(escape, choosers))}</small>"
    cells = "".join(_front_cells(model, design, columns))
    options = "".join(f"<td>{escape(words[design])}</td>" for words in designs.options.values())
    kind = ' class="chosen"' if choosers else ""
    origin = "" if design == START else escape(designs.origin[design])
    return (
        f'<tr{kind}><th scope="row">{name}</th><td class="words">{origin}</td>{options}{cells}</tr>'
    )


def _front_cells(model: str, design: int, columns: Sequence[Parameter | Result]) -> Iterator[str]:
    for column in columns:
        if isinstance(column, Parameter):
            yield _cell(_number(column.unit, column.values[design]))
        else:
            broken = column.role == "constraint" and column.is_broken(model, design)
            text = _number(column.unit, column.values[model][design])
            yield _cell(text, kind="broken" if broken else "")


def _row(name: str, long_name: str, asked: str, unit: str, cells: Sequence[str]) -> str:
    about = "" if long_name in ("", name, f"parameter {name}") else long_name
    small = f"<small>{escape(about)}</small>" if about else ""
    return (
        f'<tr><th scope="row">{escape(name)}{small}</th><td class="words">{escape(asked)}</td>'
        f'<td class="unit">{escape(unit)}</td>{"".join(cells)}</tr>'
    )


def _cell(text: str, note: str = "", kind: str = "") -> str:
    small = f"<small>{escape(note)}</small>" if note else ""
    marked = f' class="{kind}"' if kind else ""
    return f"<td{marked}>{escape(text)}{small}</td>"


def _head(column: Parameter | Result) -> str:
    name = column.title if isinstance(column, Result) else column.name
    unit = f"<br>{escape(column.unit.symbol)}" if column.unit.symbol else ""
    return f"{escape(name)}{unit}"


def _number(unit: DisplayUnit, value: float) -> str:
    # A billionth of a unit is how a zero looks after a few additions.
    return format_value(float(np.round(unit.of(value), 9)))
