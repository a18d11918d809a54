"""CalculiX: its input for a mesh and six loads, its run, and the compliance that it prints.

Two nodes without elements hold the twist of the tip: equations tie them to the tip's nodes as the
interface says, so that a unit force on one of their six components is a unit wrench, and what
CalculiX prints for them is a column of the compliance.
"""

from __future__ import annotations

import os
import re
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from benchmarks.fea.parts import STEEL
from benchmarks.measure import Cost
from stiffkit.fea import PartMesh, Port
from stiffkit.fea.fields import face_nodes
from stiffkit.identify.elements import ELEMENTS
from stiffkit.spatial import skew
from stiffkit.spatial.rotation import Array

Way = Literal["read", "one step", "six steps", "Green"]
"""How the loads are given. *read*: not at all, the input is read and checked. *six steps*: one
static step for each; CalculiX factorises anew in every step. *Green*: one step of its Green
functions, which factorises once."""

WAYS: tuple[Way, ...] = ("read", "one step", "six steps", "Green")

TO_CALCULIX = [0, 2, 1, 3, 5, 7, 4, 6, 9, 8]
TO_VTK = [0, 1, 2, 5, 3, 4]
"""Nodes of Netgen's ten-node tetrahedra, which are left-handed, and of its six-node triangles."""

_NUMBER = r"[-+]?\d\.\d+E[-+]\d+"
_ROW = re.compile(rf"^\s+\d+\s+({_NUMBER})\s+({_NUMBER})\s+({_NUMBER})\s*$", re.MULTILINE)

Term = tuple[int, int, float]
"""Of an equation: node from 1, component from 1, coefficient."""


@dataclass(frozen=True, eq=False)
class Run:
    """One process of CalculiX."""

    cost: Cost
    compliance: Array
    """(6, m), one column for each load."""


def run(mesh: PartMesh, ports: Sequence[Port], way: Way, folder: Path) -> Run:
    """Solve a mesh, clamped at the first port and loaded at the second, on one core."""
    (folder / "part.inp").write_text(deck(mesh, ports, way), encoding="ascii")
    (folder / "part.dat").unlink(missing_ok=True)
    log = folder / "part.log"
    start = time.perf_counter()
    with log.open("wb") as out:
        process = subprocess.Popen(
            ["ccx", "-i", "part"], cwd=folder, stdout=out, env=os.environ | {"OMP_NUM_THREADS": "1"}
        )
        _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    # It ends with 201 where only reading was asked for.
    if process.returncode != (201 if way == "read" else 0) or "*ERROR" in log.read_text("utf-8"):
        raise RuntimeError(f"CalculiX failed:\n{log.read_text('utf-8')[-2000:]}")
    printed = "" if way == "read" else (folder / "part.dat").read_text("ascii")
    return Run(Cost(wall, usage.ru_utime + usage.ru_stime), read_columns(printed))


def read_columns(printed: str) -> Array:
    """Return the columns (6, m) that CalculiX printed for the two nodes and m loads."""
    values = np.array(_ROW.findall(printed), dtype=float)
    return np.asarray(values.reshape(-1, 6).T)


def deck(mesh: PartMesh, ports: Sequence[Port], way: Way) -> str:
    """Return CalculiX's input, in metres and newtons."""
    base, tip = ports
    n = len(mesh.points)
    at = [*mesh.points.tolist(), *[tip.point.tolist()] * 2]
    rows = [f"{i},{x:.12g},{y:.12g},{z:.12g}" for i, (x, y, z) in enumerate(at, 1)]
    lines = ["*NODE", *rows[:n], "*NODE, NSET=READING", *rows[n:]]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=PART")
    tets = mesh.tets[:, TO_CALCULIX] + 1
    lines += [f"{i}, " + ", ".join(map(str, tet)) for i, tet in enumerate(tets.tolist(), 1)]
    lines.append("*NSET, NSET=BASE")
    lines += map(str, (face_nodes(mesh, base.faces, 2) + 1).tolist())
    # Without a density: Green functions would be those of a vibration of 1 rad/s.
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", f"{STEEL.E}, {STEEL.nu}"]
    lines += ["*SOLID SECTION, ELSET=PART, MATERIAL=STEEL", "*BOUNDARY", "BASE, 1, 3"]
    for equation in equations(mesh, tip, loads_on_unknowns=way == "Green"):
        lines += ["*EQUATION", str(len(equation))]
        for first in range(0, len(equation), 4):
            terms = equation[first : first + 4]
            lines.append(",".join(f"{i},{axis},{value:.12e}" for i, axis, value in terms) + ",")
    return "\n".join([*lines, *_steps(_twist_components(n), way), ""])


def _steps(twist: list[tuple[int, int]], way: Way) -> list[str]:
    forces = [f"{node}, {axis}, 1." for node, axis in twist]
    end = ["*NODE PRINT, NSET=READING", "U", "*END STEP"]
    if way == "read":
        return ["*STEP", "*NO ANALYSIS", "*END STEP"]
    if way == "Green":
        return ["*STEP", "*GREEN", "*CLOAD", *forces, *end]
    loads = forces[:1] if way == "one step" else forces
    return [line for f in loads for line in ("*STEP", "*STATIC", "*CLOAD, OP=NEW", f, *end)]


def _twist_components(n: int) -> list[tuple[int, int]]:
    """Return node and component, from 1, of the tip's twist beside n nodes."""
    return [(n + 1 + k // 3, k % 3 + 1) for k in range(6)]


def equations(mesh: PartMesh, tip: Port, *, loads_on_unknowns: bool) -> list[list[Term]]:
    """Return the equations, their terms, that tie the twist to the tip's nodes.

    The first term of each is eliminated. If ``loads_on_unknowns``, that is never the twist, because
    Green functions are of loads on unknowns only; otherwise, where it can be, it is the twist,
    which ties no nodes together.
    """
    twist = _twist_components(len(mesh.points))
    if tip.is_rigid:
        return _rigid_equations(mesh, tip, twist)
    R = readings(mesh, tip)
    used = np.flatnonzero(np.abs(R).max(axis=0) > 0.0)
    if not loads_on_unknowns:
        return [
            [(*twist[k], 1.0), *((*_component(c), -float(R[k, c])) for c in used)] for k in range(6)
        ]
    scaled = R[:, used] / np.abs(R).max(axis=1)[:, None]
    gone = used[qr(scaled, mode="r", pivoting=True)[1][:6]]
    inverse = np.linalg.inv(R[:, gone])
    kept = np.setdiff1d(used, gone)
    others = inverse @ R[:, kept]
    return [
        [
            (*_component(gone[k]), 1.0),
            *((*twist[j], -float(inverse[k, j])) for j in range(6)),
            *((*_component(c), float(x)) for c, x in zip(kept, others[k], strict=True)),
        ]
        for k in range(6)
    ]


def _rigid_equations(mesh: PartMesh, tip: Port, twist: list[tuple[int, int]]) -> list[list[Term]]:
    """Return the equations that move each node of the tip with the twist."""
    out = []
    for node in face_nodes(mesh, tip.faces, 2).tolist():
        moved = np.hstack([np.eye(3), -skew(mesh.points[node] - tip.point)])
        for axis in range(3):
            row = [(*twist[k], -float(moved[axis, k])) for k in np.flatnonzero(moved[axis])]
            out.append([(node + 1, axis + 1, 1.0), *row])
    return out


def _component(column: int | np.integer) -> tuple[int, int]:
    """Return node and component, from 1, of a column of the readings."""
    return int(column) // 3 + 1, int(column) % 3 + 1


def tip_triangles(mesh: PartMesh, tip: Port) -> NDArray[np.int64]:
    """Return the nodes (t, 6) of the tip's triangles, in VTK's order."""
    own = np.isin(mesh.triangle_face, tip.faces)
    return mesh.triangles[own][:, TO_VTK].astype(np.int64)


def tip_quadrature(mesh: PartMesh, tip: Port) -> tuple[Array, Array, Array]:
    """Return points (t, q, 3) in the tip's triangles, their areas (t, q), and shapes (q, 6)."""
    kind = ELEMENTS["triangle6"]
    corners = mesh.points[tip_triangles(mesh, tip)]
    tangents = np.einsum("qdk,tkc->tqdc", kind.gradients, corners)
    density = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2)
    return kind.shape_functions @ corners, density * kind.weights, kind.shape_functions


def readings(mesh: PartMesh, tip: Port) -> Array:
    """Return the rows (6, 3n) that read the tip's mean twist from the nodes' displacements.

    They are the nodal forces of the tractions (F + (J^-1 M) x r) / A under unit wrenches, too.
    """
    points, area, shapes = tip_quadrature(mesh, tip)
    arms = points - tip.point
    J = np.einsum("tq,tqij->ij", area, np.array([[skew(r).T @ skew(r) for r in t] for t in arms]))
    triangles, rows = tip_triangles(mesh, tip), []
    for wrench in np.eye(6):
        traction = wrench[:3] / area.sum() + np.cross(np.linalg.solve(J, wrench[3:]), arms)
        forces = np.zeros_like(mesh.points)
        shares = np.einsum("tq,qk,tqc->tkc", area, shapes, traction)
        np.add.at(forces, triangles, shares)
        rows.append(forces.ravel())
    return np.array(rows)
