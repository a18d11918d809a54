"""Figures of stiffness maps for papers: one look, units for the reader, SVG and PNG."""

from __future__ import annotations

from stiffkit.plots.branches import (
    BranchLine,
    branch_figure,
    branch_lines,
    branch_model,
    has_branches,
)
from stiffkit.plots.curves import curve_figure
from stiffkit.plots.design_write import design_figures, write_design_figures
from stiffkit.plots.draw import position_text
from stiffkit.plots.maps import map_figure, model_comparison_figure
from stiffkit.plots.modes import mode_figure, write_mode_figures
from stiffkit.plots.parts import write_face_figure, write_link_figures
from stiffkit.plots.quantities import main_quantities, quantities_of, quantity_named
from stiffkit.plots.sweep import (
    OK,
    Columns,
    Sweep,
    axis_unit,
    cases_of,
    columns_of,
    is_planar,
    loads_of,
    middle_posture,
    models_of,
    ratio_of,
    status_of,
    sweep_of,
    unit_of,
    values_of,
)
from stiffkit.plots.uncertainty_write import write_uncertainty_figures
from stiffkit.plots.units import DisplayUnit, Kind, display_unit, format_value
from stiffkit.plots.write import write_figures
from stiffkit.study import QUANTITIES, Quantity

__all__ = [
    "OK",
    "QUANTITIES",
    "BranchLine",
    "Columns",
    "DisplayUnit",
    "Kind",
    "Quantity",
    "Sweep",
    "axis_unit",
    "branch_figure",
    "branch_lines",
    "branch_model",
    "cases_of",
    "columns_of",
    "curve_figure",
    "design_figures",
    "display_unit",
    "format_value",
    "has_branches",
    "is_planar",
    "loads_of",
    "main_quantities",
    "map_figure",
    "middle_posture",
    "mode_figure",
    "model_comparison_figure",
    "models_of",
    "position_text",
    "quantities_of",
    "quantity_named",
    "ratio_of",
    "status_of",
    "sweep_of",
    "unit_of",
    "values_of",
    "write_design_figures",
    "write_face_figure",
    "write_figures",
    "write_link_figures",
    "write_mode_figures",
    "write_uncertainty_figures",
]
