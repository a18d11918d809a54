"""A cantilever solved by CalculiX, identified, against beam theory.

The beam is the one of A. Pashkevich, A. Klimchik, D. Chablat, P. Wenger, "Accuracy improvement for
stiffness modeling of parallel manipulators", 42nd CIRP Conference on Manufacturing Systems, 2009:
1000 x 10 x 10 mm, E = 2e5 N/mm^2, nu = 0.266. The deck, in millimetres and newtons, is written
here, solved by ccx (Debian's calculix-ccx) and its result read back.
"""

from __future__ import annotations

import numpy as np
import pytest
from calculix_runs import (  # type: ignore[import-not-found]
    clamped_solid,
    needs_calculix,
    run_calculix,
    static_step,
)
from numpy.typing import NDArray

from stiffkit.identify import Identified, identify
from stiffkit.identify.elements import ELEMENTS
from stiffkit.identify.readers import FieldFile, read_field_file, read_node_sets, with_node_sets
from stiffkit.identify.selection import InSet, Layer, field_of, select
from stiffkit.identify.weights import area_weights, volume_weights
from stiffkit.link import Material, beam_compliance, rectangle
from stiffkit.spatial import skew

Array = NDArray[np.float64]

LENGTH, SIDE = 1000.0, 10.0
E, NU = 2.0e5, 0.266
ALONG, ACROSS = 40, 4
"""Elements of 25 x 2.5 x 2.5 mm; the warping in torsion asks for four across."""
FORCE, MOMENT = 1.0, 1000.0
"""N and N mm: small enough for six digits of text to hold linear displacements."""
TIP = np.array([LENGTH, 0.0, 0.0])

pytestmark = needs_calculix


def mesh() -> tuple[Array, NDArray[np.int64]]:
    """Return nodes (n, 3) in mm and twenty-node hexahedra (m, 20), the beam along x."""
    natural = ELEMENTS["hexahedron20"].nodes
    size = np.array([LENGTH / ALONG, SIDE / ACROSS, SIDE / ACROSS])
    cells = np.array(list(np.ndindex(ALONG, ACROSS, ACROSS)))
    corners = (cells[:, None, :] + (natural + 1.0) / 2.0) * size
    corners = corners - [0.0, SIDE / 2, SIDE / 2]
    nodes, which = np.unique(np.round(corners.reshape(-1, 3), 9), axis=0, return_inverse=True)
    return nodes, which.reshape(len(cells), 20)


def deck(nodes: Array, cells: NDArray[np.int64], loads: list[Array]) -> list[str]:
    """Return the input deck; each load case is the forces (n, 3) on the nodes."""
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{n}, {x:.9g}, {y:.9g}, {z:.9g}" for n, (x, y, z) in enumerate(nodes.tolist(), 1)]
    lines.append("*ELEMENT, TYPE=C3D20R, ELSET=BEAM")
    for n, cell in enumerate((cells + 1).tolist(), 1):
        lines += [f"{n}, " + ", ".join(map(str, cell[:10])) + ",", ", ".join(map(str, cell[10:]))]
    for name, place in (("BASE", 0.0), ("TIP", LENGTH)):
        lines += [f"*NSET, NSET={name}", *map(str, np.flatnonzero(nodes[:, 0] == place) + 1)]
    lines += clamped_solid("BEAM", E, NU)
    for forces in loads:
        lines += static_step(forces)
    return lines


def spread(arms: Array, weights: Array, wrench: Array) -> Array:
    """Return nodal forces (k, 3) that do the work of a wrench on the weighted mean deflection."""
    share = weights / weights.sum()
    J = sum(w * skew(arm).T @ skew(arm) for w, arm in zip(share, arms, strict=True))
    turn = np.linalg.solve(J, wrench[3:])
    return np.asarray(share[:, None] * (wrench[:3] + np.cross(turn, arms)))


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> FieldFile:
    """The result of six unit loads on the tip face, with the deck's sets, in millimetres."""
    folder = tmp_path_factory.mktemp("cantilever")
    nodes, cells = mesh()
    blank = FieldFile(
        folder,
        "made",
        np.arange(len(nodes)),
        nodes,
        {"none": 0 * nodes},
        {},
        {"hexahedron20": cells},
    )
    tip = select(blank, Layer((LENGTH, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0))
    weights = area_weights(blank, tip).values
    arms = nodes[tip.rows] - TIP
    wrenches = np.diag([FORCE] * 3 + [MOMENT] * 3)
    loads = []
    for wrench in wrenches:
        forces = np.zeros_like(nodes)
        forces[tip.rows] = spread(arms, weights, wrench)
        loads.append(forces)
    run_calculix(folder, "beam", deck(nodes, cells, loads))
    file = read_field_file(folder / "beam.frd")
    return with_node_sets(file, read_node_sets(folder / "beam.inp"))


@pytest.fixture(scope="module")
def identified(solved: FieldFile) -> Identified:
    """The compliance at the centre of the tip face, in SI."""
    file = solved.scaled(1e-3)
    tip = select(file, InSet("TIP"))
    field = field_of(file, tip, weights=area_weights(file, tip).values)
    wrenches = np.diag([FORCE] * 3 + [1e-3 * MOMENT] * 3)
    return identify(field, wrenches, 1e-3 * TIP)


def theory() -> Array:
    steel = Material("steel", E=1e6 * E, nu=NU, density=7850.0)
    return beam_compliance(1e-3 * LENGTH, rectangle(1e-3 * SIDE, 1e-3 * SIDE), steel)


def test_the_file_holds_what_was_solved(solved: FieldFile) -> None:
    nodes, cells = mesh()
    assert list(solved.cases) == [f"step {n}" for n in range(1, 7)]
    np.testing.assert_allclose(solved.points, nodes, rtol=1e-5, atol=1e-9)
    np.testing.assert_array_equal(solved.facets["hexahedron20"], cells + 1)
    assert set(solved.sets) == {"ALL", "BASE", "TIP"}


def test_area_and_volume_of_the_beam(solved: FieldFile) -> None:
    tip = area_weights(solved, select(solved, InSet("TIP")))
    assert tip.measure == pytest.approx(SIDE**2)
    assert volume_weights(solved, select(solved)).measure == pytest.approx(LENGTH * SIDE**2)


def test_compliance_against_beam_theory(identified: Identified) -> None:
    """Within 0.1 %: theory is 0.05 % away from the clamped solid, the mesh 0.07 % in torsion."""
    k, expected = identified.compliance, theory()
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(k / scale, expected / scale, rtol=0, atol=1e-3)
    # The clamp is stiffer than theory, and elements that hold together come from below.
    assert (np.diag(k) < np.diag(expected)).all()


def test_compliance_is_symmetric(identified: Identified) -> None:
    """Loads spread as deflections are read: Maxwell's theorem, to the digits of the text."""
    k = identified.compliance
    scale = np.sqrt(np.outer(np.diag(k), np.diag(k)))
    np.testing.assert_allclose(k / scale, k.T / scale, rtol=0, atol=5e-6)
