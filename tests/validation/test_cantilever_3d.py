"""A clamped bar of 1000 x 10 x 10 mm, three-dimensional, against the theory of beams.

The bar is that of A. Pashkevich, A. Klimchik, D. Chablat, "Accuracy improvement for stiffness
modeling of parallel manipulators", 42nd CIRP Conference on Manufacturing Systems, 2009, section 4:
E = 2e5 N/mm^2, nu = 0.266. Axial: L/EA; bending: L^3/3EI, L^2/2EI, L/EI; torsion: L/GJ with J of a
square, 0.1405770 b^4 (S. Timoshenko, J. Goodier, Theory of Elasticity, section 109).
"""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("netgen.occ")

from stiffkit.fea import (
    MeshSettings,
    Part,
    PartMesh,
    Port,
    SolveSettings,
    mesh_part,
    named_ports,
    reduce_part,
)
from stiffkit.fea.adapt import AdaptSettings, adapt
from stiffkit.fea.estimate import relative_difference
from stiffkit.fea.square_bar import square_bar
from stiffkit.link import Material
from stiffkit.spatial.rotation import Array
from stiffkit.spatial.twist import twist_shift

L, B = 1.0, 0.01
STEEL = Material("steel of the paper", E=2e11, nu=0.266, density=7800.0)
A, I2, J = B**2, B**4 / 12.0, 0.1405770 * B**4


@pytest.fixture(scope="module")
def bar() -> Part:
    return square_bar(L, B)


@pytest.fixture(scope="module")
def mesh(bar: Part) -> PartMesh:
    return mesh_part(bar, MeshSettings(0.02))


def ports(bar: Part, base: str, tip: str) -> tuple[Port, ...]:
    return named_ports(bar, {"base": base, "tip": tip})


def compliance(bar: Part, mesh: PartMesh, order: int, base: str = "clamped") -> Array:
    settings = SolveSettings(order=order, threads=1)
    return reduce_part(mesh, ports(bar, base, "average"), [STEEL], settings).compliance


def beam_compliance() -> Array:
    k = np.diag(
        [
            L / STEEL.E / A,
            L**3 / 3 / STEEL.E / I2,
            L**3 / 3 / STEEL.E / I2,
            L / STEEL.G / J,
            L / STEEL.E / I2,
            L / STEEL.E / I2,
        ]
    )
    k[1, 5] = k[5, 1] = L**2 / 2 / STEEL.E / I2
    k[2, 4] = k[4, 2] = -(L**2) / 2 / STEEL.E / I2
    return k


def test_a_free_section_gives_beam_theory(bar: Part, mesh: PartMesh) -> None:
    # Read and held by averages, nothing hinders the contraction across: Saint-Venant's solution,
    # but for shear (E/G (b/L)^2, 1e-4 of the bending) and for how the ends are loaded.
    k, wanted = compliance(bar, mesh, 4, "average"), beam_compliance()
    scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    assert k[0, 0] == pytest.approx(wanted[0, 0], rel=1e-6)
    assert k[1, 1] == pytest.approx(wanted[1, 1], rel=2e-4)
    assert k[5, 5] == pytest.approx(wanted[5, 5], rel=1e-6)
    assert k[3, 3] == pytest.approx(wanted[3, 3], rel=3e-3)
    assert np.abs((k - wanted) / scale).max() < 3e-3


def test_clamping_stiffens_by_what_it_holds_back(bar: Part, mesh: PartMesh) -> None:
    # Within a width of the clamped end the section cannot contract: some 0.1 % here.
    k, wanted = compliance(bar, mesh, 5), beam_compliance()
    for i in (0, 1, 2, 4, 5):
        assert 0.999 < k[i, i] / wanted[i, i] < 1.0
    assert 0.998 < k[3, 3] / wanted[3, 3] < 1.0


def test_zeros_are_zero(bar: Part, mesh: PartMesh) -> None:
    k = compliance(bar, mesh, 5)
    scaled = np.abs(k) / np.sqrt(np.outer(np.diag(k), np.diag(k)))
    zero = beam_compliance() == 0.0
    assert int(zero.sum()) == 26
    assert scaled[zero].max() < 1e-4


def test_the_diagonal_converges_from_below(bar: Part, mesh: PartMesh) -> None:
    diagonals = [np.diag(compliance(bar, mesh, order)) for order in (1, 2, 3, 4, 5)]
    for coarse, fine in pairwise(diagonals):
        assert np.all(coarse <= fine * (1.0 + 1e-7))


@pytest.mark.parametrize(("base", "tip"), [("clamped", "average"), ("average", "rigid")])
def test_symmetry_and_rigid_motions(bar: Part, mesh: PartMesh, base: str, tip: str) -> None:
    both = ports(bar, base, tip)
    model = reduce_part(mesh, both, [STEEL], SolveSettings(order=3, threads=1))
    assert np.array_equal(model.compliance, model.compliance.T)
    K = model.stiffness
    assert np.abs(K - K.T).max() <= 1e-9 * np.abs(K).max()
    T = np.vstack([np.eye(6), twist_shift(both[1].point - both[0].point)])
    assert np.abs(K @ T).max() < 1e-8 * np.abs(K).max()
    mass, centre, inertia = bar.mass_properties(STEEL.density)
    M = T.T @ model.modes(0)[1] @ T
    arm = centre - both[0].point
    assert M[0, 0] == pytest.approx(mass, rel=1e-9)
    wanted = inertia + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(M[3:, 3:], wanted, atol=1e-9 * wanted.max())


def test_modes_with_both_ends_held_are_those_of_a_clamped_beam(bar: Part, mesh: PartMesh) -> None:
    model = reduce_part(mesh, ports(bar, "rigid", "rigid"), [STEEL], SolveSettings(4, threads=1))
    found = np.sqrt(model.modes(4)[0])
    # Roots of cosh x cos x = 1; each twice, for both directions.
    roots = np.array([4.730041, 4.730041, 7.853205, 7.853205])
    wanted = roots**2 * np.sqrt(STEEL.E * I2 / STEEL.density / A / L**4)
    np.testing.assert_allclose(found, wanted, rtol=2e-3)


def test_the_loop_reaches_its_tolerance_and_is_right(bar: Part) -> None:
    settings = AdaptSettings(mesh=MeshSettings(0.02), solve=SolveSettings(threads=1))
    both = ports(bar, "clamped", "average")
    result = adapt(bar, both, [STEEL], settings)
    assert result.converged
    fine = mesh_part(bar, MeshSettings(0.008))
    reference = reduce_part(fine, both, [STEEL], SolveSettings(order=5, threads=1)).compliance
    error = relative_difference(result.model.compliance - reference, reference)
    assert error < 1e-3
    worst = np.abs(np.diag(result.model.compliance) / np.diag(reference) - 1.0).max()
    assert worst < 1e-3


def test_it_costs_less_than_a_second(bar: Part, mesh: PartMesh) -> None:
    both = ports(bar, "clamped", "average")
    reduce_part(mesh, both, [STEEL], SolveSettings(order=2, threads=1))
    start = time.process_time()
    reduce_part(mesh, both, [STEEL], SolveSettings(order=5, threads=1))
    # The processor's time: other programs may share the cores.
    assert time.process_time() - start < 2.0
