"""Derivatives of a table's columns by the varied parameters, geometry by geometry."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import StiffkitError
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.engine import Engine, GeometryStatus, Rows
from stiffkit.study.sweep.gradients import Gradients
from stiffkit.study.sweep.spec import slope_name

Array = NDArray[np.float64]


def add_derivatives(rows: Rows, engine: Engine, values: Array) -> None:
    """Add to rows the derivatives of their columns, of geometries with values (k, G).

    They are NaN where there is no answer, or none beside the geometry.
    """
    spec, gradients = engine.spec, Gradients(engine)
    n = values.shape[1]
    columns = [column for column in spec.columns if column.has_slope]
    found = np.full((len(columns), len(spec.varied), len(spec.models), n), np.nan)
    for g in np.flatnonzero(rows["geometry_status"] == GeometryStatus.OK):
        # Where there is no geometry beside this one they stay NaN.
        postures = None
        with suppress(StiffkitError):
            postures = gradients.postures(values[:, g])
        if postures is None:
            continue
        for m, model in enumerate(spec.models):
            own = [
                i
                for i, column in enumerate(columns)
                if model == "refined" or QUANTITIES[column.quantity].source != "frequencies"
            ]
            with suppress(StiffkitError):
                slopes = gradients.of(postures, [columns[i] for i in own], model).slopes
                found[own, :, m, g] = slopes
    for i, column in enumerate(columns):
        for j, varied in enumerate(spec.varied):
            rows[slope_name(column, varied.name)] = found[i, j]
