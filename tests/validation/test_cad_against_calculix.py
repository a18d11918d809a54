"""The same link twice: from CAD, and from fields that CalculiX computed, through `identify`.

An angle bracket with a rounded inner corner, clamped at one end and loaded at the other. CalculiX
gets second-order tetrahedra, clamped nodes, and nodal forces that do the work of the tractions of
an average interface; its field is read with area weights. Each side estimates its own error, and
they must agree within both.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from benchmarks.fea.calculix import TO_CALCULIX, readings, tip_quadrature, tip_triangles
from calculix_runs import (  # type: ignore[import-not-found]
    clamped_solid,
    needs_calculix,
    run_calculix,
    static_step,
)

pytest.importorskip("netgen.occ")

from stiffkit.fea import (
    MeshSettings,
    Part,
    PartMesh,
    Port,
    SolveSettings,
    build_part,
    mesh_part,
    named_ports,
    reduce_part,
    relative_difference,
)
from stiffkit.fea.adapt import AdaptSettings, adapt
from stiffkit.fea.fields import CASES, face_nodes
from stiffkit.identify import Field, identify
from stiffkit.identify.readers import read_field_file, read_node_sets, with_node_sets
from stiffkit.identify.selection import InSet, field_of, select
from stiffkit.identify.weights import area_weights
from stiffkit.link import Material
from stiffkit.link.checks import symmetrize
from stiffkit.spatial.rotation import Array

pytestmark = needs_calculix

STEEL = Material("steel", E=2.1e11, nu=0.3, density=7850.0)
LOADS = np.diag([1.0, 1.0, 1.0, 0.01, 0.01, 0.01])
"""N and N m."""
SIZES = (0.0055, 0.003)
"""m; CalculiX's own error follows from the difference."""

SHAPE = """
from netgen.occ import Box, X, Z

def bracket():
    angle = Box((0, 0, 0), (12, 20, 45)) + Box((0, 0, 33), (50, 20, 45))
    inner = [e for e in angle.edges if abs(e.center.x - 12) + abs(e.center.z - 33) < 1e-6]
    angle = angle.MakeFillet(inner, 5)
    angle.faces.Min(Z).name = "base"
    angle.faces.Max(X).name = "tip"
    return angle
"""


@pytest.fixture(scope="module")
def bracket(tmp_path_factory: pytest.TempPathFactory) -> Part:
    script = tmp_path_factory.mktemp("bracket") / "bracket.py"
    script.write_text(SHAPE, encoding="utf-8")
    return build_part(script, "bracket")


@pytest.fixture(scope="module")
def meshes(bracket: Part) -> list[PartMesh]:
    return [mesh_part(bracket, MeshSettings(size)) for size in SIZES]


@pytest.fixture(scope="module")
def ports(bracket: Part) -> tuple[Port, ...]:
    return named_ports(bracket, {"base": "clamped", "tip": "average"})


def deck(mesh: PartMesh, ports: tuple[Port, ...]) -> list[str]:
    """Return CalculiX's input, in metres and newtons."""
    rows = enumerate(mesh.points.tolist(), 1)
    lines = ["*NODE, NSET=ALL", *(f"{n}, {x:.12g}, {y:.12g}, {z:.12g}" for n, (x, y, z) in rows)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=PART")
    tets = mesh.tets[:, TO_CALCULIX] + 1
    lines += [f"{n}, " + ", ".join(map(str, tet)) for n, tet in enumerate(tets.tolist(), 1)]
    for port in ports:
        nodes = face_nodes(mesh, port.faces, 2) + 1
        lines += [f"*NSET, NSET={port.name.upper()}", *map(str, nodes.tolist())]
    lines += clamped_solid("PART", STEEL.E, STEEL.nu)
    for load, row in zip(np.diag(LOADS), readings(mesh, ports[1]), strict=True):
        lines += static_step(load * row.reshape(-1, 3))
    return lines


@pytest.fixture(scope="module")
def solved(
    meshes: list[PartMesh], ports: tuple[Port, ...], tmp_path_factory: pytest.TempPathFactory
) -> list[Path]:
    """Folders of CalculiX's results."""
    folders = []
    for mesh in meshes:
        folder = tmp_path_factory.mktemp("calculix")
        run_calculix(folder, "part", deck(mesh, ports))
        folders.append(folder)
    return folders


def identified(folder: Path, tip: Port) -> Array:
    """The compliance that a user gets from the files of another program."""
    file = read_field_file(folder / "part.frd")
    file = with_node_sets(file, read_node_sets(folder / "part.inp"))
    chosen = select(file, InSet("TIP"))
    field = field_of(file, chosen, weights=area_weights(file, chosen).values)
    return identify(field, LOADS, tip.point).symmetrised


def richardson(coarse: PartMesh, fine: PartMesh, k_coarse: Array, k_fine: Array) -> float:
    """Estimate the relative error of the finer solution, over all loads.

    Energies of quadratic elements converge with h^4, of smooth solutions; with the stresses at the
    clamped corners unbounded, no more than h^2 is taken for granted.
    """
    ratio = (len(fine.points) / len(coarse.points)) ** (2.0 / 3.0)
    return float(relative_difference(k_fine - k_coarse, k_fine) / (ratio - 1.0))


def test_both_ways_agree_within_their_error_estimates(
    bracket: Part, meshes: list[PartMesh], ports: tuple[Port, ...], solved: list[Path]
) -> None:
    compliances = [identified(folder, ports[1]) for folder in solved]
    theirs = richardson(meshes[0], meshes[1], compliances[0], compliances[1])
    settings = AdaptSettings(tolerance=5e-3, solve=SolveSettings(threads=1))
    ours = adapt(bracket, ports, [STEEL], settings)
    assert ours.converged
    k = ours.model.compliance
    difference = relative_difference(compliances[-1] - k, k)
    assert difference < theirs + ours.estimate
    # Neither estimate is so wide that this would say nothing.
    assert theirs < 0.02


def test_the_same_mesh_and_elements_give_the_same_compliance(
    meshes: list[PartMesh], ports: tuple[Port, ...], solved: list[Path]
) -> None:
    """Read at integration points, both are the same discretisation, but for digits of the text."""
    mesh, tip = meshes[0], ports[1]
    file = read_field_file(solved[0] / "part.frd")
    u = np.stack([file.cases[name] for name in file.cases])[:, np.argsort(file.ids)]
    points, area, shapes = tip_quadrature(mesh, tip)
    moved = np.einsum("qk,mtkc->mtqc", shapes, u[:, tip_triangles(mesh, tip)])
    field = Field(points.reshape(-1, 3), moved.reshape(6, -1, 3), area.ravel(), CASES)
    theirs = symmetrize(identify(field, LOADS, tip.point).compliance)
    settings = SolveSettings(order=2, threads=1)
    ours = reduce_part(mesh, ports, [STEEL], settings).compliance
    assert relative_difference(theirs - ours, ours) < 5e-5
