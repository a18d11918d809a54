"""Residuals of every node before and after outliers were dealt with, to be looked at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.identify.estimators import RigidFit, fit
from stiffkit.identify.field import Field
from stiffkit.identify.identified import Identified
from stiffkit.identify.moments import skew_matrices
from stiffkit.identify.outliers import Outliers
from stiffkit.identify.residuals import residuals
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class ResidualFields:
    """Residuals of m load cases at n nodes."""

    before: Array
    """(m, n, 3), m: all nodes count."""
    after: Array
    """(m, n, 3), m: of the rigid motion that was found in the end, outliers included."""
    outlier: NDArray[np.bool_]
    """(m, n)."""


def residual_fields(field: Field, found: Identified) -> ResidualFields:
    """Return the residuals of the field that a compliance was identified from."""
    before = residuals(field, fit(field, found.reference, found.options.estimator))
    report = found.outliers
    if report is None:
        return ResidualFields(before, before, np.zeros(before.shape[:2], dtype=bool))
    outlier = np.stack([np.isin(field.nodes, nodes) for nodes in report.nodes])
    after = np.empty_like(before)
    for j in range(field.case_count):
        motion = (
            _motion(report, found.reference, j)
            if report.method == "robust"
            else fit(field.case(j, ~outlier[j]), found.reference, found.options.estimator)
        )
        after[j] = residuals(field.case(j), motion)[0]
    return ResidualFields(before, after, outlier)


def _motion(report: Outliers, reference: Array, j: int) -> RigidFit:
    """Return the linear motion of a robust fit from the deflection of one load case."""
    t, phi = report.after[j : j + 1, :3], report.after[j : j + 1, 3:]
    return RigidFit("LIN", reference, t, phi, reference, t, skew_matrices(phi))
