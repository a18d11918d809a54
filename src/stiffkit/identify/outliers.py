"""Nodes that do not obey the rest: Pashkevich 2009, sections 3.4 and 4.5.

The paper's rule drops a percentage of nodes that somebody chooses, whether they are wrong or not.
The robust estimator (see `robust_fit`) needs no such choice: it trusts a node the less, the farther
its residual lies outside of what most residuals are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from stiffkit.errors import FieldError
from stiffkit.identify.estimators import RigidFit
from stiffkit.identify.field import Field
from stiffkit.identify.residuals import residual_pieces
from stiffkit.spatial.rotation import Array

TIE = 1e-9
"""Residuals that agree to this share are as large as each other."""
RIM = 0.9
"""Nodes farther out than this share of all nodes are on the rim."""


@dataclass(frozen=True, eq=False)
class Outliers:
    """What dealing with outliers did, before and after side by side."""

    method: str
    """dropped or robust."""
    nodes: tuple[NDArray[np.int64], ...]
    """Labels of the outliers of each of m load cases."""
    before: Array
    """(m, 6), deflections with all nodes."""
    after: Array
    """(m, 6), deflections without the outliers, or robust ones."""
    sigma_before: Array
    """(m,), m."""
    sigma_after: Array
    """(m,), m."""
    rim_share: Array
    """(m,), share of the outliers among the 10 % of nodes farthest from the field's centre."""


def kept_nodes(field: Field, fitted: RigidFit, percent: float) -> NDArray[np.bool_]:
    """Return which nodes (m, n) are kept when the worst ``percent`` of each case are dropped.

    The size of a node's residual is that of its largest component, so that a node goes if any of
    its three residuals is among the largest. Nodes whose residuals are equally large, as symmetric
    fields have them, stay or go together: never more than the percentage go. Raises `FieldError`
    for a percentage below 0 or of 50 and more.
    """
    if not 0.0 <= percent < 50.0:
        raise FieldError(
            f"{percent:g} % of the nodes cannot be dropped as outliers",
            mend="choose a percentage from 0 to below 50, such as 10",
        )
    size = np.empty((field.case_count, field.node_count))
    for at, piece in residual_pieces(field, fitted):
        size[:, at] = np.abs(piece).max(axis=2)
    place = field.node_count - 1 - int(percent / 100.0 * field.node_count)
    limit = np.partition(size, place, axis=1)[:, place, None]
    return np.asarray(size <= limit * (1.0 + TIE))


def rim_share(field: Field, outliers: NDArray[np.bool_]) -> float:
    """Return the share of the outliers (n,) among the tenth of nodes farthest from the centre."""
    distance = np.linalg.norm(field.points - field.spread.centre, axis=1)
    on_rim = distance >= np.quantile(distance, RIM) * (1.0 - TIE)
    return float(on_rim[outliers].mean()) if outliers.any() else 0.0


def trimmed_sigma_ratio(percent: float) -> float:
    """Return how much too small sigma comes out if the dropped nodes were good normal ones.

    A node stays if all of three normal residuals are below a limit c; the ratio is the standard
    deviation of a normal variable cut off at -c and c.
    """
    inside = (1.0 - percent / 100.0) ** (1.0 / 3.0)
    if inside >= 1.0:
        return 1.0
    c = float(ndtri((1.0 + inside) / 2.0))
    density = np.exp(-(c**2) / 2.0) / np.sqrt(2.0 * np.pi)
    return float(np.sqrt(1.0 - 2.0 * c * density / inside))
