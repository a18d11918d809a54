"""The same link twice: from CAD, and from fields that CalculiX computed, through `identify`.

An angle bracket with a rounded inner corner, clamped at one end and loaded at the other. CalculiX
gets second-order tetrahedra, clamped nodes, and nodal forces that do the work of the tractions of
an average interface; its field is read with area weights. Each side estimates its own error, and
they must agree within both.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("netgen.occ")

from stiffkit.fea import (
    FacePick,
    Interface,
    MeshSettings,
    Part,
    PartMesh,
    Port,
    SolveSettings,
    build_part,
    find_ports,
    mesh_part,
    reduce_part,
    relative_difference,
)
from stiffkit.fea.adapt import AdaptSettings, adapt
from stiffkit.fea.fields import CASES, face_nodes
from stiffkit.identify import Field, identify
from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers import read_field_file, read_node_sets, with_node_sets
from stiffkit.identify.selection import InSet, field_of, select
from stiffkit.identify.weights import area_weights
from stiffkit.link import Material
from stiffkit.link.checks import symmetrize
from stiffkit.spatial import skew
from stiffkit.spatial.rotation import Array

pytestmark = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX is not installed: apt-get install calculix-ccx"
)

STEEL = Material("steel", E=2.1e11, nu=0.3, density=7850.0)
LOADS = np.diag([1.0, 1.0, 1.0, 0.01, 0.01, 0.01])
"""N and N m."""
SIZES = (0.0055, 0.003)
"""m; CalculiX's own error follows from the difference."""
TO_CALCULIX = [0, 2, 1, 3, 5, 7, 4, 6, 9, 8]
TO_VTK = [0, 1, 2, 5, 3, 4]
"""Nodes of Netgen's ten-node tetrahedra, which are left-handed, and of its six-node triangles."""

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
    return find_ports(
        bracket,
        [
            Interface("base", FacePick(names=("base",)), "clamped"),
            Interface("tip", FacePick(names=("tip",)), "average"),
        ],
    )


def tip_triangles(mesh: PartMesh, tip: Port) -> NDArray[np.int64]:
    own = np.isin(mesh.triangle_face, tip.faces)
    return mesh.triangles[own][:, TO_VTK].astype(np.int64)


def face_quadrature(mesh: PartMesh, tip: Port) -> tuple[Array, Array, Array]:
    """Return points (t, q, 3) in the tip's triangles, their areas (t, q), and shapes (q, 6)."""
    kind = ELEMENTS["triangle6"]
    corners = mesh.points[tip_triangles(mesh, tip)]
    tangents = np.einsum("qdk,tkc->tqdc", kind.gradients, corners)
    density = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2)
    return kind.shape_functions @ corners, density * kind.weights, kind.shape_functions


def nodal_forces(mesh: PartMesh, tip: Port, wrench: Array) -> Array:
    """Return the forces (n, 3) of the traction (F + (J^-1 M) x r) / A on the tip."""
    points, area, shapes = face_quadrature(mesh, tip)
    arms = points - tip.point
    J = np.einsum("tq,tqij->ij", area, np.array([[skew(r).T @ skew(r) for r in t] for t in arms]))
    turn = np.linalg.solve(J, wrench[3:])
    traction = wrench[:3] / area.sum() + np.cross(turn, arms)
    forces = np.zeros_like(mesh.points)
    shares = np.einsum("tq,qk,tqc->tkc", area, shapes, traction)
    np.add.at(forces, tip_triangles(mesh, tip), shares)
    return forces


def deck(mesh: PartMesh, ports: tuple[Port, ...]) -> str:
    """Return CalculiX's input, in metres and newtons."""
    rows = enumerate(mesh.points.tolist(), 1)
    lines = ["*NODE, NSET=ALL", *(f"{n}, {x:.12g}, {y:.12g}, {z:.12g}" for n, (x, y, z) in rows)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=PART")
    tets = mesh.tets[:, TO_CALCULIX] + 1
    lines += [f"{n}, " + ", ".join(map(str, tet)) for n, tet in enumerate(tets.tolist(), 1)]
    for port in ports:
        nodes = face_nodes(mesh, port.faces, 2) + 1
        lines += [f"*NSET, NSET={port.name.upper()}", *map(str, nodes.tolist())]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{STEEL.E}, {STEEL.nu}"]
    lines += ["*SOLID SECTION, ELSET=PART, MATERIAL=STEEL", "*BOUNDARY", "BASE, 1, 3"]
    for wrench in LOADS:
        lines += ["*STEP", "*STATIC", "*CLOAD, OP=NEW"]
        forces = nodal_forces(mesh, ports[1], wrench)
        for node in np.flatnonzero(forces.any(axis=1)).tolist():
            lines += [f"{node + 1}, {axis}, {f:.12e}" for axis, f in enumerate(forces[node], 1)]
        lines += ["*NODE FILE", "U", "*END STEP"]
    return "\n".join([*lines, ""])


@pytest.fixture(scope="module")
def solved(
    meshes: list[PartMesh], ports: tuple[Port, ...], tmp_path_factory: pytest.TempPathFactory
) -> list[Path]:
    """Folders of CalculiX's results."""
    folders = []
    for mesh in meshes:
        folder = tmp_path_factory.mktemp("calculix")
        (folder / "part.inp").write_text(deck(mesh, ports), encoding="ascii")
        done = subprocess.run(
            ["ccx", "-i", "part"], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout[-2000:]
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
    points, area, shapes = face_quadrature(mesh, tip)
    moved = np.einsum("qk,mtkc->mtqc", shapes, u[:, tip_triangles(mesh, tip)])
    field = Field(points.reshape(-1, 3), moved.reshape(6, -1, 3), area.ravel(), CASES)
    theirs = symmetrize(identify(field, LOADS, tip.point).compliance)
    settings = SolveSettings(order=2, threads=1)
    ours = reduce_part(mesh, ports, [STEEL], settings).compliance
    assert relative_difference(theirs - ours, ours) < 5e-5
