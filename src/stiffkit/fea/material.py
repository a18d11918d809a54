"""Elastic laws of parts: isotropic (`stiffkit.link.Material`) and orthotropic."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from stiffkit.errors import LinkError
from stiffkit.link.materials import Material
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Orthotropic:
    """A material with three perpendicular planes of symmetry, such as a laminate or a print.

    ``nu12`` is the contraction along 2 under a stress along 1, so that nu12 / E1 = nu21 / E2.
    Raises `LinkError` if no such material can exist.
    """

    name: str
    E1: float
    """Pa, Young's modulus along the first axis."""
    E2: float
    """Pa."""
    E3: float
    """Pa."""
    nu12: float
    nu13: float
    nu23: float
    G12: float
    """Pa, shear modulus."""
    G13: float
    """Pa."""
    G23: float
    """Pa."""
    density: float
    """kg/m^3."""
    axes: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3), columns are the material's axes in the part's."""

    def __post_init__(self) -> None:
        """Check the values."""
        for key in ("E1", "E2", "E3", "G12", "G13", "G23", "density"):
            value = getattr(self, key)
            if not (value > 0.0 and math.isfinite(value)):
                raise LinkError(f"material {self.name}: {key} is {value:g} and must be positive")
        if np.linalg.eigvalsh(self._scaled_compliance())[0] <= 0.0:
            raise LinkError(
                f"material {self.name}: its Poisson's ratios let it give energy away",
                mend="nu12 < sqrt(E1/E2) and likewise for the others; nu12 is the contraction "
                "along 2 under a stress along 1, not the other way",
            )
        if not np.allclose(self.axes.T @ self.axes, np.eye(3), atol=1e-9):
            raise LinkError(
                f"material {self.name}: its axes are not perpendicular unit vectors",
                mend="give the columns of a rotation matrix",
            )

    def _compliance(self) -> Array:
        """Return the compliance (3, 3) of the normal strains, 1/Pa."""
        return np.array(
            [
                [1.0 / self.E1, -self.nu12 / self.E1, -self.nu13 / self.E1],
                [-self.nu12 / self.E1, 1.0 / self.E2, -self.nu23 / self.E2],
                [-self.nu13 / self.E1, -self.nu23 / self.E2, 1.0 / self.E3],
            ]
        )

    def _scaled_compliance(self) -> Array:
        root = np.sqrt([self.E1, self.E2, self.E3])
        return np.asarray(self._compliance() * np.outer(root, root))

    def stiffness(self) -> Array:
        """Return the stiffness (6, 6), Pa, in the part's axes.

        Stresses and engineering strains are ordered xx, yy, zz, yz, xz, xy.
        """
        C = np.zeros((6, 6))
        C[:3, :3] = np.linalg.inv(self._compliance())
        C[3, 3], C[4, 4], C[5, 5] = self.G23, self.G13, self.G12
        turn = strain_rotation(self.axes.T)
        return np.asarray(turn.T @ C @ turn)


Law = Material | Orthotropic
"""What a solid can be made of."""

_PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def strain_rotation(R: Array) -> Array:
    """Return the matrix (6, 6) that takes engineering strains to axes turned by R (3, 3).

    With x' = R x. T. C. T. Ting, Anisotropic Elasticity, 1996, section 2.3.
    """
    out = np.empty((6, 6))
    for column, (k, m) in enumerate(_PAIRS):
        strain = np.zeros((3, 3))
        strain[k, m] = strain[m, k] = 1.0 if k == m else 0.5
        turned = R @ strain @ R.T
        out[:, column] = [turned[i, j] * (1.0 if i == j else 2.0) for i, j in _PAIRS]
    return out
