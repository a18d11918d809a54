import math
from typing import Any

import numpy as np
import pytest

from stiffkit.link import (
    MATERIALS,
    beam_compliance,
    beam_inertia,
    check_compliance,
    check_inertia,
    doubts_compliance,
    doubts_inertia,
    symmetrize,
    tube,
)
from stiffkit.spatial.rotation import Array

BEAM = beam_compliance(0.3, tube(0.04, 0.004), MATERIALS["steel"])
TO_MM = np.diag([1e3, 1e3, 1e3, 1.0, 1.0, 1.0]) @ np.diag([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3])


def with_entry(row: int, column: int, value: float) -> Array:
    k = BEAM.copy()
    k[row - 1, column - 1] = k[column - 1, row - 1] = value
    return k


def test_a_beam_has_neither_faults_nor_doubts() -> None:
    assert check_compliance(BEAM) == []
    assert doubts_compliance(BEAM) == []


def test_integers_and_lists_are_fine() -> None:
    assert check_compliance(np.eye(6, dtype=int).tolist()) == []


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (np.eye(5), "must be 6x6 and is 5x5"),
        (np.ones(6), "must be 6x6 and is 6"),
        (3.0, "must be 6x6 and is a single number"),
        ([[1, 2], [3]], "not a 6x6 matrix of numbers"),
        ([["a"] * 6] * 6, "not a 6x6 matrix of numbers"),
    ],
)
def test_shape(matrix: Any, words: str) -> None:
    (fault,) = check_compliance(matrix)
    assert words in fault


def test_every_entry_that_is_not_finite_is_named() -> None:
    k = BEAM.copy()
    k[0, 3], k[5, 5] = math.nan, math.inf
    assert check_compliance(k) == [
        "entry 1,4 is nan and must be a finite number",
        "entry 6,6 is inf and must be a finite number",
    ]


def test_diagonal_must_be_positive() -> None:
    (fault,) = check_compliance(with_entry(4, 4, -1e-7))
    assert fault == "not positive definite: entry 4,4 = -1e-07 must be positive"


def test_asymmetry_names_the_worst_pair_in_relative_terms() -> None:
    k = BEAM.copy()
    k[1, 5] *= 1.01
    k[2, 4] *= 1.001
    (fault,) = check_compliance(k)
    assert fault.startswith(f"not symmetric: entry 2,6 = {k[1, 5]:.6g} and entry 6,2 = ")
    assert "the worst of 2 pairs" in fault
    assert "symmetrize" in fault
    assert check_compliance(symmetrize(k)) == []


def test_rounding_is_not_asymmetry() -> None:
    k = BEAM.copy()
    k[1, 5] *= 1 + 1e-8
    assert check_compliance(k) == []


def test_a_minor_that_cannot_stand_says_what_would() -> None:
    k = with_entry(2, 6, 10 * BEAM[1, 5])
    (fault,) = check_compliance(k)
    a, b = k[1, 1], k[5, 5]
    assert f"2,2 = {a:.3g}, 6,6 = {b:.3g} and 2,6 = {k[1, 5]:.3g} cannot stand together" in fault
    bound = math.sqrt(a * b)
    assert f"|k26| must stay below sqrt(k22 k66) = {bound:.3g}" in fault
    k[1, 5] = k[5, 1] = 0.99 * bound
    assert check_compliance(k) == []


def test_other_broken_minors_are_named_too() -> None:
    k = with_entry(2, 6, 10 * BEAM[1, 5])
    k[0, 3] = k[3, 0] = 2 * math.sqrt(k[0, 0] * k[3, 3])
    (fault,) = check_compliance(k)
    assert f"and 2,6 = {k[1, 5]:.3g} cannot" in fault
    assert "the same goes for 1,4;" in fault


def test_when_every_minor_stands_the_load_of_negative_energy_is_named() -> None:
    k = np.eye(6)
    for i, j in ((0, 1), (1, 2), (0, 2)):
        k[i, j] = k[j, i] = -0.6
    (fault,) = check_compliance(k)
    assert "under the load Fx = 1, Fy = 1, Fz = 1 the energy is -0.3" in fault


def test_units_do_not_matter_to_the_checks() -> None:
    assert check_compliance(TO_MM @ BEAM @ TO_MM) == []
    wrong = with_entry(2, 6, 10 * BEAM[1, 5])
    (fault,) = check_compliance(TO_MM @ wrong @ TO_MM)
    assert "cannot stand together" in fault


def test_a_singular_matrix_is_not_definite() -> None:
    k = np.eye(6)
    k[0, 1] = k[1, 0] = 1.0
    (fault,) = check_compliance(k)
    assert "1,1 = 1, 2,2 = 1 and 1,2 = 1 cannot stand together" in fault


def test_millimetres_are_doubted() -> None:
    # mm/N and rad/(N mm) read as m/N and rad/(N m).
    in_mm = np.diag([1e3] * 3 + [1.0] * 3) @ BEAM @ np.diag([1.0] * 3 + [1e-3] * 3)
    (doubt,) = doubts_compliance(in_mm)
    assert "levers" in doubt
    assert "rad/(N mm)" in doubt


def test_single_entries_are_doubted() -> None:
    doubts = doubts_compliance(BEAM * 1e9)
    assert any("entry 2,2" in doubt and "m/N" in doubt for doubt in doubts)
    doubts = doubts_compliance(BEAM * 1e-9)
    assert any("entry 1,1" in doubt for doubt in doubts)


BODY = beam_inertia(0.3, tube(0.04, 0.004), MATERIALS["steel"])


def test_a_beam_is_a_body() -> None:
    mass, _, inertia = BODY
    assert check_inertia(mass, inertia) == []
    assert doubts_inertia(mass, inertia) == []


@pytest.mark.parametrize(
    "inertia",
    [
        np.zeros((3, 3)),
        np.diag([0.0, 2.0, 2.0]),
        np.diag([1.0, 2.0, 3.0]),
        # A plate whose moments were rounded to three digits.
        np.diag([0.333, 0.333, 0.667]),
    ],
    ids=["point", "rod", "plate", "rounded plate"],
)
def test_limits_are_bodies(inertia: Any) -> None:
    assert check_inertia(1.0, inertia) == []


@pytest.mark.parametrize("mass", [0.0, -1.0, math.nan, math.inf])
def test_mass_must_be_positive(mass: float) -> None:
    (fault,) = check_inertia(mass, np.eye(3))
    assert f"the mass is {mass:g} kg" in fault


def test_inertia_shape_and_symmetry() -> None:
    assert check_inertia(1.0, np.eye(2)) == ["the matrix must be 3x3 and is 2x2"]
    J = np.eye(3)
    J[0, 2] = 0.1
    (fault,) = check_inertia(1.0, J)
    assert fault.startswith("not symmetric: entry 1,3 = 0.1 and entry 3,1 = 0 do not agree")


def test_triangle_inequality_on_the_diagonal() -> None:
    (fault,) = check_inertia(1.0, np.diag([1.0, 1.5, 3.0]))
    assert "principal moments 1, 1.5 and 3 kg m^2" in fault
    assert "exceeds the sum of the others by 0.5" in fault
    assert "entry 3,3 = 3 alone" in fault


def test_negative_principal_moment() -> None:
    (fault,) = check_inertia(1.0, [[1.0, 0.0, 0.0], [0.0, 1.0, 1.5], [0.0, 1.5, 1.0]])
    assert "principal moments -0.5, 1 and 2.5" in fault
    assert "none may be negative" in fault
    assert "entry 2,3 = 1.5 is too large for this diagonal, which allows at most 0.5" in fault


def test_inertia_in_millimetres_is_doubted() -> None:
    mass, _, inertia = BODY
    (doubt,) = doubts_inertia(mass, inertia * 1e6)
    assert "kg mm^2" in doubt
    assert doubts_inertia(1.0, np.zeros((3, 3))) == []
