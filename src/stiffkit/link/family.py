"""Links between links: one part with many values of its dimensions, known at some of them.

Links are solved at Chebyshev points of each dimension's range, and what is asked for in between
comes from polynomials through them (L. N. Trefethen, Approximation Theory and Approximation
Practice, SIAM 2013, chapters 4 and 5). The points of a finer set hold those of the coarser one, and
what the coarser set says at the new points is compared with what was solved there.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import LinkError
from stiffkit.link.file import LinkFile
from stiffkit.link.superelement import Superelement
from stiffkit.spatial import Frame, exp_rotation, log_rotation
from stiffkit.spatial.rotation import Array

Solve = Callable[[tuple[float, ...]], LinkFile]
"""Dimensions to a link."""

FEWEST, MOST = 3, 9
"""Points of each dimension: they are 3, 5 or 9."""

_SAME = 0.9
"""Overlap of two modes of different links above which they are the same."""

_BEYOND = 0.05
"""Of a range, how far beyond its ends polynomials are still asked: derivatives need neighbours."""


@dataclass(frozen=True)
class Range:
    """A dimension and where it lies."""

    name: str
    low: float
    high: float
    """SI."""

    def check(self, value: float) -> None:
        """Raise LinkError where a value lies out of the range, by more than neighbours do."""
        beyond = _BEYOND * (self.high - self.low)
        if not self.low - beyond <= value <= self.high + beyond:
            raise LinkError(
                f"{self.name} is {value:.6g} (SI), and the link is known from {self.low:.6g} to"
                f" {self.high:.6g}",
                mend="widen the range, or leave the value within it",
            )

    def points(self, n: int) -> tuple[float, ...]:
        """Return n Chebyshev points, both ends included, ascending; those of 3 are among 5."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        return tuple(middle - half * math.cos(math.pi * i / (n - 1)) for i in range(n))


@dataclass(frozen=True, eq=False)
class LinkFamily:
    """A link for any dimensions within ranges."""

    ranges: tuple[Range, ...]
    n: int
    """Points of each range."""
    links: tuple[LinkFile, ...]
    """At all combinations of points, the last range fastest."""
    error: float
    """Largest relative error of the compliance, over all loads, that polynomials through half of
    the points made at the others; with all of them it is smaller. Infinite where none was left
    out."""

    def at(self, dimensions: Sequence[float]) -> LinkFile:
        """Return the link of these dimensions, SI. Raises LinkError where one is out of range."""
        weights: Array = np.ones(1)
        for own, value in zip(self.ranges, dimensions, strict=True):
            own.check(value)
            own_weights = _lagrange(own.points(self.n), value)
            weights = np.asarray(np.outer(weights, own_weights).ravel(), dtype=float)
        return _mixed(self.links, weights)


def link_family(
    ranges: Sequence[Range], solve: Solve, tolerance: float, most: int = MOST
) -> LinkFamily:
    """Return the family of a part, with as many points as the ``tolerance`` of compliances needs.

    ``most`` points of each range are taken if need be; the family's ``error`` says what was
    reached. Raises what ``solve`` raises.
    """
    known: dict[tuple[float, ...], LinkFile] = {}

    def links(n: int) -> tuple[LinkFile, ...]:
        for place in itertools.product(*(one.points(n) for one in ranges)):
            key = _key(place)
            if key not in known:
                known[key] = solve(place)
        points = itertools.product(*(one.points(n) for one in ranges))
        return tuple(known[_key(place)] for place in points)

    family = LinkFamily(tuple(ranges), FEWEST, links(FEWEST), math.inf)
    while family.error > tolerance and 2 * family.n - 1 <= most:
        n = 2 * family.n - 1
        finer = links(n)
        places = itertools.product(*(one.points(n) for one in ranges))
        error = max(
            _difference(family.at(place), link) for place, link in zip(places, finer, strict=True)
        )
        family = LinkFamily(tuple(ranges), n, finer, error)
    return family


def _key(place: Sequence[float]) -> tuple[float, ...]:
    """Return what is the same for the same point of two sets, but for rounding."""
    return tuple(float(f"{value:.12e}") for value in place)


def _lagrange(points: Sequence[float], x: float) -> Array:
    """Return the weights (n,) of values at points in the polynomial through them, at x."""
    weights = [
        math.prod((x - b) / (a - b) for j, b in enumerate(points) if j != i)
        for i, a in enumerate(points)
    ]
    return np.array(weights)


def _difference(link: LinkFile, other: LinkFile) -> float:
    """Return the largest relative difference of two compliances over all loads."""
    root = np.linalg.cholesky(other.compliance)
    half = np.linalg.solve(root, link.compliance)
    ratios = np.linalg.eigvalsh(np.linalg.solve(root, half.T))
    return float(np.abs(ratios - 1.0).max())


def _mixed(links: Sequence[LinkFile], weights: Array) -> LinkFile:
    first = links[0]
    if any(list(link.ports) != list(first.ports) for link in links):
        raise LinkError("a part has not the same ports over the whole range of its dimensions")

    def mean(values: Sequence[Array | float | None]) -> Array:
        return np.asarray(np.tensordot(weights, np.array(values, dtype=float), axes=1))

    def optional(values: Sequence[Array | None]) -> Array | None:
        return None if any(value is None for value in values) else mean(values)

    masses = [link.mass for link in links]
    ports = {
        name: Frame(
            _turned([link.ports[name].rotation for link in links], weights),
            mean([link.ports[name].position for link in links]),
        )
        for name in first.ports
    }
    compliance = _definite([link.compliance for link in links], weights)
    elements = [link.superelement for link in links]
    known = [element for element in elements if element is not None]
    return replace(
        first,
        ports=ports,
        compliance=compliance,
        covariance=None,
        mass=None if any(mass is None for mass in masses) else float(mean(masses)),
        center_of_mass=optional([link.center_of_mass for link in links]),
        inertia=optional([link.inertia for link in links]),
        superelement=_element(known, weights, compliance) if len(known) == len(links) else None,
        provenance={},
        notes=(),
        content_hash="",
    )


def _turned(rotations: Sequence[Array], weights: Array) -> Array:
    """Return a rotation between rotations, by their rotation vectors from the first."""
    first = rotations[0]
    vectors = np.array([log_rotation(first.T @ R) for R in rotations])
    return np.asarray(first @ exp_rotation(weights @ vectors))


def _definite(matrices: Sequence[Array], weights: Array) -> Array:
    """Return a matrix between positive definite ones, by their logarithms: it is definite too.

    Entries are over the mean diagonal first, so that m/N and rad/(N m) can stand in one matrix.
    """
    scale = np.sqrt(np.mean([np.diag(S) for S in matrices], axis=0))
    total = np.zeros_like(matrices[0])
    for weight, S in zip(weights, matrices, strict=True):
        values, vectors = np.linalg.eigh(S / np.outer(scale, scale))
        total += weight * (vectors * np.log(values)) @ vectors.T
    values, vectors = np.linalg.eigh(total)
    return np.asarray((vectors * np.exp(values)) @ vectors.T * np.outer(scale, scale))


def _element(elements: Sequence[Superelement], weights: Array, compliance: Array) -> Superelement:
    """Return a superelement between others, with those modes that are the same in all of them.

    Where modes change places in the order of frequencies, the last one kept of one link may be
    missing of another.
    """
    middle = elements[len(elements) // 2]
    p, n = middle.n_of_ports, middle.mode_stiffness.size
    if any(element.mode_stiffness.size != n for element in elements):
        raise LinkError("a part has not as many modes over the whole range of its dimensions")
    found = [_same_modes(middle, element) for element in elements]
    kept = np.all([one.overlap >= _SAME for one in found], axis=0)
    mass, squares = np.zeros((p + n, p + n)), np.zeros(n)
    for weight, element, one in zip(weights, elements, found, strict=True):
        alike = np.eye(p + n)
        alike[p:, p:] = np.eye(n)[:, one.order] * one.signs
        mass += weight * alike.T @ element.mass @ alike
        squares += weight * element.mode_stiffness[one.order]
    rising = np.argsort(squares, kind="stable")
    rising = rising[kept[rising]]
    places = np.r_[np.arange(p), p + rising]
    rule = f"{middle.rule}, between {len(elements)} solutions"
    return Superelement(compliance, squares[rising], mass[np.ix_(places, places)], rule)


@dataclass(frozen=True, eq=False)
class _SameModes:
    """Which modes of an element are those of another one."""

    order: NDArray[np.intp]
    """(n,)."""
    signs: Array
    """(n,)."""
    overlap: Array
    """(n,), 1 where they are the same."""


def _same_modes(middle: Superelement, element: Superelement) -> _SameModes:
    from scipy.optimize import linear_sum_assignment  # slow to import

    p = middle.n_of_ports
    seen = []
    for one in (middle, element):
        # How modes pull at the ports, over what the ports' own masses do.
        pull = one.mass[:p, p:] / np.sqrt(np.diag(one.mass)[:p, None])
        seen.append(pull / np.linalg.norm(pull, axis=0))
    overlap = seen[0].T @ seen[1]
    _, order = linear_sum_assignment(-np.abs(overlap))
    own = overlap[np.arange(order.size), order]
    return _SameModes(order, np.where(own < 0.0, -1.0, 1.0), np.abs(own))


def described(family: LinkFamily, values: Mapping[str, float]) -> str:
    """Return in words what was done for a link of a family, at values by name, SI."""
    where = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
    known = "unknown" if math.isinf(family.error) else f"below {100.0 * family.error:.2g} %"
    return (
        f"between {len(family.links)} solutions of the part, at {where} (SI); the error that this"
        f" adds to theirs is {known}"
    )
