"""Geometries whose postures are known, from which those of all others are reached."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Anchors:
    """K geometries with their home postures and their P postures over the workspace.

    They belong to the study and not to its course: whichever geometries are computed first, each
    one begins at the same anchor.
    """

    values: Array
    """(k, K), of the varied parameters, SI."""
    home: Array
    """(n_home, K), unknowns at home."""
    home_response: Array
    """(n_home, K), see `ClosureEquations.newton_step`."""
    hints: Array
    """(n_joint_coordinates, K), rough joint coordinates that the file gives at home."""
    q: Array
    """(n, K, P), unknowns of the postures, NaN where one is not reached."""
    response: Array
    """(n, K, P)."""

    def arrays(self) -> dict[str, Array]:
        """Return everything by name, to be written."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def number(self) -> int:
        """K."""
        return int(self.values.shape[1])

    def with_one_more(self, other: Anchors) -> Anchors:
        """Return these and the other ones."""
        mine, theirs = self.arrays(), other.arrays()
        return Anchors(
            **{name: np.concatenate([mine[name], theirs[name]], axis=1) for name in mine}
        )

    def nearest(self, values: Array, span: Array, count: int) -> NDArray[np.intp]:
        """Return the nearest anchors (count, n), or all, of geometries with values (k, n).

        ``span`` (k,) makes distances along different parameters comparable.
        """
        apart = (values[:, :, None] - self.values[:, None, :]) / span[:, None, None]
        order = np.argsort(np.sum(apart**2, axis=0), axis=1, kind="stable")
        return np.asarray(order[:, :count].T)
