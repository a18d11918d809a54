"""The deflections of all load cases with their noise, before they become a compliance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffkit.identify.estimators import Estimator, RigidFit, fit
from stiffkit.identify.field import Field
from stiffkit.identify.residuals import ResidualSums, residual_sums
from stiffkit.identify.statistics import Precision, noise, precision
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Estimate:
    """Deflections of m load cases and what is known of their noise."""

    deflections: Array
    """(m, 6), m and rad, at the reference point."""
    unit_covariance: Array
    """(m, 6, 6), covariance of each deflection for noise of sigma = 1 m."""
    rounding: Array
    """(m, 6, 6), covariance of each deflection by rounding alone."""
    squares_per_variance: Array
    """(m,), expected sum of w |r|^2 for sigma = 1 m: 3n - 6 for equal weights."""
    degrees_of_freedom: Array
    """(m,), of each sigma."""
    sigma: Array
    """(m,), m, standard deviation of the noise of a node's displacement along an axis."""
    largest: Array
    """(m,), m, largest component of a residual."""
    largest_node: tuple[int, ...]
    """m labels of the nodes where that is."""

    @property
    def pooled_sigma(self) -> float:
        """Sigma in m from the residuals of all load cases together."""
        freedom = self.squares_per_variance
        return float(np.sqrt(freedom @ self.sigma**2 / freedom.sum()))

    def covariances(self, sigma: Array | float) -> Array:
        """Return the covariances (m, 6, 6) of the deflections, with sigma (m,) or the same in m."""
        variance = np.broadcast_to(np.square(sigma), len(self.sigma))
        return np.asarray(variance[:, None, None] * self.unit_covariance + self.rounding)


def estimate(field: Field, reference: Array, estimator: Estimator) -> tuple[Estimate, RigidFit]:
    """Return the deflections of a field at ``reference`` (3,) in m, and the motions themselves."""
    fitted = fit(field, reference, estimator)
    return summarise(field, fitted, precision(field, reference)), fitted


def summarise(
    field: Field, fitted: RigidFit, known: Precision, sigma: Array | None = None
) -> Estimate:
    """Return the estimate of fitted motions; ``sigma`` (m,) in m follows from residuals if None."""
    sums: ResidualSums = residual_sums(field, fitted)
    angle = np.linalg.norm(fitted.rotation, axis=1)
    moved = np.linalg.norm(fitted.mean, axis=1) + angle * field.spread.radius
    m = field.case_count
    return Estimate(
        deflections=fitted.deflections,
        unit_covariance=np.repeat(known.unit_covariance[None], m, axis=0),
        rounding=np.square(moved)[:, None, None] * known.rounding,
        squares_per_variance=np.full(m, known.squares_per_variance),
        degrees_of_freedom=np.full(m, known.degrees_of_freedom),
        sigma=noise(sums.squares, known) if sigma is None else sigma,
        largest=sums.largest,
        largest_node=sums.largest_node,
    )


def join(parts: Sequence[Estimate]) -> Estimate:
    """Return one estimate of all load cases of several."""
    return Estimate(
        deflections=np.concatenate([part.deflections for part in parts]),
        unit_covariance=np.concatenate([part.unit_covariance for part in parts]),
        rounding=np.concatenate([part.rounding for part in parts]),
        squares_per_variance=np.concatenate([part.squares_per_variance for part in parts]),
        degrees_of_freedom=np.concatenate([part.degrees_of_freedom for part in parts]),
        sigma=np.concatenate([part.sigma for part in parts]),
        largest=np.concatenate([part.largest for part in parts]),
        largest_node=tuple(node for part in parts for node in part.largest_node),
    )
