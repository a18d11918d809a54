"""An identified compliance as one page that needs nothing but a browser."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from stiffkit import __version__
from stiffkit.identify import IdentifiedLink, asymmetry_of, estimator_word, outlier_words
from stiffkit.report.identify_payload import payload_of
from stiffkit.report.identify_tables import alternatives_table, cases_table, compliance_table
from stiffkit.report.payload import json_text
from stiffkit.report.tables import bullet_list, card, pair_table
from stiffkit.report.template import Script, fill, page, write_text

LEAST_ASYMMETRY = 1e-5
"""Shares below this are told as such."""

_SCRIPTS = ("numbers.js", "look.js", "identify.js")


def write_identify_page(link: IdentifiedLink, path: Path) -> None:
    """Write what was identified as one self-contained interactive page.

    The page makes no request to any other place. Raises OutputError if it cannot be written.
    """
    write_text(_page(link), path, "report")


def _page(link: IdentifiedLink) -> str:
    found = link.found
    level = f"{100.0 * found.options.level:.6g} %"
    main = fill(
        "identify.html",
        cards=_cards(link),
        doubts=_doubts(link.doubts),
        compliance_mm=compliance_table(link, millimetres=True),
        compliance_si=compliance_table(link, millimetres=False),
        level=escape(level),
        kept=_kept_words(link),
        cases=cases_table(link),
        alternatives=alternatives_table(link),
        notes=bullet_list(link.notes, otherwise="None."),
        choices=pair_table(_choices(link)),
    )
    return page(
        "identified compliance",
        title=link.spec.title,
        scope=f"Compliance of the tip with the base held, from {link.chosen.words}.",
        version=__version__,
        styles=("identify.css",),
        main=main,
        made=_provenance(link),
        script=Script(
            "The residuals on this page are",
            json_text(payload_of(link)),
            _SCRIPTS,
            uses_plotly=True,
        ),
    )


def _cards(link: IdentifiedLink) -> str:
    found = link.found
    shown = np.abs(link.compliance[link.significant])
    worst = float((link.standard_error[link.significant] / shown).max()) if shown.size else np.nan
    shaped = [case.case_name for case in found.structure if case.structured]
    trust = "a shape" if shaped else "like noise"
    where = "all load cases" if len(shaped) == len(found.structure) else ", ".join(shaped)
    trusted = (
        f"in {where}: there the intervals are nominal"
        if shaped
        else "so the confidence intervals can be taken at their word"
    )
    return "".join(
        [
            card(
                "Noise sigma",
                f"{1e6 * link.sigma:.3g}",
                "µm",
                "standard deviation of a node's displacement along an axis",
            ),
            card(
                "Significant elements",
                f"{int(link.significant.sum())}",
                "of 36",
                f"whose {100.0 * found.options.level:.6g} % interval does not hold zero",
            ),
            card(
                "Largest standard error",
                f"{100.0 * worst:.2g}" if np.isfinite(worst) else "–",
                "%",
                "of a significant element, relative to it",
            ),
            card("Residuals", trust, "", trusted),
            card(
                "Asymmetry",
                _percent(asymmetry_of(found)),
                "%",
                "largest difference of mirror elements, relative to the diagonal"
                + (", before their mean was taken" if link.spec.symmetrize else ""),
            ),
        ]
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g}" if share >= LEAST_ASYMMETRY else f"< {100.0 * LEAST_ASYMMETRY:g}"


def _doubts(doubts: tuple[str, ...]) -> str:
    if not doubts:
        return ""
    return f'<section class="doubts"><h2>Check first</h2>{bullet_list(doubts)}</section>'


def _kept_words(link: IdentifiedLink) -> str:
    parts = []
    if link.spec.symmetrize:
        parts.append("The mean of the estimate and its transpose is shown.")
    if link.spec.clean:
        parts.append("Elements that are not significant have been set to zero.")
    return escape(" ".join(parts))


def _choices(link: IdentifiedLink) -> list[tuple[str, str]]:
    found, spec = link.found, link.spec
    tip = ", ".join(f"{1e3 * x:.6g}" for x in found.reference)
    sigma = "pooled over all load cases" if found.options.pooled else "one for each load case"
    return [
        ("Tip in link axes", f"({tip}) mm"),
        ("Nodes", link.chosen.words),
        ("Weights", link.chosen.weights_words),
        ("Estimator", estimator_word(found)),
        ("Outliers", outlier_words(found)),
        ("Sigma", sigma),
        ("Condition of the loads", f"{found.loads.condition:.3g}"),
        ("Symmetrised, cleaned", f"{_yes(spec.symmetrize)}, {_yes(spec.clean)}"),
        ("Positive definite", _yes(found.positive_definite)),
    ]


def _yes(truth: bool) -> str:
    return "yes" if truth else "no"


def _provenance(link: IdentifiedLink) -> list[tuple[str, str]]:
    given = link.link.provenance
    files = [given["specification"], *given["fields"], *given.get("sets", [])]
    return [
        ("made by", str(given["program"])),
        *((one["file"], f"SHA-256 {one['sha256']}") for one in files),
    ]
