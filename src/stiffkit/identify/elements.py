"""The shapes of finite elements: their faces, shape functions and quadrature.

Kinds and node orders are those of VTK, which meshio shares: corners first, then the mid-side nodes
edge by edge, then those of faces and of the body. See W. Schroeder, K. Martin, B. Lorensen, "The
Visualization Toolkit", 4th edition, 2006, chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Face = tuple[str, tuple[int, ...]]

ORDER = 3
"""Gauss points per direction: exact to the fifth degree, more than squares of quadratics need."""


@dataclass(frozen=True, eq=False)
class Element:
    """One kind of element, in natural coordinates.

    ``nodes`` (k, d) are the natural coordinates, ``powers`` (k, d) the exponents of the monomials
    that span its polynomials, ``points`` (q, d) and ``weights`` (q,) a quadrature rule, ``faces``
    the kind and the local nodes of each face of a solid.
    """

    corners: int
    nodes: Array
    powers: Integers
    points: Array
    weights: Array
    faces: tuple[Face, ...] = ()
    merge: Integers | None = None
    """For an element that is another one with nodes drawn together: the own node of each."""

    @property
    def dimension(self) -> int:
        """Two for surfaces, three for solids."""
        return int(self.points.shape[1])

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.nodes) if self.merge is None else int(self.merge.max()) + 1

    @cached_property
    def shape_functions(self) -> Array:
        """Values (q, k) at the quadrature points."""
        return self._merged(_monomials(self.points, self.powers) @ self._coefficients)

    @cached_property
    def gradients(self) -> Array:
        """Derivatives (q, d, k) of the shape functions by the natural coordinates."""
        return self._merged(_slopes(self.points, self.powers) @ self._coefficients)

    @cached_property
    def _coefficients(self) -> Array:
        """Coefficients (monomial, node): each function is one at its node, zero at the others."""
        return np.asarray(np.linalg.inv(_monomials(self.nodes, self.powers)))

    def _merged(self, values: Array) -> Array:
        """Add the functions of nodes that are drawn together."""
        if self.merge is None:
            return values
        own = self.merge[:, None] == np.arange(self.size)
        return np.asarray(values @ own.astype(float))


def _monomials(points: Array, powers: Integers) -> Array:
    """Return each monomial (columns) at each point (rows)."""
    return np.asarray(np.prod(points[:, None, :] ** powers, axis=2))


def _slopes(points: Array, powers: Integers) -> Array:
    """Return the derivative (q, d, monomial) of each monomial by each coordinate."""
    slopes = []
    for axis in range(points.shape[1]):
        lowered = powers.copy()
        lowered[:, axis] = np.maximum(powers[:, axis] - 1, 0)
        slopes.append(powers[:, axis] * _monomials(points, lowered))
    return np.stack(slopes, axis=1)


def _line_rule() -> tuple[Array, Array]:
    """Gauss-Legendre on [-1, 1]."""
    points, weights = np.polynomial.legendre.leggauss(ORDER)
    return points[:, None], weights


def _times(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the product of two rules, the coordinates of the first leading."""
    points = [np.concatenate(pair) for pair in product(a[0], b[0])]
    return np.array(points), np.asarray(np.outer(a[1], b[1]).ravel(), dtype=float)


def _simplex_rule(dimension: int) -> tuple[Array, Array]:
    """Conical product rule on the unit simplex (Stroud 1971, section 2.4)."""
    from scipy.special import roots_jacobi

    points, weights = np.zeros((1, 0)), np.ones(1)
    for degree in range(dimension):
        x, w = roots_jacobi(ORDER, degree, 0)
        s, scale = (1.0 + x) / 2.0, w / 2.0 ** (degree + 1)
        rows = [np.concatenate(([t], (1.0 - t) * p)) for t in s for p in points]
        points, weights = np.array(rows), np.outer(scale, weights).ravel()
    return points, weights


def _powers(size: int, degree: int, dimension: int) -> Sequence[tuple[int, ...]]:
    """Return the exponents up to ``size`` each and up to ``degree`` superlinear in all.

    The superlinear degree of Arnold and Awanou (2011) leaves linear factors out of the count; it
    tells the serendipity family from the full product.
    """
    exponents = product(range(size + 1), repeat=dimension)
    return [p for p in exponents if sum(e for e in p if e > 1) <= degree]


def _middles(corners: Array, edges: str) -> Array:
    """Append the middle of each edge, written as two corner digits."""
    pairs = np.array([[int(edge[0]), int(edge[1])] for edge in edges.split()])
    return np.vstack([corners, corners[pairs].mean(axis=1)])


def _faces(*faces: tuple[str, str]) -> tuple[Face, ...]:
    """Return faces from kinds and local nodes in words."""
    return tuple((kind, tuple(map(int, nodes.split()))) for kind, nodes in faces)


def _element(
    corners: int,
    nodes: Array,
    powers: Sequence[tuple[int, ...]],
    rule: tuple[Array, Array],
    *faces: tuple[str, str],
    merge: list[int] | None = None,
) -> Element:
    merged = None if merge is None else np.array(merge)
    points, weights = rule
    return Element(corners, nodes, np.array(powers), points, weights, _faces(*faces), merged)


TETRA_FACES = tuple(("triangle", nodes) for nodes in ("0 1 3", "1 2 3", "2 0 3", "0 2 1"))
TETRA10_FACES = tuple(
    ("triangle6", nodes) for nodes in ("0 1 3 4 8 7", "1 2 3 5 9 8", "2 0 3 6 7 9", "0 2 1 6 5 4")
)
HEXA_FACES = tuple(
    ("quad", nodes) for nodes in ("0 4 7 3", "1 2 6 5", "0 1 5 4", "3 7 6 2", "0 3 2 1", "4 5 6 7")
)
HEXA20_FACES = tuple(
    ("quad8", nodes)
    for nodes in (
        "0 4 7 3 16 15 19 11",
        "1 2 6 5 9 18 13 17",
        "0 1 5 4 8 17 12 16",
        "3 7 6 2 19 14 18 10",
        "0 3 2 1 11 10 9 8",
        "4 5 6 7 12 13 14 15",
    )
)
HEXA27_FACES = tuple(
    ("quad9", f"{nodes} {20 + face}") for face, (_, nodes) in enumerate(HEXA20_FACES)
)
WEDGE_FACES = (
    ("triangle", "0 1 2"),
    ("triangle", "3 5 4"),
    ("quad", "0 3 4 1"),
    ("quad", "1 4 5 2"),
    ("quad", "2 5 3 0"),
)
WEDGE15_FACES = (
    ("triangle6", "0 1 2 6 7 8"),
    ("triangle6", "3 5 4 11 10 9"),
    ("quad8", "0 3 4 1 12 9 13 6"),
    ("quad8", "1 4 5 2 13 10 14 7"),
    ("quad8", "2 5 3 0 14 11 12 8"),
)
WEDGE18_FACES = (
    *WEDGE15_FACES[:2],
    ("quad9", "0 3 4 1 12 9 13 6 15"),
    ("quad9", "1 4 5 2 13 10 14 7 16"),
    ("quad9", "2 5 3 0 14 11 12 8 17"),
)
PYRAMID_FACES = (
    ("quad", "0 3 2 1"),
    ("triangle", "0 1 4"),
    ("triangle", "1 2 4"),
    ("triangle", "2 3 4"),
    ("triangle", "3 0 4"),
)
PYRAMID13_FACES = (
    ("quad8", "0 3 2 1 8 7 6 5"),
    ("triangle6", "0 1 4 5 10 9"),
    ("triangle6", "1 2 4 6 11 10"),
    ("triangle6", "2 3 4 7 12 11"),
    ("triangle6", "3 0 4 8 9 12"),
)


def _catalogue() -> dict[str, Element]:
    """Return all kinds by name."""
    line, triangle, tetra = _line_rule(), _simplex_rule(2), _simplex_rule(3)
    square = _times(line, line)
    cube, prism = _times(square, line), _times(triangle, line)

    tri = np.array([[0, 0], [1, 0], [0, 1]], dtype=float)
    tri6 = _middles(tri, "01 12 20")
    quad = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
    quad8 = _middles(quad, "01 12 23 30")
    quad9 = np.vstack([quad8, [[0, 0]]])
    tet = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    tet10 = _middles(tet, "01 12 20 03 13 23")
    hexa = np.array([[*p, z] for z in (-1.0, 1.0) for p in quad])
    hexa20 = _middles(hexa, "01 12 23 30 45 56 67 74 04 15 26 37")
    sides = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1], [0, 0, 0]]
    hexa27 = np.vstack([hexa20, sides])
    wedge = np.array([[*p, z] for z in (-1.0, 1.0) for p in tri])
    wedge15 = _middles(wedge, "01 12 20 34 45 53 03 14 25")
    wedge18 = np.vstack([wedge15, [[0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0]]])

    linear = [(0, 0), (1, 0), (0, 1)]
    quadratic = [*linear, (2, 0), (1, 1), (0, 2)]
    solid_linear = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    squares = [(2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (0, 1, 1), (1, 0, 1)]
    prism6 = [(*p, z) for p in linear for z in (0, 1)]
    prism15 = [*((*p, z) for p in quadratic for z in (0, 1)), *((*p, 2) for p in linear)]
    prism18 = [(*p, z) for p in quadratic for z in (0, 1, 2)]

    kinds = {
        "triangle": _element(3, tri, linear, triangle),
        "triangle6": _element(3, tri6, quadratic, triangle),
        "quad": _element(4, quad, _powers(1, 1, 2), square),
        "quad8": _element(4, quad8, _powers(2, 2, 2), square),
        "quad9": _element(4, quad9, _powers(2, 4, 2), square),
        "tetra": _element(4, tet, solid_linear, tetra, *TETRA_FACES),
        "tetra10": _element(4, tet10, solid_linear + squares, tetra, *TETRA10_FACES),
        "hexahedron": _element(8, hexa, _powers(1, 1, 3), cube, *HEXA_FACES),
        "hexahedron20": _element(8, hexa20, _powers(2, 2, 3), cube, *HEXA20_FACES),
        "hexahedron27": _element(8, hexa27, _powers(2, 6, 3), cube, *HEXA27_FACES),
        "wedge": _element(6, wedge, prism6, prism, *WEDGE_FACES),
        "wedge15": _element(6, wedge15, prism15, prism, *WEDGE15_FACES),
        "wedge18": _element(6, wedge18, prism18, prism, *WEDGE18_FACES),
    }
    # A pyramid is the hexahedron whose upper face is drawn together to the apex.
    to_5 = [0, 1, 2, 3, 4, 4, 4, 4]
    to_13 = [*to_5, 5, 6, 7, 8, 4, 4, 4, 4, 9, 10, 11, 12]
    kinds["pyramid"] = _element(5, hexa, _powers(1, 1, 3), cube, *PYRAMID_FACES, merge=to_5)
    kinds["pyramid13"] = _element(5, hexa20, _powers(2, 2, 3), cube, *PYRAMID13_FACES, merge=to_13)
    return kinds


ELEMENTS: dict[str, Element] = _catalogue()
"""The known kinds by name."""
