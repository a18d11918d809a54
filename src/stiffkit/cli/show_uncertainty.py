"""Studies of uncertainty as text for a terminal."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from stiffkit.cli.show import heading

if TYPE_CHECKING:
    import xarray as xr

    from stiffkit.design.uncertainty.summary import PartRow, Summary

_MOST_PARTS = 8


def show_uncertainty(dataset: xr.Dataset) -> None:
    """Print each quantity with its band and causes, and which part to stiffen first."""
    from stiffkit.design.uncertainty.summary import part_rows, summaries

    found = summaries(dataset)
    per_cent = f"{100.0 * float(dataset.attrs['confidence']):g} %"
    for model in map(str, dataset["model"].values):
        own = [summary for summary in found if summary.model == model]
        heading(f"{dataset.attrs['title']}, {model} model")
        if not own:
            click.echo("  no posture of the workspace has an answer")
            continue
        _show_bands(own, per_cent)
        if any(one.coverage for one in own):
            _show_coverage(own, per_cent, int(dataset.attrs["samples"]))
    refused = int(dataset.attrs.get("samples_refused", 0))
    if refused:
        _note(f"robots that were drawn, cannot be built or assembled, and are left out: {refused}")
    if any(one.mean_half > abs(one.mean) for one in found):
        _note("bands reach below zero: the errors are too large for the first order")
    for summary in found:
        rows = part_rows(dataset, summary.name)
        if summary.model == "refined" and rows:
            _show_parts(summary, rows)


def _note(text: str) -> None:
    click.echo(click.style("note: ", fg="yellow", bold=True) + text)


def _show_bands(found: list[Summary], per_cent: str) -> None:
    name_width = max(len(one.name) for one in found) + 2
    click.echo(f"  {'':<{name_width}}{'mean':<26}{'worst':<26}most of the variance")
    for one in found:
        cause, share = next(iter(one.causes.items()))
        mean, worst = _band(one, one.mean, one.mean_half), _band(one, one.worst, one.worst_half)
        told = f"{100.0 * share:.0f} % {cause}" if share else "nothing scatters"
        click.echo(f"  {one.name:<{name_width}}{mean:<26}{worst:<26}{told}")
    click.echo(f"  bands of {per_cent} by the first order, over {found[0].postures} postures")


def _band(summary: Summary, value: float, half: float) -> str:
    """Return a value with half the width of its band, in a unit for reading."""
    from stiffkit.plots import display_unit, format_value
    from stiffkit.plots.quantities import kind_of

    unit = display_unit(kind_of(summary.quantity), [value])
    width = format_value(float(f"{half / unit.size:.2g}"))
    return f"{format_value(value / unit.size)} ± {width} {unit.symbol}"


def _show_coverage(found: list[Summary], per_cent: str, samples: int) -> None:
    click.echo(f"  of {samples} robots drawn at random, at a few postures, the bands hold")
    width = max(len(one.name) for one in found) + 2
    for one in found:
        if one.coverage is None:
            continue
        mean, low, high = (
            f"{100.0 * x:.1f}"
            for x in (one.coverage.mean, one.coverage.lowest, one.coverage.highest)
        )
        click.echo(f"  {one.name:<{width}}{mean} % ({low} to {high}), {per_cent} asked")


def _show_parts(summary: Summary, rows: list[PartRow]) -> None:
    heading(f"which part to stiffen first, for {summary.name}")
    shown = rows[:_MOST_PARTS]
    width = max(5, *(len(row.name) for row in shown)) + 2
    head = f"{'share':>8}{'at worst':>10}{'mass':>12}{'gain':>12}"
    click.echo(f"  {'':<{width}}{'':<7}{head}")
    for row in shown:
        mass = f"{row.mass:.3g} kg" if np.isfinite(row.mass) else "-"
        gain = f"{100.0 * row.gain_per_kg:.3g} %/kg" if np.isfinite(row.gain_per_kg) else "-"
        click.echo(
            f"  {row.name:<{width}}{row.kind:<7}{_per_cent(row.share):>6.1f} %"
            f"{_per_cent(row.share_at_worst):>8.1f} %{mass:>12}{gain:>12}"
        )
    if len(rows) > len(shown):
        rest = sum(row.share for row in rows[_MOST_PARTS:])
        click.echo(f"  the other {len(rows) - len(shown)} together {_per_cent(rest):.1f} %")


def _per_cent(share: float) -> float:
    """Return a share in per cent, to a tenth, without a sign where that is 0."""
    return round(100.0 * share, 1) + 0.0


def uncertainty_as_json(dataset: xr.Dataset) -> dict[str, Any]:
    """Return what `show_uncertainty` prints, and all parts, as plain data; SI."""
    from stiffkit.design.uncertainty.summary import asked_names, part_rows, summaries

    return {
        "title": str(dataset.attrs["title"]),
        "robot": str(dataset.attrs["robot"]),
        "confidence": float(dataset.attrs["confidence"]),
        "samples": int(dataset.attrs.get("samples", 0)),
        "samples_refused": int(dataset.attrs.get("samples_refused", 0)),
        "quantities": [_summary_as_json(one) for one in summaries(dataset)],
        "parts": {
            name: [_part_as_json(row) for row in part_rows(dataset, name)]
            for name in asked_names(dataset)
        },
        "options": json.loads(str(dataset.attrs["options"])),
    }


def _summary_as_json(one: Summary) -> dict[str, Any]:
    coverage = one.coverage
    return {
        "name": one.name,
        "quantity": one.quantity.name,
        "load": one.load,
        "units": one.quantity.units,
        "model": one.model,
        "postures": one.postures,
        "mean": {"value": one.mean, "half_width": one.mean_half},
        "worst": {"value": one.worst, "half_width": one.worst_half, "at": one.worst_at},
        "causes": one.causes,
        "coverage": None
        if coverage is None
        else {"mean": coverage.mean, "lowest": coverage.lowest, "highest": coverage.highest},
    }


def _part_as_json(row: PartRow) -> dict[str, Any]:
    has_mass = np.isfinite(row.mass)
    return {
        "name": row.name,
        "kind": row.kind,
        "share": row.share,
        "share_at_worst": row.share_at_worst,
        "mass": row.mass if has_mass else None,
        "gain_per_kg": row.gain_per_kg if has_mass else None,
    }
