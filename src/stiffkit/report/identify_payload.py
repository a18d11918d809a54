"""The residuals of an identification as JSON for the page: micrometres, few enough to draw."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit.identify import Field, IdentifiedLink, ResidualFields, residual_fields

Array = NDArray[np.float64]

DRAWN = 8000
"""Nodes that a page shows, at most."""
BINS = 61
WIDEST = 8.0
"""Robust standard deviations that a histogram spans to either side, at most."""
COMPONENTS = ("all", "x", "y", "z")


def payload_of(link: IdentifiedLink) -> dict[str, Any]:
    """Return everything that the page's script draws from, ready for `json_text`.

    Values are base64 of little-endian float32: places in mm, residuals in micrometres.
    """
    field = link.chosen.field
    parts = residual_fields(field, link.found)
    drawn = drawn_nodes(field, parts)
    after = 1e6 * parts.after[:, drawn]
    return {
        "nodes": field.node_count,
        "drawn": len(drawn),
        "labels": [int(node) for node in field.nodes[drawn]],
        "points": [_packed(1e3 * column) for column in field.points[drawn].T],
        "tip": [float(f"{1e3 * x:.9g}") for x in link.found.reference],
        "treated": None if link.found.outliers is None else link.found.outliers.method,
        "cases": [
            {
                "name": name,
                "words": link.found.structure[j].words,
                "structured": link.found.structure[j].structured,
                "residuals": [_packed(column) for column in after[j].T],
                "outliers": np.flatnonzero(parts.outlier[j, drawn]).tolist(),
                "histograms": _histograms(parts, j, link.found.estimate.sigma[j]),
            }
            for j, name in enumerate(link.found.case_names)
        ],
    }


def drawn_nodes(field: Field, parts: ResidualFields) -> NDArray[np.int64]:
    """Return the places of the nodes to draw: all, or the largest residuals and a sample."""
    if field.node_count <= DRAWN:
        return np.arange(field.node_count)
    size = np.square(parts.after).sum(axis=2)
    share = DRAWN // (4 * field.case_count)
    largest = np.unique(np.argpartition(size, -share, axis=1)[:, -share:])
    others = np.setdiff1d(np.arange(field.node_count), largest)
    sample = np.random.default_rng(0).choice(others, DRAWN - len(largest), replace=False)
    return np.sort(np.concatenate([largest, sample]))


def _histograms(parts: ResidualFields, j: int, sigma: float) -> dict[str, Any]:
    """Return counts of residuals by component, before and after, on common bins."""
    kept = ~parts.outlier[j]
    before, after = 1e6 * parts.before[j], 1e6 * parts.after[j, kept]
    shown: dict[str, Any] = {}
    for c, name in enumerate(COMPONENTS):
        at = slice(None) if c == 0 else slice(c - 1, c)
        old, new = before[:, at].ravel(), after[:, at].ravel()
        reach = _reach(old)
        edges = np.linspace(-reach, reach, BINS + 1)
        shown[name] = {
            "reach": float(reach),
            "before": np.histogram(old, edges)[0].tolist(),
            "after": np.histogram(new, edges)[0].tolist(),
            "beyond": int((np.abs(old) > reach).sum()),
            "count": [int(old.size), int(new.size)],
            "sigma": [_rms(old), 1e6 * float(sigma) if c == 0 else _rms(new)],
        }
    return shown


def _reach(values: Array) -> float:
    """Return where the histogram of values ends to either side."""
    largest = float(np.abs(values).max())
    bulk = WIDEST * 1.4826 * float(np.median(np.abs(values)))
    return (min(largest, bulk) if bulk > 0.0 else largest) or 1e-12


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _packed(values: Array) -> str:
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")
