"""Writing the figures of a study of uncertainty into a folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stiffkit.design.uncertainty.summary import asked_names, part_rows
from stiffkit.plots import style
from stiffkit.plots.sweep import models_of, sweep_of
from stiffkit.plots.uncertainty_bars import ranking_figure, sources_figure
from stiffkit.plots.uncertainty_check import MOST, check_figure
from stiffkit.plots.uncertainty_maps import band_figure, uncertainty_map_figure

_SIDE_BY_SIDE = 3
"""Panels of one figure about sources."""


def write_uncertainty_figures(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """Write the figures of a study of uncertainty as SVG and as PNG (300 dpi).

    For each quantity ``map-NAME-MODEL`` over the workspace, where that is not a line, ``band-NAME``
    along lines through it, and ``ranking-NAME`` of the parts; ``sources-MODEL`` of the variance,
    and ``check-MODEL`` of the first order beside samples. What scatters nowhere is left out.

    Args:
        dataset: of `stiffkit.design.uncertainty.run_uncertainty`.
        directory: made if it is not there.

    Returns:
        The files, in this order.

    Raises:
        OutputError: if a file cannot be written.
    """
    style.make_folder(directory)
    figures = _figures(dataset)
    return [path for name, figure in figures for path in style.save(figure, directory / name)]


def _figures(dataset: xr.Dataset) -> Iterator[tuple[str, Figure]]:
    models = models_of(dataset)
    telling = {m: [n for n in asked_names(dataset) if _is_told(dataset, n, m)] for m in models}
    for name in asked_names(dataset):
        own = [model for model in models if name in telling[model]]
        if len(sweep_of(dataset).axes) > 1:
            for model in own:
                yield f"map-{name}-{model}", uncertainty_map_figure(dataset, name, model)
        if own:
            yield f"band-{name}", band_figure(dataset.sel(model=own), name)
    for model, names in telling.items():
        for number, some in enumerate(_parts(names, _SIDE_BY_SIDE)):
            yield _numbered(f"sources-{model}", number), sources_figure(dataset, some, model)
    for name in telling.get("refined", []):
        if part_rows(dataset, name):
            yield f"ranking-{name}", ranking_figure(dataset, name)
    for model, names in telling.items():
        sampled = [name for name in names if _is_sampled(dataset, name, model)]
        for number, some in enumerate(_parts(sampled, MOST)):
            yield _numbered(f"check-{model}", number), check_figure(dataset, some, model)


def _is_told(dataset: xr.Dataset, name: str, model: str) -> bool:
    sigma = dataset[f"{name}_sigma"].sel(model=model).values
    return bool((np.isfinite(sigma) & (sigma > 0.0)).any())


def _is_sampled(dataset: xr.Dataset, name: str, model: str) -> bool:
    key = f"{name}_sampled_coverage"
    return key in dataset and bool(np.isfinite(dataset[key].sel(model=model).values).any())


def _parts(names: list[str], size: int) -> list[list[str]]:
    return [names[start : start + size] for start in range(0, len(names), size)]


def _numbered(name: str, number: int) -> str:
    return f"{name}-{number + 1}" if number else name
