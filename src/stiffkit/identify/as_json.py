"""An identified link as plain values for other programs."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiffkit.identify.identified_link import IdentifiedLink, estimator_word
from stiffkit.spatial.rotation import Array


def as_json(link: IdentifiedLink) -> dict[str, Any]:
    """Return what was identified as plain values, SI, link axes; unknown numbers are None."""
    found = link.found
    return {
        "link": link.spec.title,
        "compliance": link.compliance.tolist(),
        "standard_error": link.standard_error.tolist(),
        "significant": link.significant.tolist(),
        "sigma": found.sigma,
        "confidence": found.options.level,
        "standard_errors_to_either_side": found.multiplier.value,
        "intervals_are_nominal": found.structured,
        "tip": found.reference.tolist(),
        "estimator": estimator_word(found),
        "nodes": link.chosen.words,
        "node_count": found.node_count,
        "weights": link.chosen.weights_words,
        "symmetrized": link.spec.symmetrize,
        "cleaned": link.spec.clean,
        "positive_definite": found.positive_definite,
        "as_estimated": {
            "compliance": found.compliance.tolist(),
            "standard_error": found.standard_error.tolist(),
            "significant": found.significant.tolist(),
            "asymmetry": _numbers(found.asymmetry),
        },
        "load_condition": found.loads.condition,
        "load_cases": [_case(link, j) for j in range(len(found.case_names))],
        "alternatives": [
            {
                "name": other.name,
                "how": other.words,
                "node_count": other.node_count,
                "compliance": other.compliance.tolist(),
                "sigma": other.sigma,
                "largest_difference": other.largest_difference,
            }
            for other in link.alternatives
        ],
        "doubts": list(link.doubts),
        "notes": list(link.notes),
        "provenance": dict(link.link.provenance),
    }


def _case(link: IdentifiedLink, j: int) -> dict[str, Any]:
    found, shape = link.found, link.found.structure[j]
    outliers = found.outliers
    return {
        "name": found.case_names[j],
        "load": link.wrenches[j].tolist(),
        "deflection": found.estimate.deflections[j].tolist(),
        "standard_error": np.sqrt(np.diag(found.deflection_covariances[j])).tolist(),
        "sigma": float(found.estimate.sigma[j]),
        "largest_residual": float(found.estimate.largest[j]),
        "largest_residual_node": found.estimate.largest_node[j],
        "structured": shape.structured,
        "residuals": shape.words,
        "outliers": [] if outliers is None else outliers.nodes[j].tolist(),
    }


def _numbers(matrix: Array) -> list[list[float | None]]:
    return [[float(x) if np.isfinite(x) else None for x in row] for row in matrix]
