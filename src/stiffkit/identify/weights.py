"""Each node's share of the area, or of the volume, that the selected nodes span.

The shares are consistent where that makes them all positive: the integral of the node's shape
function, so that the weighted mean of the displacement is the exact mean of the finite-element
field. On straight six-node triangles the corners get nothing and the mid-sides a third each.
Consistent corner shares of eight-node quadrilaterals and of quadratic solids but the 27-node
hexahedron and the 18-node wedge are negative, which no fit can use; there the measure is spread
in proportion to the integrals of the squared shape functions (E. Hinton, T. Rock,
O. Zienkiewicz, "A note on mass lumping", Earthquake Engineering and Structural Dynamics 4 (1976)
245-249), exact for fields that are linear in the element. Strongly curved faces can make single
consistent shares slightly negative: those become zero, the others of the element shrink alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import FieldError
from stiffkit.identify.elements import ELEMENTS, Array, Element, Integers
from stiffkit.identify.readers.content import FieldFile, places_of
from stiffkit.identify.selection import Selection

Cells = dict[str, Integers]

CHUNK = 65536
"""Elements worked on at once: what they need stays well below the size of the file."""


@dataclass(frozen=True, eq=False)
class NodeWeights:
    """What each selected node stands for.

    ``values`` (k,) in the order of the selection, not negative, add up to ``measure``: an area in
    m^2 or a volume in m^3. ``covered`` (k,) tells which nodes belong to a counted face or body;
    ``kinds`` counts these by their kind, ``dimension`` is 2 for areas and 3 for volumes.
    """

    values: Array
    measure: float
    covered: NDArray[np.bool_]
    kinds: Mapping[str, int]
    dimension: int

    @property
    def words(self) -> str:
        """How the weights were made, for a report."""
        what = "area" if self.dimension == 2 else "volume"
        measure = f"{1e3**self.dimension * self.measure:.6g} mm^{self.dimension}"
        parts = ", ".join(f"{count} {kind}" for kind, count in self.kinds.items())
        bare = int(np.count_nonzero(~self.covered))
        rest = f"; {bare} nodes outside of these weigh nothing" if bare else ""
        return f"share of the {what} {measure} of {parts}{rest}"


def area_weights(file: FieldFile, selection: Selection) -> NodeWeights:
    """Return the nodes' shares of the area of the faces whose nodes are all selected.

    These are surface elements, and those faces of solids that are not shared by two of them.
    Raises ``FieldError`` where there is none.
    """
    surfaces = _whole(_selected(file, selection, dimension=2))
    faces = _outer_faces(_solid_faces(_selected(file, selection, dimension=3)), surfaces)
    return _weights(file, selection, faces, "face")


def volume_weights(file: FieldFile, selection: Selection) -> NodeWeights:
    """Return the nodes' shares of the volume of the solids whose nodes are all selected.

    Raises ``FieldError`` where there is none.
    """
    solids = _whole(_selected(file, selection, dimension=3))
    return _weights(file, selection, solids, "solid element")


def shares(element: Element, corners: Array) -> Array:
    """Return the shares (m, k) of the nodes in the measure of elements at ``corners`` (m, k, 3).

    ``corners`` are all nodes of each element, in the order of its kind.
    """
    consistent, squared = np.zeros((2, *corners.shape[:2]))
    for N, dN, weight in zip(
        element.shape_functions, element.gradients, element.weights, strict=True
    ):
        density = weight * _density(dN @ corners)[:, None]
        consistent += density * N
        squared += density * N**2
    measure = consistent.sum(axis=1, keepdims=True)
    share = squared if _is_lumped(element) else np.maximum(consistent, 0.0)
    total = share.sum(axis=1, keepdims=True)
    return np.asarray(share * np.divide(measure, total, out=np.zeros_like(total), where=total > 0))


def _is_lumped(element: Element) -> bool:
    """Tell whether the consistent shares of the undistorted element are negative somewhere."""
    return bool((element.weights @ element.shape_functions).min() < -1e-12)


def _density(tangents: Array) -> Array:
    """Return the area or volume per natural one from the tangents (m, d, 3)."""
    if tangents.shape[1] == 3:
        return np.asarray(np.abs(np.linalg.det(tangents)))
    return np.asarray(np.linalg.norm(np.cross(tangents[:, 0], tangents[:, 1]), axis=1))


def _selected(file: FieldFile, selection: Selection, dimension: int) -> Cells:
    """Return elements with a selected node, as places in the selection; -1 for other nodes."""
    ids = file.ids[selection.rows]
    cells = {}
    for kind, nodes in file.facets.items():
        if kind in ELEMENTS and ELEMENTS[kind].dimension == dimension:
            near = nodes[np.isin(nodes, ids).any(axis=1)]
            cells[kind] = places_of(near, ids)
    return cells


def _whole(cells: Cells) -> Cells:
    """Return the elements whose nodes are all selected."""
    return {kind: nodes[(nodes >= 0).all(axis=1)] for kind, nodes in cells.items()}


def _solid_faces(solids: Cells) -> Cells:
    """Return the faces, shared or not, whose nodes are all selected."""
    faces: dict[str, list[Integers]] = {}
    for kind, nodes in solids.items():
        for face, corners in ELEMENTS[kind].faces:
            faces.setdefault(face, []).append(nodes[:, corners])
    return _whole({kind: np.concatenate(parts) for kind, parts in faces.items()})


def _outer_faces(of_solids: Cells, surfaces: Cells) -> Cells:
    """Return surface elements and the faces of one solid alone, each face once."""
    groups = [*of_solids.items(), *surfaces.items()]
    if not groups:
        return {}
    keys = np.concatenate([_corner_key(kind, nodes) for kind, nodes in groups])
    is_solid = np.arange(len(keys)) < sum(map(len, of_solids.values()))
    _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    same = same.ravel()
    solids = np.bincount(same[is_solid], minlength=len(first))
    elements = np.bincount(same[~is_solid], minlength=len(first))
    counted = np.zeros(len(keys), dtype=bool)
    counted[first[(solids == 1) | (elements > 0)]] = True

    outer: dict[str, list[Integers]] = {}
    ends = np.cumsum([len(nodes) for _, nodes in groups])
    for (kind, nodes), end in zip(groups, ends, strict=True):
        outer.setdefault(kind, []).append(nodes[counted[end - len(nodes) : end]])
    return {kind: np.concatenate(parts) for kind, parts in outer.items()}


def _corner_key(kind: str, nodes: Integers) -> Integers:
    """Return what faces (m, k) on the same corners share: (m, 4), -1 where a triangle has none."""
    key = np.full((len(nodes), 4), -1, dtype=np.int64)
    corners = ELEMENTS[kind].corners
    key[:, :corners] = np.sort(nodes[:, :corners], axis=1)
    return key


def _weights(file: FieldFile, selection: Selection, cells: Cells, what: str) -> NodeWeights:
    """Add up the shares over the elements, which hold places in the selection."""
    kinds = {kind: len(nodes) for kind, nodes in cells.items() if len(nodes)}
    if not kinds:
        raise FieldError(
            f"no {what} has all its nodes among the {len(selection.rows)} selected",
            mend="select all nodes of the face, read a file that holds the elements, "
            "or give all nodes equal weights",
        )
    points = file.points[selection.rows]
    values = np.zeros(len(points))
    covered = np.zeros(len(points), dtype=bool)
    for kind in kinds:
        for start in range(0, kinds[kind], CHUNK):
            nodes = cells[kind][start : start + CHUNK]
            share = shares(ELEMENTS[kind], points[nodes])
            values += np.bincount(nodes.ravel(), share.ravel(), minlength=len(points))
            covered[nodes] = True
    dimension = ELEMENTS[next(iter(kinds))].dimension
    return NodeWeights(values, float(values.sum()), covered, kinds, dimension)
