"""Every combination of values."""

from __future__ import annotations

from stiffkit.design.record import Record
from stiffkit.design.spec import Grid
from stiffkit.progress import Progress

_TOGETHER = 500
"""Designs of a step."""


def run_grid(method: Grid, record: Record, progress: Progress) -> None:
    """Evaluate all designs of a grid."""
    points = record.space.grid(method.steps)
    for start in range(0, points.shape[1], _TOGETHER):
        progress("grid", start / points.shape[1])
        record.at(points[:, start : start + _TOGETHER])
