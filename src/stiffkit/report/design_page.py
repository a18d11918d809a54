"""A design study as one page that needs nothing but a browser."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path

import xarray as xr

from stiffkit.plots.design_write import write_design_figures
from stiffkit.plots.designs import START, Designs, change_text, design_name, designs_of
from stiffkit.report.design_page_tables import comparison_table, evaluations_table, front_table
from stiffkit.report.design_page_words import (
    asked_in_words,
    broken_bounds,
    comparison_in_words,
    excess_text,
    outcome_in_words,
    tried_in_words,
    varied_in_words,
)
from stiffkit.report.pictures import figure, is_drawing
from stiffkit.report.tables import bullet_list, card, provenance
from stiffkit.report.template import fill, page, write_text
from stiffkit.report.words import grouped

REPORT = "report.html"
FIGURES = "figures"

_CAPTIONS = {
    "tradeoff": "Trade-off",
    "objectives": "Trade-offs",
    "over": "Results over the parameter",
    "parallel": "The best designs",
    "progress": "The search",
    "maps": "Over the workspace",
}
_HINTS = {
    "tradeoff": "Each dot is a design; no design of a front can be made better in one objective "
    "without losing in the other. Hollow marks are the other model's front, as this model judges "
    "it. Designs far from the fronts lie beyond the axes.",
    "objectives": "Each dot is a design. Along a row and a column the axes are the same on one "
    "side of the diagonal. Designs far from the fronts lie beyond the axes.",
    "over": "Filled marks stand on the curve of the model that chose the design, hollow ones on "
    "that of the other model.",
    "parallel": "Each line is a design, coloured by the first objective. The axis of a parameter "
    "spans its range.",
    "progress": "The best design that keeps all bounds, after each one that was tried.",
    "maps": "The same colours in both.",
}


def write_design_report(
    dataset: xr.Dataset, directory: Path, maps: Mapping[str, xr.Dataset] | None = None
) -> Path:
    """Write the figures of a design study, and its report as one self-contained page.

    Args:
        dataset: the designs.
        directory: a folder that exists; ``report.html`` and the folder ``figures`` are made in it.
        maps: stiffness maps of some designs, by what these are called, such as "start" and
            "chosen"; the page shows them side by side.

    Returns:
        The page.

    Raises:
        OutputError: if the dataset holds no designs, or a file cannot be written.
    """
    designs = designs_of(dataset)
    figures = write_design_figures(dataset, directory / FIGURES, maps)
    path = directory / REPORT
    write_text(_page(dataset, designs, figures), path, "report")
    return path


def _page(dataset: xr.Dataset, designs: Designs, figures: Sequence[Path]) -> str:
    attrs = dataset.attrs
    version = str(attrs.get("stiffkit_version", ""))
    main = fill(
        "design.html",
        cards="".join(_cards(designs)),
        message=_message(str(attrs.get("message") or "")),
        varied=bullet_list(varied_in_words(designs)),
        asked=bullet_list(asked_in_words(designs)),
        outcome="".join(_outcome(designs)),
        comparison=_comparison(designs),
        table=comparison_table(designs),
        figures="".join(_sections(figures)),
        fronts="".join(_fronts(designs)),
        evaluations=evaluations_table(json.loads(attrs.get("evaluations") or "{}")),
    )
    return page(
        "design study",
        title=designs.title or str(attrs.get("robot") or "Designs"),
        scope=_scope(attrs, designs),
        version=version,
        styles=("design.css",),
        main=main,
        made=_provenance(attrs),
    )


def _scope(attrs: Mapping[str, object], designs: Designs) -> str:
    robot = Path(str(attrs.get("robot") or "")).stem
    return f"{f'Robot {robot}: ' if robot else ''}{tried_in_words(designs)}"


def _cards(designs: Designs) -> Iterator[str]:
    if not designs.chosen:
        yield card("Designs that keep all bounds", "none", "", f"of {grouped(designs.count)} tried")
        return
    model = next(iter(designs.chosen))
    design = designs.chosen[model]
    for result in designs.objectives[:3]:
        values = result.values[model]
        yield card(
            result.title[:1].upper() + result.title[1:],
            change_text(values[design], values[START]),
            "",
            f"{result.long_name}: {result.unit.text(values[START])} at the start, "
            f"{result.unit.text(values[design])} in {design_name(design)}, {model} model",
        )
    if len(designs.chosen) > 1:
        yield _comparison_card(designs)


def _comparison_card(designs: Designs) -> str:
    """Return what choosing by the second model costs, judged by the first."""
    (judge, own), (other, foreign) = list(designs.chosen.items())[:2]
    title = f"Choosing by the {other} model"
    broken = broken_bounds(designs, judge, foreign)
    if own == foreign:
        return card(title, "same", "", "both models choose the same design")
    if broken:
        return card(title, "not feasible", "", f"judged by the {judge} model: {', '.join(broken)}")
    first = designs.objectives[0]
    cost = excess_text(first, first.values[judge][foreign], first.values[judge][own])
    details = f"in {first.title}, judged by the {judge} model, than choosing by that one"
    return card(title, cost, "", details)


def _message(message: str) -> str:
    lines = [line for line in message.splitlines() if line.strip()]
    if not lines:
        return ""
    return f'<section class="doubts"><h2>What clashes</h2>{bullet_list(lines)}</section>\n'


def _outcome(designs: Designs) -> Iterator[str]:
    for model in designs.models:
        head = f"<h3>{escape(model[:1].upper() + model[1:])} model</h3>"
        yield f"<div>{head}{bullet_list(outcome_in_words(designs, model))}</div>"


def _comparison(designs: Designs) -> str:
    sentences = comparison_in_words(designs)
    if not sentences:
        return ""
    judge, other = list(designs.chosen)[:2]
    head = f"The choice of the {escape(other)} model, judged by the {escape(judge)} one"
    return f'<section class="comparison"><h2>{head}</h2>{bullet_list(sentences)}</section>\n'


def _sections(figures: Sequence[Path]) -> Iterator[str]:
    """Yield a section for each kind of figure."""
    groups: dict[str, list[Path]] = {}
    for path in figures:
        if is_drawing(path):
            groups.setdefault(path.name.partition("-")[0].removesuffix(".svg"), []).append(path)
    for kind, paths in groups.items():
        first, *others = [figure(path) for path in paths]
        more = ""
        if others:
            more = f"<details><summary>More ({len(others)})</summary>{''.join(others)}</details>"
        yield (
            f"<section><h2>{escape(_CAPTIONS.get(kind, kind))}</h2>{first}"
            f'<p class="hint">{escape(_HINTS.get(kind, ""))}</p>{more}</section>\n'
        )


def _fronts(designs: Designs) -> Iterator[str]:
    for model in designs.models:
        count = int(designs.front[model].sum())
        if count:
            one = len(designs.objectives) == 1
            title = "Best design" if one else f"Front ({grouped(count)} designs)"
            yield (
                f"<section><h2>{title} by the {escape(model)} model</h2>"
                f"{front_table(designs, model)}</section>\n"
            )


def _provenance(attrs: Mapping[str, object]) -> list[tuple[str, str]]:
    kept = {name: value for name, value in attrs.items() if name != "options"}
    options = json.loads(str(attrs.get("options") or "{}"))
    pairs = provenance(kept)
    for key, name in (
        ("postures", "postures"),
        ("frequency_postures", "of these with frequencies"),
    ):
        if options.get(key):
            pairs.append((f"{name}, each design", str(options[key])))
    return pairs
