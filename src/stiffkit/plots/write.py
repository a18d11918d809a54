"""Writing the figures of a stiffness map into a folder."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stiffkit.plots import style
from stiffkit.plots.branches import branch_figure, has_branches
from stiffkit.plots.curves import curve_figure
from stiffkit.plots.maps import map_figure, model_comparison_figure
from stiffkit.plots.quantities import main_quantities
from stiffkit.plots.sweep import cases_of, is_planar, loads_of, models_of, sweep_of, values_of
from stiffkit.plots.thin import thinned
from stiffkit.study import Quantity


def write_figures(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """Write the figures that a paper on the robot would show, as SVG and as PNG (300 dpi).

    For each main quantity and load case: ``compare-...`` of both models side by side, or
    ``map-...`` where the dataset holds only one, and ``curves-...`` along lines through the
    workspace. Quantities that are zero or rigid throughout are left out. ``curves-frequency`` has
    the natural frequencies mode by mode, if the map holds them. Of very many postures some are
    drawn, see `stiffkit.plots.thin`.

    Args:
        dataset: a stiffness map.
        directory: made if it is not there.

    Returns:
        The files, in the order of their names' subjects; the same names for the same map.

    Raises:
        OutputError: if a file cannot be written.
    """
    style.make_folder(directory)
    written: list[Path] = []
    for stem, draw in _figures(thinned(dataset)):
        written += style.save(draw(), directory / stem)
    return written


def _figures(dataset: xr.Dataset) -> list[tuple[str, Callable[[], Figure]]]:
    models = models_of(dataset)
    has_surface = len(sweep_of(dataset).axes) > 1
    slugs = file_names(loads_of(dataset))
    figures: list[tuple[str, Callable[[], Figure]]] = []
    for quantity in main_quantities(dataset, planar=is_planar(dataset)):
        for load in cases_of(dataset, quantity):
            telling = [m for m in models if _tells_something(dataset, quantity, m, load)]
            name = quantity.name if load is None else f"{quantity.name}-{slugs[load]}"
            if has_surface and len(models) == 1:
                figures += [
                    (
                        f"map-{name}-{model}",
                        partial(map_figure, dataset, quantity.name, model, load),
                    )
                    for model in telling
                ]
            if len(models) == 2 and telling:
                figures.append(
                    (
                        f"compare-{name}",
                        partial(model_comparison_figure, dataset, quantity.name, load),
                    )
                )
            if telling and (has_surface or len(models) == 1):
                figures.append(
                    (f"curves-{name}", partial(curve_figure, dataset, quantity.name, load))
                )
    if has_branches(dataset):
        figures.append(("curves-frequency", partial(branch_figure, dataset)))
    return figures


def _tells_something(dataset: xr.Dataset, quantity: Quantity, model: str, load: str | None) -> bool:
    values = values_of(dataset, quantity, model, load)
    return bool((np.isfinite(values) & (values != 0.0)).any())


def file_names(names: tuple[str, ...]) -> dict[str, str]:
    """Return a file name part for each load, no two alike even where case does not count."""
    slugs: dict[str, str] = {}
    for name in names:
        slug = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_") or "load"
        taken = {other.lower() for other in slugs.values()}
        number = 2
        unique = slug
        while unique.lower() in taken:
            unique = f"{slug}-{number}"
            number += 1
        slugs[name] = unique
    return slugs
