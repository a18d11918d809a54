"""Derivatives of kernels: recorded scalars, compiled expressions, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from stiffkit.compiled import AdjointFunction, Backend, Constants, Kernel
from stiffkit.kinematics import Kinematics
from stiffkit.robot import load_robot
from stiffkit.smallmat import Tape, Vector, arccos, cos, magnitude, sin, sqrt, vector, where_less
from stiffkit.stiffness import Composition
from stiffkit.stiffness.slopes import as_lower, by_compliance, by_deflection

Array = NDArray[np.float64]

BACKENDS: tuple[Backend, ...] = ("numpy", "heyoka")


def made() -> Kernel:
    """Return a kernel with all that kernels are made of."""
    constants = Constants()
    constants.add("numbers", np.array([2.0, 0.0, 3.0]))

    def function(x: Vector, c: Vector) -> Vector:
        a, _, b = constants.read(c, "numbers")
        first = sin(x[0]) * a / (b - x[1]) + sqrt(x[1]) - 1.0 / x[1]
        second = where_less(x[0], x[1], cos(a * x[0]), magnitude(-x[1]) - b)
        third = arccos(0.1 * x[0]) * (2.0 - first)
        return vector([first, second, third])

    return Kernel("made", function, 2, constants, ())


def slopes_by_hand(x: Array, seeds: Array) -> Array:
    """Return the derivatives (2 + 3, N) of the kernel above, by complex steps."""
    step = 1e-30

    def outputs(x0: complex, x1: complex, a: complex, b: complex) -> Array:
        first = np.sin(x0) * a / (b - x1) + np.sqrt(x1) - 1.0 / x1
        second = np.cos(a * x0) if np.real(x0) < np.real(x1) else x1 - b
        third = (0.5 * np.pi - np.arcsin(0.1 * x0)) * (2.0 - first)
        return np.array([first, second, third])

    rows = []
    for i in range(4):
        own = []
        for column, seed in zip(x.T, seeds.T, strict=True):
            at = np.array([*column, 2.0, 3.0], dtype=complex)
            at[i] += 1j * step
            own.append(float(np.imag(seed @ outputs(*at)) / step))
        rows.append(own)
    found = np.array(rows)
    return np.concatenate([found[:3], np.zeros((1, x.shape[1])), found[3:]])


@pytest.mark.parametrize("backend", BACKENDS)
def test_derivatives_of_everything_a_kernel_does(backend: Backend) -> None:
    rng = np.random.default_rng(1)
    x, seeds = rng.uniform(0.1, 2.0, (2, 11)), rng.normal(size=(3, 11))
    kernel = made()
    found = AdjointFunction(kernel, 3, backend)(x, seeds, kernel.constants.values)
    expected = slopes_by_hand(x, seeds)
    np.testing.assert_allclose(found.inputs, expected[:2], rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(found.constants, expected[2:], rtol=1e-12, atol=1e-13)
    assert not found.constants[1].any()  # a zero belongs to the topology


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_postures(backend: Backend) -> None:
    kernel = made()
    found = AdjointFunction(kernel, 3, backend)(
        np.empty((2, 0)), np.empty((3, 0)), kernel.constants.values
    )
    assert found.inputs.shape == (2, 0)
    assert found.constants.shape == (3, 0)


def test_compiled_and_recorded_agree_on_a_robot() -> None:
    kinematics = Kinematics(load_robot("biglide"))
    kernel = Composition(kinematics.tree, kinematics.length).kernel()
    rng = np.random.default_rng(0)
    q = kinematics.home.coordinates + 0.02 * rng.normal(size=(kernel.n_inputs, 9))
    seeds = rng.normal(size=(21, 9))
    both = [
        AdjointFunction(kernel, 21, backend)(q, seeds, kernel.constants.values)
        for backend in BACKENDS
    ]
    recorded, compiled = both
    np.testing.assert_allclose(recorded.inputs, compiled.inputs, rtol=1e-10)
    # What a constant does is to be judged by its size: some derivatives are nothing but rounding.
    size = np.abs(kernel.constants.values)[:, None]
    difference = size * np.abs(recorded.constants - compiled.constants)
    assert difference.max() <= 1e-10 * (size * np.abs(recorded.constants)).max()


def test_what_a_selection_leaves_out_counts_nothing() -> None:
    tape = Tape()
    x = tape.variable(np.array([0.0, 4.0]))
    with np.errstate(divide="ignore"):
        y = where_less(x, 1.0, 2.0 * x, 1.0 / x)
    np.testing.assert_allclose(tape.gradient([(y, np.ones(2))], [x]), [[2.0, -1.0 / 16.0]])


@given(st.integers(0, 10_000))
def test_slopes_of_readings(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(6, 6))
    k = root @ root.T + 0.1 * np.eye(6)
    change = rng.normal(size=(6, 6))
    change = change + change.T
    rows, columns = np.tril_indices(6)
    lower = k[rows, columns][:, None]

    def weakest(matrix: Array) -> float:
        return float(1.0 / np.linalg.eigvalsh(matrix[:3, :3])[2])

    values = np.linalg.eigvalsh(k[:3, :3])
    if values[2] - values[1] > 0.1 * values[2]:
        step = 1e-6
        expected = (weakest(k + step * change) - weakest(k - step * change)) / (2.0 * step)
        found = by_compliance("stiffness_translation_min", lower)[:, 0] @ change[rows, columns]
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-7)
    wrench = rng.normal(size=6)
    d = k @ wrench
    slope = by_deflection("deflection_xy", d[:, None])
    expected = d[:2] @ (change @ wrench)[:2] / np.hypot(*d[:2])
    found = as_lower(slope[:, None] * wrench[None, :, None])[:, 0] @ change[rows, columns]
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-10)


def test_nothing_has_no_slope() -> None:
    deflection = np.array([[0.0, 0.0, 1e-6, 0.0, 0.0, 0.0]]).T
    assert not by_deflection("deflection_xy", deflection).any()
    np.testing.assert_allclose(by_deflection("deflection_z", deflection)[2], 1.0)
    unknown = np.full((6, 1), np.nan)
    assert np.isnan(by_deflection("deflection_xy", unknown)).all()
