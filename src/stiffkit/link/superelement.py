"""Links reduced to their ports, with mass and internal modes (Craig-Bampton)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.link.line import Line
from stiffkit.link.ports import relative_to_base
from stiffkit.link.reduction import craig_bampton
from stiffkit.spatial.rotation import Array, skew


@dataclass(frozen=True, eq=False)
class Superelement:
    """A link with m ports: twists of the base and of each other port (6 each), and modes (n).

    Twists are in link axes, at the ports' origins. The modes are those with all ports held, of unit
    modal mass. Being in rest relative to the ports' motion they carry no static load, so the
    stiffness is that of the ports beside the modes' own, and only the mass couples them.
    """

    compliance: Array
    """(6(m-1), 6(m-1)), SI, of the ports but the base, in order, with the base held."""
    mode_stiffness: Array
    """(n,), squared angular frequencies of the modes, 1/s^2."""
    mass: Array
    """(6m + n, 6m + n): base, other ports, modes."""
    rule: str
    """How the link's mass and elasticity were distributed, in words."""
    stations: Array = field(default_factory=lambda: np.zeros(0))
    """(s,), m from the base towards the tip, where the motion inside a link with two ports is
    known; none if it is not."""
    shapes: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """(6 s, 12 + n): twists at the stations, link axes, for base, tip and modes."""

    @property
    def n_of_ports(self) -> int:
        """6m, how many coordinates are those of ports."""
        return len(self.mass) - self.mode_stiffness.size

    def stiffness(self, places: ArrayLike) -> Array:
        """Return the stiffness (6m + n, 6m + n) of base, other ports at ``places``, and modes.

        ``places`` (m-1, 3), m, may be (3,) where there is one.
        """
        relative = relative_to_base(places)
        own = relative.T @ np.linalg.solve(self.compliance, relative)
        p = self.n_of_ports
        K = np.zeros_like(self.mass)
        K[:p, :p] = (own + own.T) / 2.0
        K[p:, p:] = np.diag(self.mode_stiffness)
        return K

    def lowest(self, n_modes: int | None) -> Superelement:
        """Return the same with its lowest ``n_modes`` only, all if None."""
        n = self.mode_stiffness[:n_modes].size
        kept = self.n_of_ports + n
        return replace(
            self,
            mode_stiffness=self.mode_stiffness[:n],
            mass=self.mass[:kept, :kept],
            shapes=self.shapes[:, :kept],
        )


_GAUSS = np.polynomial.legendre.leggauss(5)
"""Points in (-1, 1) and weights: exact for the mass of elements with cubic shapes."""


@dataclass(frozen=True, eq=False)
class Struck:
    """Directions whose rows and columns are struck out of the springs at the ends of a lumped link.

    S. Briot, A. Pashkevich, D. Chablat, 2009, eq. 25: so the paper makes passive joints out of the
    springs beside them. What is struck out of a stiffness is held in the compliance: the joint
    turns freely, but the spring beside it is stiffer in the other directions than the link is.
    """

    at_base: Array
    """(6, n), unit directions (translation; rotation) in link axes."""
    at_tip: Array
    """(6, m)."""
    rule: str = "passive directions struck out of the springs beside joints (Briot 2009, eq. 25)"


def consistent_superelement(line: Line, n_elements: int, n_modes: int | None) -> Superelement:
    """Return the superelement of a line cut into ``n_elements`` consistent beam elements.

    The displacement inside an element is the exact static one, so that for a uniform beam these
    are the Timoshenko (or Euler-Bernoulli) elements of J. S. Przemieniecki, Theory of Matrix
    Structural Analysis, 1968. ``n_modes`` of the modes are kept, all if None.
    """
    h = line.length / n_elements
    size = 6 * (n_elements + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    stiffness, shapes = _element(line, h)
    for e in range(n_elements):
        at = slice(6 * e, 6 * e + 12)
        K[at, at] += stiffness
        for point, weight, shape in zip(*_GAUSS, shapes, strict=True):
            section = line.section_mass(h * (e + 0.5 * (1.0 + point)))
            M[at, at] += 0.5 * h * weight * shape.T @ section @ shape
    rule = f"{line.rule}, {n_elements} consistent elements"
    stations = np.asarray(h * np.arange(n_elements + 1), dtype=float)
    return _reduced(K, M, line, stations, n_modes, rule)


def _element(line: Line, h: float) -> tuple[Array, list[Array]]:
    """Return the stiffness (12, 12) of a piece of a line, and its shapes (6, 12) at `_GAUSS`.

    Shapes are twists at a point of the piece for unit twists of its two ends.
    """
    N, kappa = line.carry(), line.flexibility
    eye = np.eye(6)
    inverse = np.linalg.inv(line.compliance(h))
    relative = np.hstack([-(eye + h * N), eye])
    shapes = []
    for point in _GAUSS[0]:
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
        shapes.append(shape)
    return relative.T @ inverse @ relative, shapes


def lumped_superelement(
    line: Line, n_bodies: int, n_modes: int | None, struck: Struck | None = None
) -> Superelement:
    """Return the superelement of a line cut into rigid elements joined by full 6x6 springs.

    E. Wittbrodt, I. Adamiec-Wojcik, S. Wojciech, Dynamics of Flexible Multibody Systems, 2006, with
    the springs' coupling of Briot et al. 2009, section 3.2: the line is cut into ``n_bodies - 1``
    pieces, a spring with the compliance of the whole piece stands in the middle of each, and what
    lies between springs is rigid. The static compliance of the line is kept exactly, but for
    directions that are ``struck`` out of a spring.
    """
    pieces = n_bodies - 1
    h = line.length / pieces
    springs = np.asarray((np.arange(pieces) + 0.5) * h, dtype=float)
    cuts = np.array([0.0, *springs, line.length])
    N, eye = line.carry(), np.eye(6)
    # Element 0 is followed at the base, the last one at the tip, the others at their middles.
    reads = np.array([0.0, *(springs[:-1] + springs[1:]) / 2.0, line.length])
    middle = eye - h / 2 * N
    inverse = np.linalg.inv(middle @ line.compliance(h) @ middle.T)
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
    if struck is None:
        return _reduced(K, M, line, reads, n_modes, rule)
    ties = _ties(struck, springs, reads, N)
    return _reduced(K, M, line, reads, n_modes, f"{rule}, {struck.rule}", ties)


def _ties(struck: Struck, springs: Array, reads: Array, N: Array) -> Array:
    """Return rows (c, 6 n_bodies) that are zero where the struck directions do not yield."""
    rows = []
    for directions, i in ((struck.at_base, 0), (struck.at_tip, springs.size - 1)):
        relative = np.zeros((6, 6 * reads.size))
        relative[:, 6 * i : 6 * i + 6] = -(np.eye(6) + (springs[i] - reads[i]) * N)
        relative[:, 6 * i + 6 : 6 * i + 12] = np.eye(6) + (springs[i] - reads[i + 1]) * N
        rows.append(directions.T @ relative)
    return np.concatenate(rows)


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


def _reduced(
    K: Array,
    M: Array,
    line: Line,
    stations: Array,
    n_modes: int | None,
    rule: str,
    ties: Array | None = None,
) -> Superelement:
    """Return the superelement of a chain of bodies, the first at the base, the last at the tip."""
    ports = np.r_[0:6, K.shape[0] - 6 : K.shape[0]]
    reduced = craig_bampton(K, M, ports, n_modes, ties)
    # Without ties the line's own compliance is known free of rounding.
    compliance = (
        line.compliance(line.length)
        if ties is None
        else np.asarray(np.linalg.inv(reduced.stiffness[6:, 6:]))
    )
    return Superelement(
        compliance, reduced.mode_stiffness, reduced.mass, rule, stations, reduced.basis
    )


def massless_superelement(compliance: Array) -> Superelement:
    """Return the superelement of a link without mass, of its compliance (6(m-1), 6(m-1))."""
    size = 6 + len(compliance)
    return Superelement(compliance, np.zeros(0), np.zeros((size, size)), "massless spring")


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
