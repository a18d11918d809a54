"""A mesh as plain arrays, the form in which it passes between processes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stiffkit.fea.tets import Indices
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class MeshArrays:
    """Ten-node tetrahedra and six-node triangles."""

    points: Array = field(repr=False)
    """(n, 3), m."""
    tets: Indices = field(repr=False)
    """(e, 10), indices of points: corners, then middles of edges."""
    tet_solid: Indices = field(repr=False)
    """(e,), index of the part's solid, ascending."""
    triangles: Indices = field(repr=False)
    """(t, 6), indices of points."""
    triangle_face: Indices = field(repr=False)
    """(t,), index of the part's face."""

    def save(self, path: Path) -> None:
        """Write the arrays to a file."""
        np.savez(
            path,
            points=self.points,
            tets=self.tets,
            tet_solid=self.tet_solid,
            triangles=self.triangles,
            triangle_face=self.triangle_face,
        )


def load_arrays(path: Path) -> MeshArrays:
    """Read the arrays from a file."""
    with np.load(path, allow_pickle=False) as arrays:
        return MeshArrays(**{name: arrays[name] for name in MeshArrays.__dataclass_fields__})
