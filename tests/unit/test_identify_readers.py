"""Files of displacements: text formats, and whatever can be wrong with any file."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest
from tests.unit.field_files import FRD_NUMBERS, csv_text, cube, field_file, frd_text

from stiffkit.errors import FieldError, FileError, StiffkitError
from stiffkit.identify.readers import FORMATS, FieldFile, merge_cases, read_field_file, source


@pytest.fixture
def two_cases() -> FieldFile:
    """A cube of eight nodes numbered 7, 10, 13, ..., with two load cases."""
    points, nodes = cube("hexahedron", 1)
    rng = np.random.default_rng(0)
    cases = {f"step {n}": 1e-3 * rng.standard_normal((8, 3)) for n in (1, 2)}
    return field_file(points, cases, {"hexahedron": nodes}, ids=7 + 3 * np.arange(8))


def written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8", newline="")
    return path


def in_six_digits(values: np.ndarray) -> np.ndarray:
    return np.array([[float(f"{x:.5E}") for x in row] for row in values.tolist()])


def assert_same(a: FieldFile, b: FieldFile) -> None:
    np.testing.assert_array_equal(a.ids, b.ids)
    np.testing.assert_array_equal(a.points, b.points)
    assert list(a.cases) == list(b.cases)
    for name in a.cases:
        np.testing.assert_array_equal(a.cases[name], b.cases[name])


# CalculiX


@pytest.mark.parametrize("long", [True, False])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_frd(tmp_path: Path, two_cases: FieldFile, long: bool, end: str) -> None:
    file = read_field_file(written(tmp_path / "a.frd", frd_text(two_cases, long, end)))
    rounded = {name: in_six_digits(values) for name, values in two_cases.cases.items()}
    assert_same(file, field_file(two_cases.points, rounded, ids=two_cases.ids))
    np.testing.assert_array_equal(file.facets["hexahedron"], two_cases.facets["hexahedron"])
    assert file.format == "frd"


@pytest.mark.parametrize("kind", list(FRD_NUMBERS))
@pytest.mark.parametrize("long", [True, False])
def test_frd_elements(tmp_path: Path, kind: str, long: bool) -> None:
    size = {"triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8}.get(kind)
    points, nodes = cube(kind, 1) if size is None else (np.eye(8, 3), np.arange(size)[None])
    made = field_file(points, {"step 1": points}, {kind: nodes, "quad": nodes[:, [0, 1, 2, 2]]})
    file = read_field_file(written(tmp_path / "a.frd", frd_text(made, long)))
    np.testing.assert_array_equal(file.facets[kind], made.facets[kind])
    np.testing.assert_array_equal(file.facets["quad"], made.facets["quad"])


def test_frd_takes_the_last_increment_and_names_modes(tmp_path: Path, two_cases: FieldFile) -> None:
    text = frd_text(two_cases)
    second = text.index("    1PSTEP", text.index("    1PSTEP") + 1)
    later = text[second:].replace(f"{2:12d}{1:12d}{2:12d}", f"{2:12d}{2:12d}{1:12d}")
    file = read_field_file(written(tmp_path / "a.frd", text[:second] + later))
    assert list(file.cases) == ["step 1"]
    np.testing.assert_array_equal(file.cases["step 1"], in_six_digits(two_cases.cases["step 2"]))
    mode = f"    1PMODE{'':14}{4:12d}\n  100CL"
    file = read_field_file(written(tmp_path / "b.frd", text.replace("  100CL", mode)))
    assert list(file.cases) == ["step 1, mode 4", "step 2, mode 4"]


def test_frd_skips_other_results(tmp_path: Path, two_cases: FieldFile) -> None:
    text = frd_text(two_cases)
    stress = (
        f"    1PSTEP{'':14}{1:12d}{1:12d}{1:12d}\n  100CL  101 1.000000000{8:12d}{'':20} 0    1"
        f"{'':10} 1\n -4  STRESS      6    1\n -1         7" + 6 * " 1.00000E+00" + "\n -3\n"
    )
    place = text.index("    1PSTEP")
    mixed = written(tmp_path / "a.frd", text[:place] + stress + text[place:])
    assert_same(read_field_file(mixed), read_field_file(written(tmp_path / "b.frd", text)))
    only = written(tmp_path / "c.frd", text[:place] + stress + " 9999\n")
    with pytest.raises(FileError, match="it holds no displacements") as error:
        read_field_file(only)
    assert "*NODE FILE" in error.value.mend


def test_every_cut_of_an_frd_is_one_error(tmp_path: Path, two_cases: FieldFile) -> None:
    text = frd_text(two_cases)
    path = tmp_path / "cut.frd"
    for end in range(1, len(text) - 6, 7):
        written(path, text[:end])
        with pytest.raises(FileError):
            read_field_file(path)


def test_a_damaged_frd_names_the_line(tmp_path: Path, two_cases: FieldFile) -> None:
    lines = frd_text(two_cases).split("\n")
    row = next(n for n, line in enumerate(lines) if line.startswith(" -4")) + 5

    def error_with(line: str) -> FileError:
        damaged = written(tmp_path / "a.frd", "\n".join([*lines[:row], line, *lines[row + 1 :]]))
        with pytest.raises(FileError) as error:
            read_field_file(damaged)
        return error.value

    error = error_with(lines[row].replace("E", "x"))
    assert error.line == row + 1
    assert "is not a number" in error.what
    error = error_with(lines[row][:-2])
    assert error.line == row + 1
    assert "fixed columns" in error.what
    error = error_with(lines[row][:13] + 3 * "         NaN")
    assert re.search(r"case 'step 1': .* is not a finite number at node 1\d", error.what)


def test_frd_cases_on_different_nodes(tmp_path: Path, two_cases: FieldFile) -> None:
    lines = frd_text(two_cases).split("\n")
    last = max(n for n, line in enumerate(lines) if line.startswith(" -1"))
    header = max(n for n, line in enumerate(lines) if line.startswith("  100CL"))
    lines[header] = lines[header].replace("           8", "           7")
    path = written(tmp_path / "a.frd", "\n".join(lines[:last] + lines[last + 1 :]))
    with pytest.raises(FileError, match="case 'step 2' has no displacement of node 28"):
        read_field_file(path)
    lines[header] = lines[header].replace("           7", "           8")
    path = written(tmp_path / "a.frd", "\n".join(lines[:last] + lines[last + 1 :]))
    with pytest.raises(FileError, match="should have 8 records and has 7"):
        read_field_file(path)


def test_binary_frd(tmp_path: Path, two_cases: FieldFile) -> None:
    text = frd_text(two_cases).replace(f"{8:12d}{'':37}1", f"{8:12d}{'':37}2")
    with pytest.raises(FileError, match="the block is binary"):
        read_field_file(written(tmp_path / "a.frd", text))


# Tables

HEADERS = [
    "node,x,y,z,ux,uy,uz",
    "Node Number;X Location (mm);Y Location (mm);Z Location (mm);UX (mm);UY (mm);UZ (mm)",
    "NodeID\tX\tY\tZ\tU1\tU2\tU3",
    '"Point ID","Points:0","Points:1","Points:2","U:0","U:1","U:2"',
    "id, Coords_x, Coords_y, Coords_z, Displacement_X, Displacement_Y, Displacement_Z",
    "node x y z dx dy dz",
]


@pytest.mark.parametrize("header", HEADERS)
def test_headings(tmp_path: Path, header: str) -> None:
    mark = next((mark for mark in "\t;," if mark in header), " ")
    rows = [mark.join(row) for row in (["4", *"123456"], ["9", *"654321"])]
    file = read_field_file(written(tmp_path / "push.csv", "\n".join([header, *rows])))
    np.testing.assert_array_equal(file.ids, [4, 9])
    np.testing.assert_array_equal(file.points, [[1, 2, 3], [6, 5, 4]])
    np.testing.assert_array_equal(file.cases["push"], [[4, 5, 6], [3, 2, 1]])


def test_paraview_table(tmp_path: Path) -> None:
    """Columns of other arrays, magnitudes, places last, and no node number."""
    text = (
        '"U:0","U:1","U:2","U:Magnitude","S:0","Points:0","Points:1","Points:2"\n'
        "1e-3,2e-3,3e-3,3.7e-3,9,1,2,3\n"
    )
    file = read_field_file(written(tmp_path / "a.csv", text))
    np.testing.assert_array_equal(file.ids, [1])
    np.testing.assert_array_equal(file.points, [[1, 2, 3]])
    np.testing.assert_array_equal(file.cases["a"], [[1e-3, 2e-3, 3e-3]])


def test_decimal_comma_comments_sets_and_byte_order_mark(tmp_path: Path) -> None:
    text = (
        "\ufeff# measured\n\nnode;x;y;z;ux;uy;uz;set\n1;0,5;0;0;1,5e-3;0;0;tip|all\n"
        "# left out\n2;1,5;0;0;0;0;-2,5;all\n3;0;0;0;0;0;0;\n"
    )
    file = read_field_file(written(tmp_path / "rig.csv", text))
    np.testing.assert_array_equal(file.points[:, 0], [0.5, 1.5, 0.0])
    np.testing.assert_array_equal(file.cases["rig"][:, 2], [0.0, -2.5, 0.0])
    assert {name: ids.tolist() for name, ids in file.sets.items()} == {"tip": [1], "all": [1, 2]}


def test_several_cases_in_columns_and_in_lines(tmp_path: Path, two_cases: FieldFile) -> None:
    wide = read_field_file(written(tmp_path / "a.csv", csv_text(two_cases)))
    assert_same(wide, two_cases)
    lines = ["case,node,x,y,z,ux,uy,uz,set"]
    for row in range(8):
        for name, values in two_cases.cases.items():
            numbers = [*two_cases.points[row].tolist(), *values[row].tolist()]
            lines.append(",".join([name, str(two_cases.ids[row]), *map(repr, numbers), "all"]))
    long = read_field_file(written(tmp_path / "b.csv", "\n".join(lines)))
    assert_same(long, two_cases)
    np.testing.assert_array_equal(long.sets["all"], two_cases.ids)
    with pytest.raises(FileError, match="case 'step 2' has no displacement of node 28"):
        read_field_file(written(tmp_path / "c.csv", "\n".join(lines[:-1])))


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("node,x,y,z,ux,uy\n1,0,0,0,0,0\n", 1, "there are no displacements ux, uy, uz among"),
        ("node,x,y,ux,uy,uz\n1,0,0,0,0,0\n", 1, "there are no coordinates x, y, z among"),
        ("node,x,y,z,x,ux,uy,uz\n1,0,0,0,0,0,0,0\n", 1, "the column 'x' is there twice"),
        ("node,x,y,z,ux,uy,uz,dx,dy,dz\n" + "1," * 10, 1, "the load case' are there twice"),
        ("node,x,y,z,ux,uy,uz\n", None, "there is no line with numbers"),
        ("1,0,0,0,0,0,0\n2,0,0,0,0,0,0\n", 1, "holds numbers, not the names of the columns"),
        ("node,x,y,z,ux,uy,uz\n1,0,0,0,0,0,0\n5,0,0,0,0,,0\n", 3, "node 5 has no value of 'uy'"),
        ("node,x,y,z,ux,uy,uz\n1,0,0,0,0,0,0\n\n5,0,0,0\n", 4, "node 5 has no value of 'ux'"),
        (
            "node,x,y,z,ux,uy,uz\n#\n1,0,0,0,0,0,?\n",
            3,
            "node 1 has '?' for 'uz', which is no number",
        ),
        ("node,x,y,z,ux,uy,uz,set\n1,0,0,0,0,0,0\n", 2, "node 1 has no value of 'set'"),
        ("x,y,z,ux,uy,uz,case\n1,0,0,0,0,?,a\n", 2, "the line has '?' for 'uz'"),
        ("node,x,y,z,ux,uy,uz\n1.5,0,0,0,0,0,0\n", None, "node number 1.5"),
        ("node,x,y,z,ux,uy,uz\n1,0,0,0,nan,0,0\n2,0,0,0,0,inf,0\n", None, "2 nodes (1, 2)"),
        ("node,x,y,z,ux,uy,uz\n1,0,0,nan,0,0,0\n", None, "the place is not a finite number"),
        ("node,x,y,z,ux,uy,uz\n1,0,0,0,0,0,0\n1,0,0,0,0,0,0\n", None, "node 1 more than once"),
    ],
)
def test_bad_tables(tmp_path: Path, text: str, line: int | None, message: str) -> None:
    with pytest.raises(FileError) as error:
        read_field_file(written(tmp_path / "a.csv", text))
    assert message in error.value.what
    assert error.value.line == line
    assert error.value.mend


# Any file


@pytest.mark.parametrize("suffix", [".csv", ".frd", ".vtu", ".op2", ".rst", ".xyz"])
def test_files_that_are_none(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"

    def what() -> str:
        with pytest.raises(FileError) as error:
            read_field_file(path)
        assert error.value.path == path
        assert error.value.mend
        return error.value.what

    assert what() == "no such file"
    path.mkdir()
    assert what() == "this is a directory"
    path.rmdir()
    path.touch()
    assert what() == "the file is empty"
    path.unlink()
    os.mkfifo(path)
    assert what() == "this is not a regular file"


@pytest.mark.parametrize("suffix", [".csv", ".frd", ".op2", ".rst"])
def test_rubbish_is_recognised(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(np.random.default_rng(1).bytes(10_000))
    with pytest.raises(FileError, match=r"it should be a .* and does not begin like one"):
        read_field_file(path)


def test_a_file_of_another_format(tmp_path: Path, two_cases: FieldFile) -> None:
    text = frd_text(two_cases)
    with pytest.raises(FileError, match="should be a table of text and looks like a CalculiX"):
        read_field_file(written(tmp_path / "a.csv", text))
    with pytest.raises(FileError, match=r"looks like a mesh with point data"):
        read_field_file(written(tmp_path / "a.frd", '<?xml version="1.0"?>\n<VTKFile>'))
    with pytest.raises(FileError, match=r"ends in '.xyz' is not known"):
        read_field_file(written(tmp_path / "a.xyz", csv_text(two_cases)))
    with pytest.raises(FileError, match="there is no format 'frb'\n  mend: one of csv, frd"):
        read_field_file(tmp_path / "a.xyz", format="frb")
    assert_same(read_field_file(tmp_path / "a.xyz", format="csv"), two_cases)
    assert read_field_file(tmp_path / "a.csv", format="frd").format == "frd"


def test_files_larger_than_memory_are_refused(
    tmp_path: Path, two_cases: FieldFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path / "a.csv", csv_text(two_cases))
    monkeypatch.setattr(source, "available_memory", lambda: path.stat().st_size)
    with pytest.raises(FileError, match=r"takes about .* GB of memory, and .* GB are free"):
        read_field_file(path)
    monkeypatch.setattr(source, "available_memory", lambda: None)
    assert_same(read_field_file(path), two_cases)


@pytest.mark.parametrize("name", list(FORMATS))
def test_formats_have_suffixes_of_their_own(name: str) -> None:
    others = [
        suffix for other, form in FORMATS.items() if other != name for suffix in form.suffixes
    ]
    assert not set(FORMATS[name].suffixes) & set(others)


@pytest.mark.parametrize(
    ("name", "library"), [("mesh", "meshio"), ("op2", "pyNastran"), ("rst", "ansys-mapdl-reader")]
)
def test_a_missing_library_is_named(
    name: str, library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from stiffkit.identify.readers.child import READERS

    for module in ("meshio", "pyNastran.op2.op2", "ansys.mapdl"):
        monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(StiffkitError, match=f"{library} is needed .* not installed") as error:
        READERS[name](Path("a"), None)
    assert error.value.mend == "pip install 'stiffkit[fields]'"


def damaged(text: bytes, rng: np.random.Generator) -> bytes:
    """Bytes replaced, left out, doubled or cut off at random."""
    at, length = int(rng.integers(len(text))), int(rng.integers(1, 60))
    noise = rng.bytes(1), b"\n", b" ", b"-", b",", b'"', b"9"
    replaced = text[:at] + noise[rng.integers(len(noise))] + text[at + 1 :]
    left_out = text[:at] + text[at + length :]
    doubled = text[: at + length] + text[at:]
    return (replaced, left_out, doubled, text[:at])[rng.integers(4)]


@pytest.mark.parametrize("suffix", [".frd", ".csv"])
def test_damaged_files_are_read_or_refused(
    tmp_path: Path, two_cases: FieldFile, suffix: str
) -> None:
    """Nothing but a ``FileError`` gets out."""
    text = (frd_text if suffix == ".frd" else csv_text)(two_cases).encode()
    rng = np.random.default_rng(7)
    path = tmp_path / f"a{suffix}"
    refused = 0
    for _ in range(300):
        path.write_bytes(damaged(text, rng))
        try:
            read_field_file(path)
        except FileError:
            refused += 1
    assert refused > 150


# Several files, and units


def test_cases_of_several_files_merge(two_cases: FieldFile) -> None:
    order = np.arange(8)[::-1]
    other = FieldFile(
        Path("other.csv"),
        "csv",
        two_cases.ids[order],
        two_cases.points[order],
        {"step 2": two_cases.points[order], "lift": two_cases.points[order]},
        {"tip": np.array([7])},
    )
    merged = merge_cases([two_cases.with_sets({"tip": [10]}), other])
    assert list(merged.cases) == ["step 1", "made: step 2", "other: step 2", "lift"]
    np.testing.assert_array_equal(merged.cases["lift"], merged.points)
    assert merged.sets["tip"].tolist() == [7, 10]
    assert merged.facets.keys() == {"hexahedron"}
    with pytest.raises(FieldError, match="the load case 'made: step 1' is there already"):
        merge_cases([two_cases, two_cases])


def test_files_of_different_meshes_do_not_merge(two_cases: FieldFile) -> None:
    fewer = field_file(two_cases.points[1:], {"a": two_cases.points[1:]}, ids=two_cases.ids[1:])
    with pytest.raises(FieldError, match=r"node 7 only in one of made\.frd and made\.frd"):
        merge_cases([two_cases, fewer])
    moved = field_file(1.01 * two_cases.points, {"a": two_cases.points}, ids=two_cases.ids)
    with pytest.raises(FieldError, match=r"7 nodes .* not at the same place"):
        merge_cases([two_cases, moved])


def test_units_scale_and_content_is_locked(two_cases: FieldFile) -> None:
    metres = two_cases.scaled(1e-3)
    np.testing.assert_allclose(metres.points, 1e-3 * two_cases.points)
    np.testing.assert_allclose(metres.cases["step 1"], 1e-3 * two_cases.cases["step 1"])
    mixed = two_cases.scaled(1e-3, 1e-6)
    np.testing.assert_allclose(mixed.cases["step 1"], 1e-6 * two_cases.cases["step 1"])
    with pytest.raises(ValueError, match="read-only"):
        metres.points[0] = 1.0
