"""The tables on the page of an identified compliance. All text is escaped here."""

from __future__ import annotations

from html import escape

import numpy as np

from stiffkit.identify import IdentifiedLink, estimator_word
from stiffkit.link.checks import LOADS
from stiffkit.plots import format_value
from stiffkit.report.compliance import UNITS_MM, compliance_matrix, scale_of, with_power
from stiffkit.spatial.rotation import Array


def compliance_table(link: IdentifiedLink, *, millimetres: bool) -> str:
    """Return the 36 elements, each with its standard error, those that are noise in grey."""
    scale = scale_of(millimetres=millimetres)
    k, error = link.compliance * scale, link.standard_error * scale

    def cell(i: int, j: int) -> str:
        return (
            f'<td class="{"sure" if link.significant[i, j] else "noise"}" '
            f'title="{escape(_title(link, i, j))}">{with_power(k[i, j], 5)}'
            f"<small>± {with_power(error[i, j], 2)}</small></td>"
        )

    return compliance_matrix(cell, millimetres=millimetres)


def cases_table(link: IdentifiedLink) -> str:
    """Return what is known of each load case."""
    found = link.found
    heads = (
        "load case",
        "load",
        "translation, µm",
        "rotation, µrad",
        "sigma, µm",
        "largest residual, µm",
        "outliers",
        "residuals",
    )
    rows = []
    for j, name in enumerate(found.case_names):
        d = 1e6 * found.estimate.deflections[j]
        largest = (
            f"{_short(1e6 * found.estimate.largest[j])} at node {found.estimate.largest_node[j]}"
        )
        outliers = "–" if found.outliers is None else str(len(found.outliers.nodes[j]))
        cells = (
            _short(float(np.linalg.norm(d[:3]))),
            _short(float(np.linalg.norm(d[3:]))),
            _short(1e6 * found.estimate.sigma[j]),
            largest,
            outliers,
        )
        words = found.structure[j].words
        rows.append(
            f'<tr><th scope="row">{escape(name)}</th>'
            f'<td class="load">{escape(_load_words(link.wrenches[j]))}</td>'
            + "".join(f"<td>{cell}</td>" for cell in cells)
            + f'<td class="words">{escape(words[0].upper() + words[1:])}.</td></tr>'
        )
    return _table("cases", heads, rows)


def alternatives_table(link: IdentifiedLink) -> str:
    """Return the significant elements as other ways find them, as differences from the main one."""
    main, others = link.found, link.alternatives
    scale = scale_of(millimetres=True)
    heads = ("", f"{estimator_word(main)} (taken)", *(other.name for other in others))
    rows = [
        _row("nodes", [str(main.node_count), *(str(other.node_count) for other in others)]),
        _row(
            "sigma, µm",
            [_short(1e6 * main.sigma), *(_short(1e6 * other.sigma) for other in others)],
        ),
    ]
    for i in range(6):
        for j in range(i, 6):
            if not main.symmetrised_significant[i, j]:
                continue
            value = main.symmetrised[i, j]
            shown = with_power(value * scale[i, j], 5)
            differences = [_relative(other.compliance[i, j], value) for other in others]
            unit = UNITS_MM[i // 3][j // 3]
            rows.append(_row(f"k{i + 1}{j + 1}, {unit}", [shown, *differences]))
    return _table("figures ways", heads, rows)


def _title(link: IdentifiedLink, i: int, j: int) -> str:
    half = link.found.multiplier.value * link.standard_error[i, j]
    k = link.compliance[i, j]
    sure = "significant" if link.significant[i, j] else "not told from zero"
    return f"k{i + 1}{j + 1} in SI: {k:.6g}, interval {k - half:.6g} to {k + half:.6g}, {sure}"


def _load_words(wrench: Array) -> str:
    units = ["N"] * 3 + ["N m"] * 3
    size = np.abs(wrench[:3]).max(initial=0.0), np.abs(wrench[3:]).max(initial=0.0)
    parts = [
        f"{LOADS[i]} = {wrench[i]:.4g} {units[i]}"
        for i in range(6)
        if abs(wrench[i]) > 1e-9 * size[i // 3]
    ]
    return ", ".join(parts)


def _relative(value: float, main: float) -> str:
    percent = f"{100.0 * (value - main) / main:+.4f}"
    return "same" if float(percent) == 0.0 else f"{percent} %".replace("-", "−")


def _row(name: str, cells: list[str]) -> str:
    return (
        f'<tr><th scope="row">{escape(name)}</th>'
        + "".join(f"<td>{cell}</td>" for cell in cells)
        + "</tr>"
    )


def _table(kind: str, heads: tuple[str, ...], rows: list[str]) -> str:
    head = "".join(f'<th scope="col">{escape(text)}</th>' for text in heads)
    return (
        f'<table class="{kind}"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _short(value: float) -> str:
    return escape(format_value(float(f"{value:.4g}")))
