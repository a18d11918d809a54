"""Formats that other libraries read, on files that these libraries write or ship."""

from __future__ import annotations

import base64
import zlib
from importlib.util import find_spec
from pathlib import Path

import meshio
import numpy as np
import pytest
from tests.unit.field_files import cube

from stiffkit.errors import FileError
from stiffkit.identify.readers import read_field_file
from stiffkit.identify.readers.child import READERS
from stiffkit.identify.selection import select
from stiffkit.identify.weights import volume_weights


@pytest.fixture
def mesh() -> meshio.Mesh:
    points, nodes = cube("hexahedron20", 1)
    rng = np.random.default_rng(0)
    return meshio.Mesh(
        points,
        [("hexahedron20", nodes), ("quad", nodes[:, :4]), ("quad", nodes[:, 4:8])],
        point_data={
            "push": rng.standard_normal(points.shape),
            "lift": rng.standard_normal(points.shape),
            "temperature": np.zeros(len(points)),
        },
    )


def test_vtu(tmp_path: Path, mesh: meshio.Mesh, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.vtu"
    mesh.write(path)
    file = read_field_file(path)
    np.testing.assert_array_equal(file.ids, np.arange(20))
    np.testing.assert_array_equal(file.points, mesh.points)
    assert list(file.cases) == ["push", "lift"]
    np.testing.assert_array_equal(file.cases["lift"], mesh.point_data["lift"])
    np.testing.assert_array_equal(file.facets["hexahedron20"], mesh.cells[0].data)
    assert len(file.facets["quad"]) == 2

    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FileError, match=r"a\.vtu: it cannot be read|meshio cannot read it"):
        read_field_file(path)
    path.write_text("<?xml version='1.0'?>\n<VTKFile type='ImageData'></VTKFile>")
    with pytest.raises(FileError, match=r"meshio cannot read it: .*UnstructuredGrid"):
        READERS["mesh"](path, None)
    said = capfd.readouterr()
    assert said.out == said.err == ""


@pytest.mark.parametrize(
    ("suffix", "written_as"),
    [(".vtk", "vtk"), (".msh", "gmsh22"), (".xdmf", "xdmf"), (".med", "med"), (".tec", "tecplot")],
)
def test_other_formats_of_meshio(
    tmp_path: Path, mesh: meshio.Mesh, suffix: str, written_as: str
) -> None:
    path = tmp_path / f"a{suffix}"
    plain = meshio.Mesh(mesh.points, [mesh.cells[1]], point_data=mesh.point_data)
    plain.write(path, file_format=written_as)
    file = READERS["mesh"](path, None)
    np.testing.assert_allclose(file.points, mesh.points, atol=1e-12)
    name = next(name for name in file.cases if name.startswith("push"))
    np.testing.assert_allclose(file.cases[name], mesh.point_data["push"], atol=1e-12)


def test_sets_and_groups(tmp_path: Path, mesh: meshio.Mesh) -> None:
    sets = {"corner": np.array([0, 3])}
    cell_sets = {"bottom": [np.array([], int), np.array([0]), np.array([], int)]}
    with_sets = meshio.Mesh(
        mesh.points, mesh.cells, mesh.point_data, point_sets=sets, cell_sets=cell_sets
    )
    groups = {"gmsh:physical": [np.array([1]), np.array([2]), np.array([3])]}
    groups["gmsh:geometrical"] = [np.array([1]), np.array([1]), np.array([1])]
    named = {"body": np.array([1, 3]), "base": np.array([2, 2])}
    with_groups = meshio.Mesh(
        mesh.points, mesh.cells, mesh.point_data, cell_data=groups, field_data=named
    )
    path = tmp_path / "a.msh"
    with_groups.write(path, file_format="gmsh22")
    file = READERS["mesh"](path, None)
    base = np.unique(mesh.cells[1].data)
    np.testing.assert_array_equal(file.sets["base"], base)
    assert set(file.sets) == {"body", "base", "physical 3"}

    from stiffkit.identify.readers.mesh import _sets

    found = dict(pair for part in _sets(with_sets) for pair in part.items())
    np.testing.assert_array_equal(found["bottom"], base)
    np.testing.assert_array_equal(found["corner"], [0, 3])


def test_a_small_file_cannot_fill_the_memory(
    tmp_path: Path, mesh: meshio.Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A gigabyte of zeros, packed into a megabyte, against a gigabyte of memory."""
    zeros = zlib.compress(bytes(1 << 26), 9)
    header = np.array([16, 1 << 26, 0, *[len(zeros)] * 16], np.uint32).tobytes()
    packed = base64.b64encode(header) + base64.b64encode(zeros * 16)
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" '
        'byte_order="LittleEndian" compressor="vtkZLibDataCompressor"><UnstructuredGrid>'
        '<Piece NumberOfPoints="44739242" NumberOfCells="0"><Points>'
        '<DataArray type="Float64" NumberOfComponents="3" format="binary">'
        f"{packed.decode()}</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"
    )
    path = tmp_path / "bomb.vtu"
    path.write_text(text, encoding="ascii")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    (tmp_path / "sitecustomize.py").write_text(
        "from stiffkit.identify.readers import source\nsource.available_memory = lambda: 10**9\n",
        encoding="utf-8",
    )
    with pytest.raises(FileError, match="does not fit into memory"):
        read_field_file(path)


BULK = """SOL 101
CEND
SET 4 = 20, 40 THRU 60
DISPLACEMENT(PLOT) = 4
SUBCASE 1
BEGIN BULK
CORD2C,1,,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD2S,2,,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD2R,5,,0.,0.,0.,1.,0.,0.
,0.,1.,0.
GRID,10,,0.,0.,0.
GRID,20,,1.,0.,0.,5
GRID,30,1,1.4142136,45.,0.,1
GRID,40,,0.,1.,0.
GRID,50,,0.,0.,1.
GRID,60,,1.,0.,1.,2
GRID,70,,1.,1.,1.
GRID,80,,0.,1.,1.
CHEXA,1,1,10,20,30,40,50,60
,70,80
PSOLID,1,1
SET1,9,10,THRU,30
ENDDATA
"""


def write_op2(path: Path) -> np.ndarray:
    """Write two subcases of eight nodes, and return the displacements (2, 8, 3)."""
    from pyNastran.op2.op2 import OP2
    from pyNastran.op2.tables.oug.oug_displacements import RealDisplacementArray

    model = OP2(debug=False, mode="msc")
    nodes = np.column_stack([10 * np.arange(1, 9), np.ones(8, int)]).astype("int32")
    rng = np.random.default_rng(0)
    values = np.zeros((2, 1, 8, 6), "float32")
    values[..., :3] = rng.standard_normal((2, 1, 8, 3))
    for subcase, data in zip((1, 7), values, strict=True):
        model.displacements[subcase] = RealDisplacementArray.add_static_case(
            "OUGV1", nodes, data, subcase
        )
    model.write_op2(str(path), nastran_format="msc")
    return np.asarray(values[:, 0, :, :3], dtype=float)


@pytest.mark.filterwarnings("ignore:`np.chararray`:DeprecationWarning")
def test_op2(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.op2"
    values = write_op2(path)
    capfd.readouterr()
    with pytest.raises(FileError, match="the coordinates are missing") as error:
        read_field_file(path)
    assert "a.bdf" in error.value.mend

    bulk = tmp_path / "a.BDF"
    bulk.write_text(BULK, encoding="ascii")
    file = read_field_file(path)
    np.testing.assert_array_equal(file.ids, 10 * np.arange(1, 9))
    np.testing.assert_allclose(file.points[2], [1.0, 1.0, 0.0], atol=1e-7)
    assert list(file.cases) == ["subcase 1", "subcase 7"]
    assert file.sets["SET1 9"].tolist() == [10, 20, 30]
    assert file.sets["SET 4"].tolist() == [20, 40, 50, 60]
    assert volume_weights(file, select(file)).measure == pytest.approx(1.0, rel=1e-6)
    for name, expected in zip(file.cases, values, strict=True):
        u = file.cases[name]
        np.testing.assert_array_equal(u[[0, 3, 4, 6, 7]], expected[[0, 3, 4, 6, 7]])
        # CORD2R 5 has its z axis along the basic x, and its x axis along the basic y.
        np.testing.assert_allclose(u[1], expected[1][[2, 0, 1]], atol=1e-12)
        # Cylindrical at 45 degrees, spherical at 45 degrees from z in the plane y = 0.
        r, t, z = expected[2]
        c = np.sqrt(0.5)
        np.testing.assert_allclose(u[2], [c * (r - t), c * (r + t), z], rtol=1e-6)
        r, t, p = expected[5]
        np.testing.assert_allclose(u[5], [c * (r + t), p, c * (r - t)], rtol=1e-6)

    bulk.write_text(BULK.replace("GRID,80,,0.,1.,1.\n", ""), encoding="ascii")
    with pytest.raises(FileError, match=r"node 80 not in the bulk data .*a\.BDF"):
        READERS["op2"](path, bulk)
    capfd.readouterr()
    with pytest.raises(FileError, match=r"none\.bdf: no such file"):
        read_field_file(path, bulk=tmp_path / "none.bdf")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 3])
    with pytest.raises(FileError, match=r"a\.op2"):
        read_field_file(path)
    said = capfd.readouterr()
    assert said.out == said.err == ""


def shipped_rst() -> Path:
    """The modes of a beam of 40 twenty-node hexahedra, which comes with the library."""
    spec = find_spec("ansys.mapdl.reader")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / "examples" / "file.rst"


def test_rst() -> None:
    file = read_field_file(shipped_rst())
    assert list(file.cases) == [f"mode {n}" for n in range(1, 7)]
    np.testing.assert_array_equal(file.ids, np.arange(1, 322))
    # As the library's own result.nodal_displacement(0) gives them.
    expected = [[28.96239142, -28.24804886, -0.30922669], [28.9489249, -28.23424164, 24.75361609]]
    np.testing.assert_allclose(file.cases["mode 1"][:2], expected, rtol=1e-8)
    assert file.facets["hexahedron20"].shape == (40, 20)
    size = np.prod(np.ptp(file.points, axis=0))
    assert volume_weights(file, select(file)).measure == pytest.approx(size)


def test_a_crash_of_a_library_is_one_error(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Cut off within its first records, this file kills the process that reads it."""
    path = tmp_path / "cut.rst"
    path.write_bytes(shipped_rst().read_bytes()[:20000])
    with pytest.raises(FileError, match=r"cut\.rst: (it cannot be read|the reader ended)") as error:
        read_field_file(path)
    assert "export it again" in error.value.mend
    said = capfd.readouterr()
    assert said.out == said.err == ""
