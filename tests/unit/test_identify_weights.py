"""Shares of nodes in areas and volumes."""

import numpy as np
import pytest
from tests.unit.field_files import Array, cube, field_file

from stiffkit.errors import FieldError
from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers import FieldFile
from stiffkit.identify.selection import Layer, Listed, select
from stiffkit.identify.weights import area_weights, shares, volume_weights

SOLIDS = ["hexahedron", "hexahedron20", "hexahedron27", "tetra", "tetra10"]
SOLIDS += ["wedge", "wedge15", "wedge18"]
TOP = Layer((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 0.0)


def solid(kind: str, cells: int = 2) -> FieldFile:
    points, nodes = cube(kind, cells)
    return field_file(points, {"none": np.zeros_like(points)}, {kind: nodes})


@pytest.mark.parametrize("kind", list(ELEMENTS))
def test_shape_functions_of_every_kind(kind: str) -> None:
    """They add up to one, and their gradients to nothing; faces have the nodes of their kind."""
    element = ELEMENTS[kind]
    np.testing.assert_allclose(element.shape_functions.sum(axis=1), 1.0, atol=1e-13)
    np.testing.assert_allclose(element.gradients.sum(axis=2), 0.0, atol=1e-13)
    for face, nodes in element.faces:
        assert len(set(nodes)) == len(nodes) == ELEMENTS[face].size


@pytest.mark.parametrize("kind", SOLIDS)
def test_the_top_of_a_cube(kind: str) -> None:
    file = solid(kind)
    weights = area_weights(file, select(file, TOP))
    assert weights.measure == pytest.approx(1.0)
    assert weights.values.min() >= 0.0
    assert weights.covered.all()
    points = file.points[select(file, TOP).rows]
    np.testing.assert_allclose(weights.values @ points, [0.5, 0.5, 1.0], rtol=1e-12)


@pytest.mark.parametrize("kind", SOLIDS)
def test_the_volume_of_a_cube(kind: str) -> None:
    file = solid(kind)
    weights = volume_weights(file, select(file))
    assert weights.measure == pytest.approx(1.0)
    assert weights.values.min() >= 0.0
    np.testing.assert_allclose(weights.values @ file.points, [0.5] * 3, rtol=1e-12)


@pytest.mark.parametrize("kind", SOLIDS)
def test_inner_faces_do_not_count(kind: str) -> None:
    file = solid(kind)
    weights = area_weights(file, select(file))
    assert weights.measure == pytest.approx(6.0)
    assert not weights.covered[np.all(file.points == 0.5, axis=1)].any()


@pytest.mark.parametrize(("kind", "apex"), [("pyramid", 4), ("pyramid13", 4)])
def test_pyramids(kind: str, apex: int) -> None:
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 3]], dtype=float)
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]
    middles = np.array([(corners[a] + corners[b]) / 2 for a, b in edges])
    points = np.vstack([corners, middles])[: ELEMENTS[kind].size]
    file = field_file(points, {"none": np.zeros_like(points)}, {kind: np.arange(len(points))[None]})
    assert volume_weights(file, select(file)).measure == pytest.approx(4.0)
    slant = 4 * np.hypot(1, 3)
    assert area_weights(file, select(file)).measure == pytest.approx(4.0 + slant)


def test_consistent_shares_give_the_exact_mean() -> None:
    """Straight six-node triangles: nothing at the corners, a third at the mid-sides."""
    corners = np.array([[0, 0, 0], [3, 0, 1], [1, 2, 0]], dtype=float)
    points = np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) / 2
    share = shares(ELEMENTS["triangle6"], points[None])[0]
    expected = area / 3 * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(share, expected, atol=1e-14)


def test_lumped_shares_of_a_square() -> None:
    """Hinton, Rock and Zienkiewicz 1976: 3/76 at the corners and 16/76 at the mid-sides."""
    square = np.hstack([ELEMENTS["quad8"].nodes, np.zeros((8, 1))])
    share = shares(ELEMENTS["quad8"], square[None])[0]
    np.testing.assert_allclose(share, 4.0 * np.repeat([3 / 76, 16 / 76], 4), rtol=1e-12)


@pytest.mark.parametrize("kind", ["triangle6", "quad8", "quad9"])
def test_curved_faces_have_their_true_area(kind: str) -> None:
    """A face on a cylinder of radius and height one, 0.2 rad wide; the triangle is half of it."""
    nodes = ELEMENTS[kind].nodes.copy()
    lows, highs = nodes.min(axis=0), nodes.max(axis=0)
    angle, height = ((nodes - lows) / (highs - lows)).T * [[0.2], [1.0]]
    points = np.column_stack([np.cos(angle), np.sin(angle), height])
    share = shares(ELEMENTS[kind], points[None])[0]
    fraction = 0.5 if kind == "triangle6" else 1.0
    assert share.sum() == pytest.approx(0.2 * fraction, rel=1e-4)
    assert share.min() >= 0.0


def test_surface_elements_count_once() -> None:
    """A face that the file holds also as a surface element is no second face."""
    points, nodes = cube("hexahedron", 1)
    order = [4, 5, 6, 7]
    cells = {"hexahedron": nodes, "quad": np.vstack([nodes[:, order], nodes[:, order[::-1]]])}
    file = field_file(points, {"none": np.zeros_like(points)}, cells)
    weights = area_weights(file, select(file, TOP))
    np.testing.assert_allclose(weights.values, 0.25)
    assert "area 1e+06 mm^2 of 1 quad" in weights.words


def test_nodes_outside_of_all_faces_are_told() -> None:
    file = solid("hexahedron")
    corner = Listed((1,))
    with pytest.raises(FieldError, match="no face has all its nodes among the 1 selected") as error:
        area_weights(file, select(file, corner))
    assert "equal weights" in error.value.mend
    with pytest.raises(FieldError, match="no solid element"):
        volume_weights(file, select(file, TOP))
    stray = field_file(
        np.vstack([file.points, [[0.5, 0.5, 1.0 + 1e-9]]]),
        {"none": np.zeros((len(file.points) + 1, 3))},
        {"hexahedron": file.facets["hexahedron"] - 1},
    )
    weights = area_weights(stray, select(stray, TOP))
    assert weights.values[-1] == 0.0
    assert "1 nodes outside of these weigh nothing" in weights.words


def test_weights_do_not_depend_on_numbering() -> None:
    points, nodes = cube("tetra10")
    rng = np.random.default_rng(3)
    order = rng.permutation(len(points))
    place = np.argsort(order)
    plain = field_file(points, {"none": np.zeros_like(points)}, {"tetra10": nodes})
    mixed = field_file(
        points[order],
        {"none": np.zeros_like(points)},
        {"tetra10": place[nodes]},
        ids=1000 - 3 * np.arange(len(points)),
    )

    def by_place(file: FieldFile) -> dict[tuple[float, ...], float]:
        chosen = select(file, TOP)
        places: Array = file.points[chosen.rows]
        return dict(
            zip(map(tuple, places.tolist()), area_weights(file, chosen).values, strict=True)
        )

    expected = by_place(plain)
    assert by_place(mixed) == pytest.approx(expected)
