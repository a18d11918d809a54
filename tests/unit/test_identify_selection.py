"""Choosing nodes near the reference point."""

import numpy as np
import pytest
from tests.unit.field_files import field_file

from stiffkit.errors import FieldError
from stiffkit.identify.readers import FieldFile
from stiffkit.identify.selection import (
    Box,
    InSet,
    Layer,
    Listed,
    Near,
    Region,
    Sphere,
    field_of,
    nearest,
    select,
)


@pytest.fixture
def lattice() -> FieldFile:
    """The 11 x 11 x 11 nodes of a cube of 10 mm, numbered from 1, x slowest."""
    points = np.array(list(np.ndindex(11, 11, 11))) * 1e-3
    sets = {"Tip": np.flatnonzero(points[:, 0] == 0.01) + 1, "lost": np.array([5, 99999])}
    return field_file(points, {"push": points * 1e-3, "pull": -points}, sets=sets)


@pytest.mark.parametrize(
    ("regions", "count"),
    [
        ((), 1331),
        ((InSet("Tip"),), 121),
        ((Box((0.0, 0.0, 0.0), (0.0, 0.01, 0.002)),), 33),
        ((Sphere((0.005, 0.005, 0.005), 0.001),), 7),
        ((Near((0.0, 0.0, 0.0), 0.001),), 4),
        ((Layer((0.01, 0.0, 0.0), (-3.0, 0.0, 0.0), 0.0),), 121),
        ((Layer((0.01, 0.0, 0.0), (1.0, 0.0, 0.0), 0.004),), 363),
        ((Layer((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), 0.0),), 11),
        ((Listed((7, 3, 7)),), 2),
        ((InSet("Tip"), Box((0.0, 0.0, 0.0), (1.0, 0.003, 0.003))), 16),
        ((InSet("Tip"), Near((0.01, 0.005, 0.005), 0.001), Listed((1, 1271))), 1),
    ],
)
def test_counts(lattice: FieldFile, regions: tuple[Region, ...], count: int) -> None:
    chosen = select(lattice, *regions)
    assert len(chosen.rows) == count
    np.testing.assert_array_equal(lattice.ids[chosen.rows], chosen.ids)
    assert chosen.words.startswith(f"{count} node")


def test_selection_in_words(lattice: FieldFile) -> None:
    tip = select(lattice, InSet("Tip"), Near((0.01, 0.005, 0.005), 0.002))
    assert tip.words == (
        "13 nodes in the set 'Tip' and within 2 mm of the reference point (10, 5, 5) mm"
    )
    layer = select(lattice, Layer((0.01, 0, 0), (1, 0, 0), 1e-3))
    assert (
        layer.words == "121 nodes in the layer 1 mm thick through (10, 0, 0) mm, normal (1, 0, 0)"
    )
    assert select(lattice, Listed((7,))).words == "1 node in the list of node 7"
    assert select(lattice).words == "1331 nodes of the whole field"


def test_rounded_text_does_not_lose_nodes(lattice: FieldFile) -> None:
    """Six digits in a file leave errors that must not keep a node off its plane."""
    rng = np.random.default_rng(1)
    noise = rng.uniform(-5e-9, 5e-9, lattice.points.shape)
    moved = field_file(lattice.points + noise, lattice.cases)
    assert len(select(moved, Layer((0.01, 0, 0), (1, 0, 0), 0.0)).rows) == 121


def test_empty_selection_tells_how_far_the_nearest_node_is(lattice: FieldFile) -> None:
    with pytest.raises(FieldError) as error:
        select(lattice, Near((10.0, 5.0, 5.0), 1.0))
    assert "no node is selected: 0 nodes are within 1000 mm" in error.value.what
    assert "the nearest is node 1331, 11231.1 mm away" in error.value.what
    assert "between (0, 0, 0) mm and (10, 10, 10) mm" in error.value.mend
    with pytest.raises(FieldError, match=r"121 nodes .*; 4 nodes .*; none is in all of these"):
        select(lattice, InSet("Tip"), Near((0.0, 0.0, 0.0), 0.001))


@pytest.mark.parametrize(
    ("region", "message"),
    [
        (InSet("tipp"), "has no node set 'tipp'\n  mend: did you mean 'Tip'"),
        (InSet("zzz"), "it has Tip, lost"),
        (InSet("lost"), "the set 'lost' names node 99999, which the file does not have"),
        (Listed((1, 0, -4)), r"the list names 2 nodes \(0, -4\)"),
    ],
)
def test_names_and_numbers_that_are_not_there(
    lattice: FieldFile, region: Region, message: str
) -> None:
    with pytest.raises(FieldError, match=message):
        select(lattice, region)


def test_a_file_without_sets_says_so(lattice: FieldFile) -> None:
    bare = field_file(lattice.points, lattice.cases)
    with pytest.raises(FieldError, match="holds no sets: add a file that does"):
        select(bare, InSet("Tip"))


def test_regions_that_hold_nothing() -> None:
    with pytest.raises(FieldError, match=r"the box from .* holds no point"):
        Box((0.0, 1.0, 0.0), (1.0, 0.0, 1.0))
    with pytest.raises(FieldError, match="the radius of a sphere is 0 mm"):
        Sphere((0.0, 0.0, 0.0), 0.0)
    with pytest.raises(FieldError, match="the distance to the reference point is nan mm"):
        Near((0.0, 0.0, 0.0), float("nan"))
    with pytest.raises(FieldError, match="normal of a layer is zero"):
        Layer((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.001)
    with pytest.raises(FieldError, match="thickness of a layer is -1 mm"):
        Layer((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), -0.001)


def test_nearest_node(lattice: FieldFile) -> None:
    node, away = nearest(lattice, (0.0101, 0.0, 0.0))
    assert node == 1211
    assert away == pytest.approx(1e-4)


def test_the_field_of_a_selection(lattice: FieldFile) -> None:
    tip = select(lattice, InSet("Tip"))
    field = field_of(lattice, tip, ["pull"], np.arange(121))
    assert field.case_names == ("pull",)
    np.testing.assert_array_equal(field.nodes, tip.ids[1:])
    np.testing.assert_array_equal(field.displacements[0], -field.points)
    with pytest.raises(FieldError, match="has no load case 'twist'\n  mend: it has push, pull"):
        field_of(lattice, tip, ["twist"])
