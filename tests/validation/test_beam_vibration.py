"""Beams in closed form: natural frequencies, and how fast the elements reach them.

R. D. Blevins, "Formulas for Natural Frequency and Mode Shape", 1979, table 8-1: the frequencies of
a slender uniform beam are ``lambda^2/(2 pi L^2) sqrt(EI/m)``. W. Weaver, S. P. Timoshenko,
D. H. Young, "Vibration Problems in Engineering", 1990, section 5.11, for a mass at the tip.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import brentq

from stiffkit.link import Line
from stiffkit.link.superelement import (
    Superelement,
    consistent_superelement,
    lumped_superelement,
)

Array = NDArray[np.float64]
Maker = Callable[[Line, int, int | None], Superelement]

LENGTH, MASS, EI = 1.2, 3.0, 800.0  # m, kg, N m^2

# In the plane x, y the ports move along y and turn about z: base (1, 5), then tip (7, 11).
PLANE = [1, 5, 7, 11]

# Table 8-1 of Blevins: what is held, rigid motions, lambda of the first three modes.
SUPPORTS: dict[str, tuple[list[int], int, list[float]]] = {
    "cantilever": ([1, 5], 0, [1.87510407, 4.69409113, 7.85475744]),
    "clamped-pinned": ([1, 5, 7], 0, [3.92660231, 7.06858275, 10.21017612]),
    "free-free": ([], 2, [4.73004074, 7.85320462, 10.9956078]),
}


def beam() -> Line:
    """A beam of Euler and Bernoulli, without rotary inertia across."""
    flexibility = np.diag([1e-9, 0.0, 0.0, 1e-6, 1.0 / (4.0 * EI), 1.0 / EI])
    tip = np.array([LENGTH, 0.0, 0.0])
    rotary = np.diag([1e-3, 0.0, 0.0])
    return Line(tip, flexibility, MASS / LENGTH, MASS / LENGTH, rotary, "beam")


def frequencies(
    element: Superelement, held: list[int], n_rigid: int = 0, tip_mass: float = 0.0
) -> Array:
    """Frequencies, Hz, of bending in the plane x, y, lowest first."""
    size = element.mass.shape[0]
    relative = np.hstack([-(np.eye(6) + LENGTH * beam().carry()), np.eye(6)])
    K = np.zeros((size, size))
    K[:12, :12] = relative.T @ np.linalg.solve(element.compliance, relative)
    K[12:, 12:] = np.diag(element.mode_stiffness)
    M = element.mass.copy()
    M[7, 7] += tip_mass
    along_y = np.abs(element.shapes[1::6, 12:]).max(axis=0)
    bending = 12 + np.flatnonzero(along_y > 0.01 * np.abs(element.shapes[:, 12:]).max(axis=0))
    kept = [i for i in [*PLANE, *bending] if i not in held]
    values = eigh(K[np.ix_(kept, kept)], M[np.ix_(kept, kept)], eigvals_only=True)
    return np.asarray(np.sqrt(values[n_rigid:]) / (2.0 * np.pi))


def closed_form(lambdas: Array | list[float]) -> Array:
    """Frequencies, Hz."""
    unit = np.sqrt(EI / (MASS / LENGTH)) / (2 * np.pi * LENGTH**2)
    return np.asarray(unit * np.square(lambdas))


def errors(make: Maker, n: int, support: str) -> Array:
    """Relative errors of the first three frequencies with n elements."""
    held, n_rigid, lambdas = SUPPORTS[support]
    found = frequencies(make(beam(), n, None), held, n_rigid)[:3]
    return np.asarray(found / closed_form(lambdas) - 1.0)


@pytest.mark.parametrize("support", SUPPORTS)
def test_consistent_elements_come_from_above_with_order_four(support: str) -> None:
    coarse, fine = (errors(consistent_superelement, n, support) for n in (6, 12))
    assert (coarse > fine).all()
    assert (fine > 0.0).all()
    assert fine[0] < 2e-5
    assert np.log2(coarse / fine).min() > 3.6
    # Where the mesh is fine enough for the mode, the order is reached.
    finer = errors(consistent_superelement, 24, support)
    assert np.log2(fine[1:] / finer[1:]) == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize("support", SUPPORTS)
def test_rigid_elements_have_order_two(support: str) -> None:
    # n rigid elements stand on n - 1 pieces.
    coarse, fine = (np.abs(errors(lumped_superelement, n, support)) for n in (13, 25))
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.15)


def test_twenty_rigid_elements_are_within_one_percent() -> None:
    # Briot 2009, section 3.2: "The value found with the lumped model, by modeling the beam with 20
    # elements, is inferior to 1% to the theoretical result." The first three modes are.
    assert np.abs(errors(lumped_superelement, 20, "cantilever")).max() < 0.01
    assert abs(errors(lumped_superelement, 20, "cantilever")[0]) < 2e-4


@pytest.mark.parametrize("support", SUPPORTS)
def test_rigid_elements_converge_to_consistent_ones(support: str) -> None:
    held, n_rigid, _ = SUPPORTS[support]
    exact = frequencies(consistent_superelement(beam(), 20, None), held, n_rigid)[:3]
    gaps = [
        np.abs(frequencies(lumped_superelement(beam(), n, None), held, n_rigid)[:3] / exact - 1.0)
        for n in (10, 20, 40)
    ]
    assert (gaps[0] > gaps[1]).all()
    assert (gaps[1] > gaps[2]).all()
    assert gaps[2].max() < 4e-3


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_cantilever_with_a_mass_at_its_tip(ratio: float) -> None:
    # 1 + cos l cosh l = r l (sin l cosh l - cos l sinh l), with r the tip's mass over the beam's.
    def characteristic(x: float) -> float:
        c, s, C, S = np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)
        return float((1 + c * C - ratio * x * (s * C - c * S)) / C)

    lambdas = [brentq(characteristic, *ends) for ends in ((0.1, 1.9), (3.5, 4.7), (6.8, 7.86))]
    element = consistent_superelement(beam(), 20, None)
    found = frequencies(element, [1, 5], tip_mass=ratio * MASS)[:3]
    assert found == pytest.approx(closed_form(lambdas), rel=2e-5)


def test_few_internal_modes_are_enough_for_the_lowest_frequencies() -> None:
    # The reduction of Craig and Bampton: 8 elements and 6 modes with held ports, as by default.
    held, _, lambdas = SUPPORTS["cantilever"]
    found = frequencies(consistent_superelement(beam(), 8, 6), held)[:2]
    assert found == pytest.approx(closed_form(lambdas)[:2], rel=2e-3)
    assert (found > closed_form(lambdas)[:2]).all()
