"""Links reduced to their ports, with mass and internal modes (Craig-Bampton)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import eigh

from stiffkit.link.line import Line
from stiffkit.spatial.rotation import Array, skew

_MASSLESS = 1e-12
"""Modes whose squared period is below this share of the longest one have no mass but rounding."""


@dataclass(frozen=True, eq=False)
class Superelement:
    """A link with two ports: twists of base (6) and tip (6) in link axes, and modal coordinates.

    The modes are those with both ports held, of unit modal mass. Being in rest relative to the
    ports' motion they carry no static load, so the stiffness is that of the ports beside the modes'
    own, and only the mass couples them.
    """

    compliance: Array
    """(6, 6), SI, of the tip with the base held."""
    mode_stiffness: Array
    """(n,), squared angular frequencies of the modes, 1/s^2."""
    mass: Array
    """(12 + n, 12 + n): base, tip, modes."""
    rule: str
    """How the link's mass and elasticity were distributed, in words."""
    stations: Array = field(default_factory=lambda: np.zeros(0))
    """(s,), m from the base, where the motion inside the link is known; none if it is not."""
    shapes: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """(6 s, 12 + n): twists at the stations, link axes, for base, tip and modes."""

    def with_compliance(self, compliance: Array) -> Superelement:
        """Return the same masses and modes with another static compliance."""
        return replace(self, compliance=compliance)


def consistent_superelement(line: Line, n_elements: int, n_modes: int | None) -> Superelement:
    """Return the superelement of a line cut into ``n_elements`` consistent beam elements.

    The displacement inside an element is the exact static one, so that for a uniform beam these
    are the Timoshenko (or Euler-Bernoulli) elements of J. S. Przemieniecki, Theory of Matrix
    Structural Analysis, 1968. ``n_modes`` of the modes are kept, all if None.
    """
    h = line.length / n_elements
    size = 6 * (n_elements + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for e in range(n_elements):
        at = slice(6 * e, 6 * e + 12)
        stiffness, mass = _element(line, e * h, h)
        K[at, at] += stiffness
        M[at, at] += mass
    rule = f"{line.rule}, {n_elements} consistent elements"
    stations = np.asarray(h * np.arange(n_elements + 1), dtype=float)
    return _craig_bampton(K, M, line, stations, n_modes, rule)


def _element(line: Line, start: float, h: float) -> tuple[Array, Array]:
    """Return stiffness and mass (12, 12) of a piece of a line."""
    N, kappa = line.carry(), line.flexibility
    eye = np.eye(6)
    inverse = np.linalg.inv(_piece_compliance(line, h))
    relative = np.hstack([-(eye + h * N), eye])
    mass = np.zeros((12, 12))
    points, weights = np.polynomial.legendre.leggauss(5)
    for point, weight in zip(points, weights, strict=True):
        s = 0.5 * h * (1.0 + point)
        rest = h - s
        # The twist at s of the clamped piece under a unit wrench at its end.
        D = (
            s * kappa
            + s**2 / 2 * N @ kappa
            + (s**2 / 2 + rest * s) * kappa @ N.T
            + (s**3 / 3 + rest * s**2 / 2) * N @ kappa @ N.T
        )
        shape = D @ inverse @ relative
        shape[:, :6] += eye + s * N
        mass += 0.5 * h * weight * shape.T @ line.section_mass(start + s) @ shape
    return relative.T @ inverse @ relative, mass


def _piece_compliance(line: Line, h: float) -> Array:
    """Return the compliance (6, 6) of the end of a piece of a line with its start held."""
    N, kappa = line.carry(), line.flexibility
    return np.asarray(h * kappa + h**2 / 2 * (N @ kappa + kappa @ N.T) + h**3 / 3 * N @ kappa @ N.T)


def lumped_superelement(line: Line, n_bodies: int, n_modes: int | None) -> Superelement:
    """Return the superelement of a line cut into rigid elements joined by full 6x6 springs.

    E. Wittbrodt, I. Adamiec-Wojcik, S. Wojciech, Dynamics of Flexible Multibody Systems, 2006, with
    the springs' coupling of Briot et al. 2009, section 3.2: the line is cut into ``n_bodies - 1``
    pieces, a spring with the compliance of the whole piece stands in the middle of each, and what
    lies between springs is rigid. The static compliance of the line is kept exactly.
    """
    pieces = n_bodies - 1
    h = line.length / pieces
    springs = (np.arange(pieces) + 0.5) * h
    cuts = np.array([0.0, *springs, line.length])
    N, eye = line.carry(), np.eye(6)
    # Element 0 is followed at the base, the last one at the tip, the others at their middles.
    reads = np.array([0.0, *(springs[:-1] + springs[1:]) / 2.0, line.length])
    middle = eye - h / 2 * N
    inverse = np.linalg.inv(middle @ _piece_compliance(line, h) @ middle.T)
    size = 6 * n_bodies
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for i, s in enumerate(springs):
        near, far = slice(6 * i, 6 * i + 6), slice(6 * i + 6, 6 * i + 12)
        relative = np.zeros((6, size))
        relative[:, near] = -(eye + (s - reads[i]) * N)
        relative[:, far] = eye + (s - reads[i + 1]) * N
        K += relative.T @ inverse @ relative
    for i in range(n_bodies):
        own = slice(6 * i, 6 * i + 6)
        M[own, own] = _rigid_piece_mass(line, cuts[i], cuts[i + 1], reads[i])
    rule = f"{line.rule}, {n_bodies} rigid elements joined by springs"
    return _craig_bampton(K, M, line, reads, n_modes, rule)


def _rigid_piece_mass(line: Line, start: float, end: float, read: float) -> Array:
    """Return the mass matrix (6, 6) of a rigid piece of a line, for its twist at ``read``."""
    N, eye = line.carry(), np.eye(6)
    mass = np.zeros((6, 6))
    points, weights = np.polynomial.legendre.leggauss(3)
    for point, weight in zip(points, weights, strict=True):
        s = start + 0.5 * (end - start) * (1.0 + point)
        shape = eye + (s - read) * N
        mass += 0.5 * (end - start) * weight * shape.T @ line.section_mass(s) @ shape
    return mass


def _craig_bampton(
    K: Array, M: Array, line: Line, stations: Array, n_modes: int | None, rule: str
) -> Superelement:
    """Reduce a chain (first six unknowns base, last six tip) to its ports and fixed-port modes.

    R. R. Craig, M. C. C. Bampton, "Coupling of substructures for dynamic analyses", AIAA J. 6(7),
    1968.
    """
    ports = np.r_[0:6, K.shape[0] - 6 : K.shape[0]]
    inner = np.arange(6, K.shape[0] - 6)
    follow = -np.linalg.solve(K[np.ix_(inner, inner)], K[np.ix_(inner, ports)])
    values, modes = _lowest_modes(K[np.ix_(inner, inner)], M[np.ix_(inner, inner)], n_modes)
    basis = np.zeros((K.shape[0], 12 + values.size))
    basis[ports, :12] = np.eye(12)
    basis[inner, :12] = follow
    basis[inner, 12:] = modes
    compliance = _piece_compliance(line, line.length)
    return Superelement(compliance, values, basis.T @ M @ basis, rule, stations, basis)


def _lowest_modes(K: Array, M: Array, n: int | None) -> tuple[Array, Array]:
    """Return squared angular frequencies (n,) and modes (m, n) of unit modal mass, lowest first.

    M may be singular, as that of a line without moment of inertia about itself: what has no mass
    has no mode.
    """
    # The stiffness is the definite one of the two; the eigenvalues are 1/omega^2.
    inverses, modes = eigh(M, K)
    massive = inverses > _MASSLESS * inverses.max(initial=0.0)
    inverses, modes = inverses[massive][::-1][:n], modes[:, massive][:, ::-1][:, :n]
    return 1.0 / inverses, modes / np.sqrt(inverses)


def massless_superelement(compliance: Array) -> Superelement:
    """Return the superelement of a link without mass."""
    return Superelement(compliance, np.zeros(0), np.zeros((12, 12)), "massless spring")


def rigid_mass(mass: float, center_of_mass: Array, inertia: Array | None) -> Array:
    """Return the mass matrix (6, 6) of a rigid body for the twist at its link's origin.

    ``inertia`` (3, 3) is about the centre of mass; none is that of a point mass.
    """
    C = skew(center_of_mass)
    M = np.zeros((6, 6))
    M[:3, :3] = mass * np.eye(3)
    M[:3, 3:] = -mass * C
    M[3:, :3] = mass * C
    M[3:, 3:] = -mass * C @ C + (0.0 if inertia is None else inertia)
    return M
