"""Errors of links: how the elements of their compliances scatter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.uncertainty.spec import UncertainLink
from stiffkit.errors import LinkError
from stiffkit.robot import Link

Array = NDArray[np.float64]


def covariance_of(link: Link, uncertain: UncertainLink) -> Array:
    """Return the covariance (m, m) of the lower triangle of a link's compliance, SI.

    Raises LinkError where the link is rigid, has no covariance, or has one that does not fit.
    """
    if link.compliance is None:
        raise LinkError(
            f"the link '{link.name}' is rigid, so nothing in it can scatter",
            mend="leave it out, or give it a compliance in the robot file",
        )
    lower = link.compliance[np.tril_indices(len(link.compliance))]
    if uncertain.relative is not None:
        return np.asarray(uncertain.relative**2 * np.outer(lower, lower))
    if link.covariance is None:
        raise LinkError(
            f"the link '{link.name}' was not identified: it has no covariance",
            mend="write '{sigma: 2 %}', or take it from a link file that 'stiffkit identify' wrote",
        )
    covariance = _of_lower_triangle(link.covariance)
    if np.any((lower == 0.0) & (np.diag(covariance) > 0.0)):
        # An exact zero stands for symmetry, and is left out of the arithmetic.
        raise LinkError(
            f"elements of the compliance of the link '{link.name}' are exactly zero, and its"
            " covariance says that they scatter",
            mend="write them as they were identified",
        )
    return covariance


def _of_lower_triangle(covariance: Array) -> Array:
    """Return the covariance (21, 21) of a symmetrised 6x6 matrix, given that (36, 36) of all."""
    rows, columns = np.tril_indices(6)
    mean = np.zeros((rows.size, 36))
    place = np.arange(rows.size)
    np.add.at(mean, (place, 6 * rows + columns), 0.5)
    np.add.at(mean, (place, 6 * columns + rows), 0.5)
    return np.asarray(mean @ covariance @ mean.T)


def root_of(covariance: Array) -> Array:
    """Return B (m, r) with B B^T the covariance, without directions in which nothing scatters."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(scale > 0.0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(safe, safe))
    kept = values > 1e-12 * max(float(values[-1]), 1e-300)
    return np.asarray(scale[:, None] * vectors[:, kept] * np.sqrt(values[kept]))
