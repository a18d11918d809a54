"""The ways to deal with outliers: keep them, drop the worst, or fit robustly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import FieldError
from stiffkit.identify.estimate import Estimate, estimate, join, summarise
from stiffkit.identify.estimators import Estimator
from stiffkit.identify.field import Field
from stiffkit.identify.outliers import Outliers, kept_nodes, rim_share
from stiffkit.identify.robust import robust_fit
from stiffkit.identify.statistics import precision
from stiffkit.identify.structure import CaseStructure, residual_structure
from stiffkit.spatial.rotation import Array

Treatment = Literal["keep", "drop", "robust"]


@dataclass(frozen=True, eq=False)
class Treated:
    """Deflections after outliers were dealt with, the shape of what is left, and what was done."""

    estimate: Estimate
    structure: tuple[CaseStructure, ...]
    outliers: Outliers | None
    """None if all nodes were kept."""


def treat(
    field: Field, reference: Array, estimator: Estimator, treatment: Treatment, percent: float
) -> Treated:
    """Estimate the deflections of a field at ``reference`` (3,) in m, and deal with outliers.

    ``percent`` is what `drop` takes away of every load case. Raises `FieldError` for a treatment or
    percentage that is none, and for a robust fit by another estimator than LIN.
    """
    if treatment not in get_args(Treatment):
        raise FieldError(
            f"there is no treatment of outliers {treatment!r}",
            mend=f"take {', '.join(get_args(Treatment))}",
        )
    if treatment == "robust" and estimator != "LIN":
        raise FieldError(
            f"a robust fit is linear, and the estimator is {estimator}",
            mend="take the estimator LIN, or drop outliers",
        )
    if treatment == "robust":
        return _robust(field, reference)
    whole, fitted = estimate(field, reference, estimator)
    if treatment == "keep":
        return Treated(whole, residual_structure(field, fitted), None)
    kept = kept_nodes(field, fitted, percent)
    parts: list[Estimate] = []
    shapes: list[CaseStructure] = []
    for j in range(field.case_count):
        part = field.case(j, kept[j])
        after, refitted = estimate(part, reference, estimator)
        parts.append(after)
        shapes += residual_structure(part, refitted)
    return _treated("dropped", field, whole, join(parts), tuple(shapes), ~kept)


def _robust(field: Field, reference: Array) -> Treated:
    whole, _ = estimate(field, reference, "LIN")
    found = robust_fit(field, reference)
    after = summarise(field, found.fitted, precision(field, reference), found.sigma)
    shapes = residual_structure(field, found.fitted)
    return _treated("robust", field, whole, after, shapes, found.outliers)


def _treated(
    method: str,
    field: Field,
    before: Estimate,
    after: Estimate,
    shapes: tuple[CaseStructure, ...],
    out: NDArray[np.bool_],
) -> Treated:
    report = Outliers(
        method=method,
        nodes=tuple(field.nodes[mask] for mask in out),
        before=before.deflections,
        after=after.deflections,
        sigma_before=before.sigma,
        sigma_after=after.sigma,
        rim_share=np.array([rim_share(field, mask) for mask in out]),
    )
    return Treated(after, shapes, report)
