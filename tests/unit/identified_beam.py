"""Displacement fields at the tip of a cantilever along x, 1000 x 10 x 10 mm, of steel."""

from __future__ import annotations

import numpy as np

from stiffkit.spatial.rotation import Array

CASES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
TIP = np.array([1.0, 0.0, 0.0])
LOADS = np.diag([1000.0, 1.0, 1.0, 1.0, 1.0, 1.0])
POISSON = 0.266


def beam_compliance() -> Array:
    """Euler-Bernoulli, SI, at the tip (equation 22 of Pashkevich 2009 without its misprint)."""
    L, E, h = 1.0, 2e11, 0.01
    A, Iy, J, G = h**2, h**4 / 12, 0.1406 * h**4, E / (2 * (1 + POISSON))
    k = np.diag(
        [L / (E * A), L**3 / (3 * E * Iy), L**3 / (3 * E * Iy), L / (G * J), *[L / (E * Iy)] * 2]
    )
    k[1, 5] = k[5, 1] = L**2 / (2 * E * Iy)
    k[2, 4] = k[4, 2] = -(L**2) / (2 * E * Iy)
    return k


def face(count: int = 11, size: float = 0.01) -> Array:
    """A square grid (n, 3) on the end face."""
    step = np.linspace(-size / 2, size / 2, count)
    y, z = np.meshgrid(step, step, indexing="ij")
    return np.column_stack([np.full(y.size, 1.0), y.ravel(), z.ravel()])


def cube(count: int = 11, size: float = 0.01) -> Array:
    """A cubic grid (n, 3) about the tip."""
    step = np.linspace(-size / 2, size / 2, count)
    grid = np.stack(np.meshgrid(step, step, step, indexing="ij"), axis=-1)
    return np.asarray(TIP + grid.reshape(-1, 3))


def displaced(
    points: Array,
    compliance: Array,
    wrenches: Array,
    sigma: float = 0.0,
    seed: int = 0,
    reference: Array = TIP,
) -> Array:
    """Displacements (m, n, 3) of the linear rigid motions k w at the reference, with noise in m."""
    twists = wrenches @ compliance.T
    turned = np.cross(twists[:, None, 3:], (points - reference)[None])
    u = twists[:, None, :3] + turned
    return np.asarray(u + sigma * np.random.default_rng(seed).normal(size=u.shape))
