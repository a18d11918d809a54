"""Node sets, surfaces and elements of input decks."""

from pathlib import Path

import numpy as np
import pytest
from tests.unit.field_files import field_file

from stiffkit.errors import FileError
from stiffkit.identify.readers import read_node_sets, with_node_sets
from stiffkit.identify.selection import InSet, select
from stiffkit.identify.weights import area_weights

BLOCK = """** two bricks, one upon the other
*Heading
 a model
*NODE, NSET=All
1, 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
9, 0., 0., 2.
10, 1., 0., 2.
11, 1., 1., 2.
12, 0., 1., 2.
*Element, type=C3D8R, elset=Lower
1, 1, 2, 3, 4,
 5, 6, 7, 8
*ELEMENT, TYPE=C3D8I, ELSET=Upper
2, 5, 6, 7, 8, 9, 10, 11, 12
*Element, type=MASS
3, 1
*NSET, NSET=Base
1, 2,
3, 4
*nset, nset=Middle, generate
5, 8
*NSET, NSET="Top and more", GENERATE
9, 13, 2
*NSET, NSET=BOTH
base, MIDDLE, 9
*Nset, nset=base
4, 5
*NSET, NSET=Brick, ELSET=upper
*ELSET, ELSET=Every, GENERATE
1, 2
*SURFACE, NAME=Cap
Upper, S2
*SURFACE, NAME=Front, TYPE=ELEMENT
every, S3
*Surface, name=Few, type=NODE
base
9
*SURFACE, NAME=Ball, TYPE=SPHERE
*STEP
*CLOAD
Base, 1, 2.0
"""


@pytest.fixture
def deck(tmp_path: Path) -> Path:
    path = tmp_path / "a.inp"
    path.write_text(BLOCK, encoding="utf-8")
    return path


def test_sets(deck: Path) -> None:
    sets = {name: ids.tolist() for name, ids in read_node_sets(deck).sets.items()}
    assert sets == {
        "All": list(range(1, 13)),
        "Base": [1, 2, 3, 4, 5],
        "Middle": [5, 6, 7, 8],
        "Top and more": [9, 11],
        "BOTH": [1, 2, 3, 4, 5, 6, 7, 8, 9],
        "Brick": [5, 6, 7, 8, 9, 10, 11, 12],
        "Cap": [9, 10, 11, 12],
        "Front": [1, 2, 5, 6, 9, 10],
        "Few": [1, 2, 3, 4, 5, 9],
    }


def test_nodes_and_elements(deck: Path) -> None:
    read = read_node_sets(deck)
    np.testing.assert_array_equal(read.ids, np.arange(1, 13))
    np.testing.assert_array_equal(read.points[[0, 11]], [[0, 0, 0], [0, 1, 2]])
    expected = [[1, 2, 3, 4, 5, 6, 7, 8], [5, 6, 7, 8, 9, 10, 11, 12]]
    np.testing.assert_array_equal(read.facets["hexahedron"], expected)


@pytest.mark.parametrize(
    ("kind", "label", "nodes"),
    [
        ("C3D8", 1, [1, 2, 3, 4]),
        ("C3D8", 2, [5, 6, 7, 8]),
        ("C3D8", 3, [1, 2, 5, 6]),
        ("C3D8", 4, [2, 3, 6, 7]),
        ("C3D8", 5, [3, 4, 7, 8]),
        ("C3D8", 6, [1, 4, 5, 8]),
        ("C3D20R", 4, [2, 3, 6, 7, 10, 14, 18, 19]),
        ("C3D4", 1, [1, 2, 3]),
        ("C3D4", 2, [1, 2, 4]),
        ("C3D4", 3, [2, 3, 4]),
        ("C3D10T", 4, [1, 3, 4, 7, 8, 10]),
        ("C3D6", 1, [1, 2, 3]),
        ("C3D6", 2, [4, 5, 6]),
        ("C3D6", 3, [1, 2, 4, 5]),
        ("C3D15", 4, [2, 3, 5, 6, 8, 11, 14, 15]),
        ("C3D6", 5, [1, 3, 4, 6]),
        ("S8R", 1, [1, 2, 3, 4, 5, 6, 7, 8]),
    ],
)
def test_faces_of_elements(tmp_path: Path, kind: str, label: int, nodes: list[int]) -> None:
    """Abaqus Analysis User's Guide, "Solid elements": the faces S1, S2, ... of each element."""
    size = {"C3D20R": 20, "C3D10T": 10, "C3D15": 15}.get(kind, int(kind.strip("CDSRT")[-1:]))
    numbers = ", ".join(map(str, range(1, size + 1)))
    path = tmp_path / "a.inp"
    path.write_text(f"*ELEMENT, TYPE={kind}\n1, {numbers}\n*SURFACE, NAME=F\n1, S{label}\n")
    assert read_node_sets(path).sets["F"].tolist() == nodes


def test_sets_and_elements_join_a_field(deck: Path, tmp_path: Path) -> None:
    """A table of displacements gets its faces from the deck; a name in two files merges."""
    read = read_node_sets(deck)
    bare = field_file(read.points, {"push": read.points}, ids=read.ids, sets={"Cap": np.array([1])})
    other = tmp_path / "more.inp"
    other.write_text("*NSET, NSET=Middle\n1\n", encoding="utf-8")
    file = with_node_sets(with_node_sets(bare, read), read_node_sets(other))
    assert file.sets["Middle"].tolist() == [1, 5, 6, 7, 8]
    assert file.sets["Cap"].tolist() == [1, 9, 10, 11, 12]
    weights = area_weights(file, select(file, InSet("Front")))
    np.testing.assert_allclose(weights.values, [0.25, 0.25, 0.5, 0.5, 0.25, 0.25])


def test_included_files(tmp_path: Path) -> None:
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "sets.inp").write_text("*NSET, NSET=Tip\n3, 1\n", encoding="utf-8")
    path = tmp_path / "a.inp"
    path.write_text("*INCLUDE, INPUT=mesh/sets.inp\n*NSET, NSET=T2\nTip, 9\n", encoding="utf-8")
    sets = read_node_sets(path).sets
    assert sets["Tip"].tolist() == [1, 3]
    assert sets["T2"].tolist() == [1, 3, 9]
    for other in ("../a.inp", "/etc/passwd", "a.inp"):
        path.write_text(f"*INCLUDE, INPUT={other}\n", encoding="utf-8")
        with pytest.raises(FileError, match="is not followed") as error:
            read_node_sets(path)
        assert error.value.line == 1


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("nothing here\n", None, "there are no keywords"),
        ("*NSET\n1\n", 1, "the set has no name"),
        ("*NODE\n1, 0., 0., 0.\n*NSET, NSET=A\n1, B\n", 3, "there is no set 'B' above"),
        ("*NSET, NSET=A\n1, 2.5\n", 1, "there is no set '2.5' above"),
        ("*NSET, NSET=A, GENERATE\n5, 1\n", 1, "'5, 1' is no range"),
        ("*NSET, NSET=A, GENERATE\n1, 999999999999\n", 1, "is no range"),
        ("*NSET, NSET=A, GENERATE\n1, x\n", 1, "'x' is not the number of a node"),
        ("*NSET, NSET=A\n99999999999999999999\n", 1, "'99999999999999999999' is not the number"),
        ("*NODE\n1, 0., zero\n", 1, "a line is not a node number and its coordinates"),
        ("*ELEMENT, TYPE=C3D8\n1, 1, 2, 3\n", 1, "elements of type C3D8 have 8 nodes"),
        ("*NODE\n1, 0, 0, 0\n\n*SURFACE, NAME=A\nE, S1\n", 4, "there is no set 'E' above"),
        ("*INSTANCE, NAME=A\n*INSTANCE, NAME=B\n", 2, "several parts"),
    ],
)
def test_bad_decks(tmp_path: Path, text: str, line: int | None, message: str) -> None:
    path = tmp_path / "a.inp"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileError) as error:
        read_node_sets(path)
    assert message in error.value.what
    assert error.value.line == line
    assert error.value.mend


def test_a_deck_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="this is a directory"):
        read_node_sets(tmp_path)
    path = tmp_path / "a.inp"
    path.write_bytes(np.random.default_rng(0).bytes(5000).replace(b"*", b""))
    with pytest.raises(FileError, match="there are no keywords"):
        read_node_sets(path)
