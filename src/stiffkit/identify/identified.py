"""An identified compliance, and all that is known of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.identify.estimate import Estimate
from stiffkit.identify.estimators import Estimator
from stiffkit.identify.intervals import THREE_SIGMA, Multiplier
from stiffkit.identify.loads import Loads
from stiffkit.identify.outliers import Outliers
from stiffkit.identify.structure import CaseStructure
from stiffkit.identify.treatment import Treatment
from stiffkit.spatial.rotation import Array

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Options:
    """How to identify a compliance."""

    estimator: Estimator = "LIN"
    """LIN suits linear finite elements, `exact` measured and geometrically nonlinear fields."""
    level: float = THREE_SIGMA
    """Share of the intervals that are to hold the true value."""
    pooled: bool = True
    """One sigma from the residuals of all load cases, as in the paper; else one for each."""
    outliers: Treatment = "keep"
    """keep, drop (the paper's rule) or robust."""
    drop_percent: float = 10.0
    """Percentage of the nodes that `drop` takes away in every load case."""


@dataclass(frozen=True, eq=False)
class Identified:
    """A compliance at a reference point, in the axes of the field, and how well it is known.

    Elements of a 36 x 36 covariance are those of the 6 x 6 compliance row by row. SI units.
    """

    reference: Array
    """(3,), m."""
    options: Options
    case_names: tuple[str, ...]
    node_count: int
    compliance: Array
    """(6, 6), twist = compliance @ wrench, as estimated: not symmetric to rounding."""
    covariance: Array
    """(36, 36) of `compliance`."""
    standard_error: Array
    """(6, 6)."""
    multiplier: Multiplier
    """Standard errors to either side of an interval."""
    significant: Mask
    """(6, 6), elements whose interval does not hold zero."""
    cleaned: Array
    """(6, 6), `compliance` with zeros for elements that are not significant."""
    symmetrised: Array
    """(6, 6), mean of `compliance` and its transpose."""
    symmetrised_covariance: Array
    """(36, 36) of `symmetrised`."""
    symmetrised_significant: Mask
    """(6, 6), elements of `symmetrised` whose interval does not hold zero."""
    asymmetry: Array
    """(6, 6), (k_ij - k_ji) / sqrt(k_ii k_jj); nan where the diagonal is not positive."""
    faults: tuple[str, ...]
    """What keeps `symmetrised` from being the compliance of a body, in words."""
    estimate: Estimate
    """Deflections, sigma and largest residuals of each load case."""
    deflection_covariances: Array
    """(m, 6, 6)."""
    sigma: float
    """m, standard deviation of the noise, pooled over the load cases."""
    loads: Loads
    load_misfit: Array
    """(m,), rms over the six components, in standard errors, of what no compliance can explain
    of a deflection; 0 for six load cases."""
    structure: tuple[CaseStructure, ...]
    outliers: Outliers | None
    """None if all nodes were kept."""
    doubts: tuple[str, ...]
    """What looks like a wrong unit, in words."""
    notes: tuple[str, ...]
    """What to know before the numbers are used, in words."""

    @property
    def positive_definite(self) -> bool:
        """Whether `symmetrised` is positive definite and finite."""
        return not self.faults

    @property
    def structured(self) -> bool:
        """Whether residuals have a shape in some load case, so that intervals are nominal."""
        return any(case.structured for case in self.structure)

    @property
    def interval(self) -> tuple[Array, Array]:
        """Lower and upper bounds (6, 6) of the elements of `compliance`."""
        half = self.multiplier.value * self.standard_error
        return self.compliance - half, self.compliance + half

    @property
    def cleaned_symmetrised(self) -> Array:
        """(6, 6), `symmetrised` with zeros for its elements that are not significant."""
        return np.where(self.symmetrised_significant, self.symmetrised, 0.0)
