"""What to know of an identified compliance before its numbers are used."""

from __future__ import annotations

import numpy as np

from stiffkit.identify.identified import Identified
from stiffkit.identify.loads import POOR
from stiffkit.identify.outliers import trimmed_sigma_ratio
from stiffkit.identify.statistics import ROUNDING
from stiffkit.link.checks import LOADS

UNEQUAL = 2.0
"""Ratio of the load cases' sigmas from which pooling them misleads."""
TURNED = 1.0
"""Degrees of rotation from which it matters which estimator suits the field."""
ASYMMETRIC = 1e-3
"""Difference of mirror elements, relative to the diagonal, that is worth a word."""
MISFIT = 5.0
"""Standard errors by which deflections may miss a linear compliance."""


def notes(found: Identified) -> list[str]:
    """Return what is worth knowing of a result, most important first, in words."""
    return [
        *found.faults,
        *_structure_notes(found),
        *_misfit_notes(found),
        *_asymmetry_notes(found),
        *_rotation_notes(found),
        *_sigma_notes(found),
        *_outlier_notes(found),
        *_load_notes(found),
        f"intervals reach {found.multiplier.value:.4g} standard errors to either side "
        f"({found.multiplier.level:.6g} of the {found.multiplier.distribution} distribution): "
        f"{found.multiplier.reason}",
    ]


def _structure_notes(found: Identified) -> list[str]:
    shaped = [case for case in found.structure if case.structured]
    if not shaped:
        return []
    names = ", ".join(case.case_name for case in shaped)
    return [
        f"the intervals are nominal: in load case {names} the residuals are a shape and not noise",
        *(f"load case {case.case_name}: {case.words}" for case in shaped),
    ]


def _misfit_notes(found: Identified) -> list[str]:
    j = int(found.load_misfit.argmax())
    if found.load_misfit[j] <= MISFIT:
        return []
    return [
        f"the deflection of load case {found.case_names[j]} is {found.load_misfit[j]:.3g} standard "
        "errors away from what one compliance gives all load cases: a load may be wrong, or the "
        "body does not answer linearly"
    ]


def _asymmetry_notes(found: Identified) -> list[str]:
    size = np.abs(np.nan_to_num(found.asymmetry))
    i, j = np.unravel_index(size.argmax(), size.shape)
    if size[i, j] <= ASYMMETRIC:
        return []
    k = found.compliance
    return [
        f"the compliance is not symmetric: elements {i + 1},{j + 1} = {k[i, j]:.4g} and "
        f"{j + 1},{i + 1} = {k[j, i]:.4g} differ by {size[i, j]:.2g} of the diagonal; loads may "
        "not act at the reference point, or are not those of the load cases"
    ]


def _rotation_notes(found: Identified) -> list[str]:
    angles = np.degrees(np.linalg.norm(found.estimate.deflections[:, 3:], axis=1))
    j = int(angles.argmax())
    if angles[j] <= TURNED:
        return []
    share = np.radians(angles[j]) ** 2 / 6.0
    return [
        f"load case {found.case_names[j]} turns by {angles[j]:.3g} deg, where estimators differ by "
        f"about {share:.2g} of the rotation: LIN suits a linear finite-element program, exact "
        f"suits measured or geometrically nonlinear fields; here it is {found.options.estimator}"
    ]


def _sigma_notes(found: Identified) -> list[str]:
    sigma = found.estimate.sigma
    low, high = int(sigma.argmin()), int(sigma.argmax())
    rounding = ROUNDING * float(np.abs(found.estimate.deflections).max())
    if not found.options.pooled or sigma[high] <= max(UNEQUAL * sigma[low], rounding):
        return []
    return [
        f"sigma is pooled over load cases as unlike as {found.case_names[low]} "
        f"({sigma[low]:.3g} m) and {found.case_names[high]} ({sigma[high]:.3g} m): intervals from "
        "the former are too wide, from the latter too narrow; take one sigma for each load case"
    ]


def _outlier_notes(found: Identified) -> list[str]:
    report = found.outliers
    if report is None:
        return []
    counts = [len(nodes) for nodes in report.nodes]
    total = sum(counts)
    words = f"outliers ({report.method}): {max(counts)} of {found.node_count} nodes at most"
    if total:
        share = float(np.dot(report.rim_share, counts)) / total
        words += f"; {share:.0%} of them are among the tenth of nodes farthest from the centre"
    if report.method == "robust":
        return [words]
    ratio = trimmed_sigma_ratio(found.options.drop_percent)
    return [
        words,
        f"where the {found.options.drop_percent:g} % of nodes that were dropped are good ones, "
        f"sigma and the intervals come out too small, by a factor of down to {ratio:.2f}",
    ]


def _load_notes(found: Identified) -> list[str]:
    if found.loads.condition <= POOR:
        return []
    scaled = found.loads.wrenches * np.repeat([1.0, 1.0 / found.loads.length], 3)
    directions = scaled / np.linalg.norm(scaled, axis=1, keepdims=True)
    weakest = np.linalg.svd(directions.T)[0][:, -1]
    return [
        f"the loads are nearly dependent (condition {found.loads.condition:.3g}); the direction "
        f"that they show least is mostly {LOADS[int(np.abs(weakest).argmax())]}"
    ]
