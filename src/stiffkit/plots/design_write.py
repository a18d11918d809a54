"""The figures of a design study, by name and as files."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stiffkit.plots import style
from stiffkit.plots.design_curves import parameter_figure, progress_figure
from stiffkit.plots.design_maps import design_maps_figure, map_choices
from stiffkit.plots.design_parallel import parallel_figure
from stiffkit.plots.design_tradeoff import matrix_figure, tradeoff_figure
from stiffkit.plots.designs import Designs, designs_of
from stiffkit.plots.sweep import loads_of
from stiffkit.plots.write import file_names


def design_figures(
    dataset: xr.Dataset, maps: Mapping[str, xr.Dataset] | None = None
) -> list[tuple[str, Figure]]:
    """Return the figures of a design study, each with its name, the most telling first.

    Over one parameter, ``over-PARAMETER`` shows every result; over several, ``parallel`` shows the
    best designs, and ``tradeoff`` or, of more than two objectives, ``objectives`` what one costs
    in the others. Of one objective, ``progress`` shows how the search went. ``maps`` of some
    designs, by what these are called, such as "start" and "chosen", are compared in ``maps-...``.

    Raises:
        OutputError: if the dataset holds no designs.
    """
    designs = designs_of(dataset)
    drawn = []
    if len(designs.objectives) == 2:
        drawn.append(("tradeoff", tradeoff_figure))
    elif len(designs.objectives) > 2:
        drawn.append(("objectives", matrix_figure))
    if len(designs.parameters) == 1:
        drawn.append((f"over-{designs.parameters[0].name}", parameter_figure))
    elif any(np.any(feasible) for feasible in designs.feasible.values()):
        drawn.append(("parallel", parallel_figure))
    if len(designs.objectives) == 1 and _was_searched(designs):
        drawn.append(("progress", progress_figure))
    figures = [(name, draw(designs)) for name, draw in drawn]
    return figures + _of_maps(maps or {}, _asked(dataset))


def write_design_figures(
    dataset: xr.Dataset, directory: Path, maps: Mapping[str, xr.Dataset] | None = None
) -> list[Path]:
    """Write the figures of a design study as SVG and as PNG (300 dpi).

    Args:
        dataset: the designs.
        directory: made if it is not there.
        maps: of some designs, by what these are called.

    Returns:
        The files, in the order of `design_figures`.

    Raises:
        OutputError: if the dataset holds no designs, or a file cannot be written.
    """
    figures = design_figures(dataset, maps)
    style.make_folder(directory)
    return [path for name, figure in figures for path in style.save(figure, directory / name)]


def _of_maps(
    maps: Mapping[str, xr.Dataset], asked: Sequence[tuple[str, str | None]]
) -> list[tuple[str, Figure]]:
    if len(maps) < 2:
        return []
    loads = file_names(loads_of(next(iter(maps.values()))))
    return [
        (
            f"maps-{quantity.name}" + ("" if load is None else f"-{loads[load]}"),
            design_maps_figure(maps, quantity, load, model),
        )
        for quantity, load, model in map_choices(maps, asked)
    ]


def _asked(dataset: xr.Dataset) -> list[tuple[str, str | None]]:
    """Return quantity and load of each objective and constraint that is a quantity of postures."""
    options = json.loads(dataset.attrs.get("options") or "{}")
    goals = [*options.get("objectives", ()), *options.get("constraints", ())]
    columns = [goal["measure"]["column"] for goal in goals]
    return [(column["quantity"], column["load"]) for column in columns if column]


def _was_searched(designs: Designs) -> bool:
    """Tell whether designs were tried one after another, and not as a grid only."""
    return bool({*designs.origin} - {"start", "grid"})
