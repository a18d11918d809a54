import numpy as np
import pytest

from stiffkit.errors import FieldError
from stiffkit.identify import Field
from stiffkit.spatial.rotation import Array

TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def still(points: Array, cases: int = 1) -> Array:
    return np.zeros((cases, *np.shape(points)))


def test_three_nodes_are_enough() -> None:
    field = Field(TRIANGLE, still(TRIANGLE, 2))
    assert (field.node_count, field.case_count) == (3, 2)
    assert field.case_names == ("1", "2")
    assert field.spread.dimension == 2
    np.testing.assert_allclose(field.spread.centre, [1 / 3, 1 / 3, 0.0])
    np.testing.assert_allclose(np.abs(field.spread.axes[:, 2]), [0.0, 0.0, 1.0], atol=1e-15)


def test_extents_are_those_of_the_weighted_points() -> None:
    points = np.array(
        [[1.0, 0, 0], [-1.0, 0, 0], [0, 2.0, 0], [0, -2.0, 0], [0, 0, 3.0], [0, 0, -3]]
    )
    spread = Field(points, still(points), weights=[3.0, 3, 2, 2, 1, 1]).spread
    # Weighted mean squares 2 3 1/12, 2 2 4/12 and 2 1 9/12, longest first.
    np.testing.assert_allclose(spread.extents**2, [1.5, 4 / 3, 0.5])
    assert spread.dimension == 3
    assert spread.radius == pytest.approx(np.sqrt(1.5 + 4 / 3 + 0.5))


def test_one_point_shows_no_rotation() -> None:
    points = np.tile([0.1, 0.2, 0.3], (5, 1))
    with pytest.raises(FieldError, match=r"one point, \(0.1, 0.2, 0.3\) m: a rotation about x, y"):
        Field(points, still(points))


@pytest.mark.parametrize(
    ("direction", "words"),
    [([0.0, 0.0, -2.0], "along z"), ([3.0, 0.0, -4.0], r"along \(0.6, 0, -0.8\)")],
)
def test_a_line_hides_the_rotation_about_it(direction: list[float], words: str) -> None:
    points = np.asarray(1.0 + np.outer(np.linspace(0.0, 1.0, 7), direction), dtype=float)
    with pytest.raises(FieldError, match=f"one line .* about that line, {words}, cannot"):
        Field(points, still(points))


def test_two_nodes_are_a_line() -> None:
    points = TRIANGLE[:2]
    with pytest.raises(FieldError, match="along x, cannot be seen"):
        Field(points, still(points))


def test_a_node_beside_the_line_counts_only_with_weight() -> None:
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [0.0, 1.0, 0]])
    assert Field(points, still(points)).spread.dimension == 2
    with pytest.raises(FieldError, match="along x, cannot be seen"):
        Field(points, still(points), weights=[1.0, 1, 1, 0])


def test_nodes_of_weight_zero_are_gone_whatever_they_hold() -> None:
    points = np.vstack([TRIANGLE, [[np.nan] * 3]])
    moved = still(points)
    moved[0, 3] = np.inf
    field = Field(points, moved, weights=[1.0, 2, 3, 0], nodes=[7, 8, 9, 10])
    assert field.nodes.tolist() == [7, 8, 9]
    assert field.weights.tolist() == [1.0, 2.0, 3.0]


def test_a_case_is_a_field_of_some_of_the_nodes() -> None:
    points = np.vstack([TRIANGLE, [[0.0, 0.0, 1.0]]])
    moved = np.arange(24.0).reshape(2, 4, 3)
    one = Field(points, moved, case_names=["a", "b"]).case(1, np.array([True, True, False, True]))
    assert one.case_names == ("b",)
    assert one.nodes.tolist() == [0, 1, 3]
    np.testing.assert_array_equal(one.displacements, moved[1:, [0, 1, 3]])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"points": np.zeros((3, 2))}, r"points must have the shape \(n, 3\) and have \(3, 2\)"),
        ({"displacements": np.zeros((3, 3))}, "stack the load cases"),
        ({"displacements": np.zeros((1, 4, 3))}, "3 points and displacements of 4 nodes"),
        ({"displacements": np.zeros((0, 3, 3))}, "no load case"),
        ({"points": np.zeros((0, 3)), "displacements": np.zeros((1, 0, 3))}, "no nodes"),
        ({"case_names": ["a", "b"]}, "1 load cases and 2 names"),
        ({"weights": [1.0, 1.0]}, r"3 nodes and weights of shape \(2,\)"),
        ({"weights": [1.0, -2.0, 1.0]}, "weight of node 1 is -2"),
        ({"weights": [1.0, np.nan, np.nan]}, "node 1 is nan, and 1 more nodes are like it"),
        ({"weights": [0.0, 0.0, 0.0]}, "all nodes have the weight zero"),
        ({"nodes": [1, 2]}, "3 nodes and 2 node labels"),
        ({"points": np.full((3, 3), np.inf)}, r"point of node 0 is \(inf, inf, inf\), and 2"),
    ],
)
def test_what_is_no_field_is_refused(changes: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"points": TRIANGLE, "displacements": still(TRIANGLE)}
    with pytest.raises(FieldError, match=message):
        Field(**(good | changes))  # type: ignore[arg-type]


def test_a_displacement_that_is_not_a_number_is_named() -> None:
    moved = still(TRIANGLE, 2)
    moved[1, 2, 0] = np.nan
    with pytest.raises(FieldError, match=r"load case My: the displacement of node 30 is \(nan, 0"):
        Field(TRIANGLE, moved, case_names=["Mx", "My"], nodes=[10, 20, 30])
