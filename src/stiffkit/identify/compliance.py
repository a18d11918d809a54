"""From the displacement fields of load cases to a compliance with its error bars."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.identify.estimators import reference_point
from stiffkit.identify.field import Field
from stiffkit.identify.identified import Identified, Mask, Options
from stiffkit.identify.intervals import Multiplier, multiplier
from stiffkit.identify.loads import Loads, check_loads
from stiffkit.identify.notes import notes
from stiffkit.identify.plausibility import doubts
from stiffkit.identify.statistics import (
    compliance_covariance,
    standard_errors,
    symmetric_covariance,
)
from stiffkit.identify.treatment import treat
from stiffkit.link.checks import check_compliance, symmetrize
from stiffkit.spatial.rotation import Array


def identify(
    field: Field, wrenches: ArrayLike, reference: ArrayLike, options: Options | None = None
) -> Identified:
    """Identify the compliance at ``reference`` (3,) in m from m >= 6 load cases.

    ``wrenches`` (m, 6) in N and N m act at the reference point, in the axes of the field; they may
    have any directions that are independent. Equation 2 of Pashkevich 2009, with its factors in
    the right order: k = [t; phi] [F; M]^+. Raises `FieldError` where the loads leave a direction
    out, and for options or a reference point that are none.
    """
    options = options or Options()
    point = reference_point(reference)
    loads = check_loads(wrenches, field.case_names)
    treated = treat(field, point, options.estimator, options.outliers, options.drop_percent)
    found = treated.estimate
    freedom = found.degrees_of_freedom
    if options.pooled:
        sigma: Array | float = found.pooled_sigma
        reach = multiplier(options.level, float(freedom.sum()))
    else:
        sigma, reach = found.sigma, multiplier(options.level, float(freedom.min()))
    covariances = found.covariances(sigma)
    k = found.deflections.T @ loads.inverse
    covariance = compliance_covariance(covariances, loads.inverse)
    significant = _significant(k, covariance, reach)
    symmetric, covariance_symmetric = symmetrize(k), symmetric_covariance(covariance)
    result = Identified(
        reference=point,
        options=options,
        case_names=field.case_names,
        node_count=field.node_count,
        compliance=k,
        covariance=covariance,
        standard_error=standard_errors(covariance),
        multiplier=reach,
        significant=significant,
        cleaned=np.where(significant, k, 0.0),
        symmetrised=symmetric,
        symmetrised_covariance=covariance_symmetric,
        symmetrised_significant=_significant(symmetric, covariance_symmetric, reach),
        asymmetry=_asymmetry(k),
        faults=tuple(check_compliance(symmetric)),
        estimate=found,
        deflection_covariances=covariances,
        sigma=found.pooled_sigma,
        loads=loads,
        load_misfit=_load_misfit(found.deflections, covariances, k, loads),
        structure=treated.structure,
        outliers=treated.outliers,
        doubts=tuple(doubts(k, found.deflections, field.case_names, significant)),
        notes=(),
    )
    return replace(result, notes=tuple(notes(result)))


def _significant(k: Array, covariance: Array, reach: Multiplier) -> Mask:
    return np.asarray(np.abs(k) > reach.value * standard_errors(covariance))


def _asymmetry(k: Array) -> Array:
    diagonal = np.where(np.diag(k) > 0.0, np.diag(k), np.nan)
    return np.asarray((k - k.T) / np.sqrt(np.outer(diagonal, diagonal)))


def _load_misfit(deflections: Array, covariances: Array, k: Array, loads: Loads) -> Array:
    if len(deflections) == 6:
        return np.zeros(6)
    error = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    left = deflections - loads.wrenches @ k.T
    return np.asarray(np.sqrt(np.mean(np.square(left / error), axis=1)))
