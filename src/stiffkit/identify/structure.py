"""Whether residuals are noise or a shape.

Standard errors hold for independent noise. The residuals of a finite-element field are mostly not
that: they are the deformation of the loaded face itself, smooth in space. Then the intervals are
nominal, and this says what the shape looks like.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import ndtr

from stiffkit.identify.estimators import RigidFit
from stiffkit.identify.field import Field
from stiffkit.identify.polynomials import Regression, basis, regress
from stiffkit.identify.residuals import residuals_at
from stiffkit.identify.statistics import ROUNDING
from stiffkit.identify.structure_words import shape_words
from stiffkit.spatial.rotation import Array

ALPHA = 1e-3
"""Chance with which independent noise is called structured."""
SAMPLE = 4000
"""Nodes among which neighbours are sought, at most."""


@dataclass(frozen=True, eq=False)
class CaseStructure:
    """The shape of the residuals of one load case."""

    case_name: str
    structured: bool
    words: str
    """What the residuals look like."""
    rms: float
    """m, weighted root mean square of |r|."""
    linear_share: float
    """Share of the sum of squared residuals that a uniform strain explains."""
    quadratic_share: float
    """Share that quadratic polynomials of position explain beyond."""
    normal_share: float
    """Share of the quadratic part along the shortest principal axis, such as a face's normal."""
    p_value: float
    """Chance that noise looks like these polynomials (F-test); nan with too few nodes."""
    neighbour_correlation: float
    """Correlation between neighbours of what the polynomials leave; nan with too few nodes."""
    neighbour_p_value: float
    """Chance that noise has such a correlation."""
    strains: Array
    """(d,), principal values of the uniform strain, largest absolute value first."""
    directions: Array
    """(3, d), columns are their directions."""


def residual_structure(field: Field, fitted: RigidFit) -> tuple[CaseStructure, ...]:
    """Return the shape of the residuals of each load case, tested against independent noise.

    Uniform strain and its linear variation in space (quadratic displacements) are found by
    regression; smooth shapes of higher order by the correlation between neighbouring nodes.
    """
    found = regress(field, fitted)
    correlations, chances = _neighbour_correlation(field, fitted, found)
    return tuple(
        _case(field, fitted, found, j, float(correlations[j]), float(chances[j]))
        for j in range(field.case_count)
    )


def _case(
    field: Field, fitted: RigidFit, found: Regression, j: int, correlation: float, chance: float
) -> CaseStructure:
    total = float(found.squares[j].sum())
    linear, quadratic = (_share(part[j].sum(), total) for part in (found.linear, found.quadratic))
    normal = _share(found.quadratic[j, 2], float(found.quadratic[j].sum()))
    rms = float(np.sqrt(total / field.node_count))
    angle = float(np.linalg.norm(fitted.rotation[j]))
    moved = float(np.linalg.norm(fitted.mean[j])) + angle * field.spread.radius
    rounding = rms <= ROUNDING * moved
    p_value = float(found.p_value[j])
    smooth = chance < ALPHA
    structured = not rounding and (p_value < ALPHA or smooth)
    strains, directions = _principal_strains(field, found.slopes[j])
    if rounding:
        words = "nothing but rounding is left"
    elif not structured:
        words = "no shape is seen: the residuals look like independent noise"
    else:
        words = shape_words(
            linear, quadratic, normal, smooth, strains, directions, fitted.estimator, angle
        )
    return CaseStructure(
        case_name=field.case_names[j],
        structured=structured,
        words=words,
        rms=rms,
        linear_share=linear,
        quadratic_share=quadratic,
        normal_share=normal,
        p_value=p_value,
        neighbour_correlation=correlation,
        neighbour_p_value=chance,
        strains=strains,
        directions=directions,
    )


def _share(part: float, total: float) -> float:
    return min(float(part) / total, 1.0) if total > 0.0 else 0.0


def _principal_strains(field: Field, slopes: Array) -> tuple[Array, Array]:
    """Return the principal strains (d,) and directions (3, d) of slopes (d, 3) in m per extent."""
    d, spread = field.spread.dimension, field.spread
    gradient = slopes[:, :d] / spread.extents[:d, None]
    values, vectors = np.linalg.eigh((gradient + gradient.T) / 2.0)
    order = np.argsort(-np.abs(values))
    return values[order], spread.axes[:, :d] @ vectors[:, order]


def _neighbour_correlation(
    field: Field, fitted: RigidFit, found: Regression
) -> tuple[Array, Array]:
    """Return correlation (m,) of nearest neighbours beyond the polynomials, and its chance (m,)."""
    size = found.coefficients.shape[1]
    if field.node_count <= 2 * size:
        unknown = np.full(field.case_count, np.nan)
        return unknown, unknown
    chosen = np.arange(field.node_count)
    if field.node_count > SAMPLE:
        chosen = np.sort(np.random.default_rng(0).choice(field.node_count, SAMPLE, replace=False))
    points = field.points[chosen]
    nearest = cKDTree(points).query(points, k=2)[1][:, 1]
    pairs = np.unique(np.sort(np.column_stack([np.arange(len(points)), nearest])), axis=0)
    rest = residuals_at(field, fitted, chosen) @ field.spread.axes
    rest -= basis(field, points) @ found.coefficients
    products = (rest[:, pairs[:, 0]] * rest[:, pairs[:, 1]]).sum(axis=(1, 2))
    variances = np.square(rest).mean(axis=1)
    expected = np.maximum(variances.sum(axis=1) * len(pairs), np.finfo(float).tiny)
    # Independent components of unequal variance count as fewer.
    deviation = np.sqrt(np.square(variances).sum(axis=1) * len(pairs))
    score = products / np.maximum(deviation, np.finfo(float).tiny)
    return products / expected, np.asarray(ndtr(-score))
