"""The comparison with CalculiX: what its figures are made of."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.fea import calculix
from benchmarks.fea.convergence import errors, reach
from benchmarks.fea.parts import CASES

from stiffkit.fea import MeshSettings, Part, PartMesh, is_installed, mesh_part
from stiffkit.spatial.rotation import Array

UNKNOWNS = np.array([1e4, 2e4, 4e4, 8e4])
ERRORS = 0.1 * (UNKNOWNS / 1e4) ** -0.7
SECONDS = 2.0 * (UNKNOWNS / 1e4) ** 1.5

needs_netgen = pytest.mark.skipif(not is_installed(), reason="NGSolve is not installed")


@pytest.mark.parametrize("target", [0.07, 0.03])
def test_between_meshes_powers_are_interpolated(target: float) -> None:
    reached = reach(UNKNOWNS, ERRORS, SECONDS, target)
    factor = (0.1 / target) ** (1 / 0.7)
    assert reached.unknowns == pytest.approx(1e4 * factor)
    assert reached.cpu == pytest.approx(2.0 * factor**1.5)
    assert not reached.extrapolated


def test_beyond_the_finest_mesh_it_is_extrapolated_and_said_so() -> None:
    reached = reach(UNKNOWNS, ERRORS, SECONDS, 0.001)
    factor = 100.0 ** (1 / 0.7)
    assert reached.unknowns == pytest.approx(1e4 * factor)
    assert reached.cpu == pytest.approx(2.0 * factor**1.5)
    assert reached.extrapolated


def test_a_coarsest_mesh_that_is_good_enough_is_taken() -> None:
    reached = reach(UNKNOWNS, ERRORS, SECONDS, 0.2)
    assert (reached.unknowns, reached.cpu) == (1e4, 2.0)


def test_errors_that_do_not_fall_are_never_small_enough() -> None:
    assert reach(UNKNOWNS, ERRORS[::-1], SECONDS, 0.001).cpu == np.inf


def test_error_over_wrenches_bounds_that_of_the_elements() -> None:
    reference = np.diag([1.0, 4.0, 9.0, 1e-4, 4e-4, 9e-4])
    D = np.zeros((6, 6))
    D[1, 1] = 0.04
    D[0, 2] = D[2, 0] = 0.06
    found = errors(reference + D, reference)
    assert found.elements == pytest.approx(0.02)
    assert found.wrenches == pytest.approx(0.02)
    D[0, 0] = 0.02
    assert errors(reference + D, reference).wrenches > 0.03


def test_columns_are_read_from_what_calculix_prints() -> None:
    block = """
 displacements (vx,vy,vz) for set READING and time  0.1000000E+01

      8524  4.998429E-08  2.862048E-11  5.297785E-14
      8525  8.247010E-13 -8.458873E-16  2.939073E-11
"""
    columns = calculix.read_columns(block + block)
    assert columns.shape == (6, 2)
    np.testing.assert_array_equal(columns[:3, 1], [4.998429e-08, 2.862048e-11, 5.297785e-14])
    assert columns[4, 0] == -8.458873e-16


def residual(equation: list[calculix.Term], displacements: Array) -> float:
    terms = np.array([value * displacements[i - 1, axis - 1] for i, axis, value in equation])
    return float(abs(terms.sum()) / np.abs(terms).max())


@pytest.fixture(scope="module")
def cantilever() -> Part:
    return CASES["cantilever"].build()


@pytest.fixture(scope="module")
def mesh(cantilever: Part) -> PartMesh:
    return mesh_part(cantilever, MeshSettings(0.05))


@needs_netgen
@pytest.mark.parametrize("loads_on_unknowns", [False, True])
@pytest.mark.parametrize("kind", ["average", "rigid"])
def test_the_tip_moves_with_its_twist(
    cantilever: Part, mesh: PartMesh, kind: str, loads_on_unknowns: bool
) -> None:
    """A rigid motion of all nodes satisfies the equations with just that twist."""
    tip = CASES["cantilever"].ports(cantilever, kind)[1]
    twist = np.array([0.3, -0.2, 0.5, 0.7, 0.4, -0.6])
    moved = twist[:3] + np.cross(twist[3:], mesh.points - tip.point)
    everything = np.vstack([moved, twist.reshape(2, 3)])
    found = calculix.equations(mesh, tip, loads_on_unknowns=loads_on_unknowns)
    assert max(residual(equation, everything) for equation in found) < 1e-12
    eliminated = {equation[0][:2] for equation in found}
    assert len(eliminated) == len(found)
    on_twist = {node > len(mesh.points) for node, _ in eliminated}
    assert on_twist == ({False} if loads_on_unknowns or tip.is_rigid else {True})


@needs_netgen
def test_the_six_loads_are_given_in_each_way(cantilever: Part, mesh: PartMesh) -> None:
    ports = CASES["cantilever"].ports(cantilever)
    decks = {way: calculix.deck(mesh, ports, way) for way in calculix.WAYS}
    steps = {way: text.count("*STEP\n") for way, text in decks.items()}
    assert steps == {"read": 1, "one step": 1, "six steps": 6, "Green": 1}
    # A density would make Green functions those of a vibration.
    assert "*DENSITY" not in decks["Green"]
    # CalculiX reads no more than twenty characters of a number.
    numbers = [word for line in decks["Green"].splitlines() for word in line.split(",")]
    assert max(len(word.strip()) for word in numbers) <= 20
