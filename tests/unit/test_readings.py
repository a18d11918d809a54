"""What is read off compliances: against LAPACK, in all three modes, and at the edges."""

from __future__ import annotations

import importlib.util
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.compiled import BatchFunction
from stiffkit.compiled.function import Backend
from stiffkit.stiffness import DEFLECTIONS, STIFFNESSES, full_matrices, lower_triangles, readings

Array = NDArray[np.float64]
WRENCHES = np.array([[1000.0, 0, 0, 0, 0, 0], [0, -3.0, 7.0, 0, 2.0, 0], [0, 0, 0, 0, 0, 0]])
N = 40
heyoka_too = pytest.param(
    "heyoka",
    marks=pytest.mark.skipif(
        importlib.util.find_spec("heyoka") is None, reason="heyoka is not installed"
    ),
)


def compliances() -> Array:
    """Return lower triangles (21, N) of compliances over many decades, SI."""
    rng = np.random.default_rng(3)
    half = rng.normal(size=(N, 6, 6)) * 10.0 ** rng.uniform(-7.0, -3.0, size=(N, 1, 1))
    return lower_triangles((half @ half.transpose(0, 2, 1)).transpose(1, 2, 0))


@pytest.mark.parametrize("backend", ["numpy", heyoka_too])
def test_against_eigenvalues_and_products(backend: Backend) -> None:
    lower = compliances()
    found = BatchFunction(readings(WRENCHES), backend)(lower)
    k = full_matrices(lower)
    for row, block in ((0, slice(0, 3)), (2, slice(3, 6))):
        values = np.linalg.eigvalsh(k[block, block].transpose(2, 0, 1))
        np.testing.assert_allclose(found[row], 1.0 / values[:, 2], rtol=1e-12)
        # The closed form is good to rounding of the largest eigenvalue.
        error = np.abs(1.0 / found[row + 1] - values[:, 0]) / values[:, 2]
        assert error.max() < 1e-13
    per_load = 6 + len(DEFLECTIONS)
    for i, wrench in enumerate(WRENCHES):
        rows = found[len(STIFFNESSES) + i * per_load :][:per_load]
        d = np.einsum("ijn,j->in", k, wrench)
        np.testing.assert_allclose(rows[:6], d, rtol=1e-11, atol=1e-11 * np.abs(d).max())
        np.testing.assert_allclose(rows[6], np.linalg.norm(d[:3], axis=0), rtol=1e-12)
        np.testing.assert_allclose(rows[7], np.hypot(d[0], d[1]), rtol=1e-12)
        np.testing.assert_allclose(rows[8], np.abs(d[2]), rtol=1e-9)
        np.testing.assert_allclose(rows[9], np.linalg.norm(d[3:], axis=0), rtol=1e-12)


@pytest.mark.parametrize("backend", ["numpy", heyoka_too])
@pytest.mark.parametrize("n", [1, 5])
def test_directions_that_do_not_yield_and_no_answer(backend: Backend, n: int) -> None:
    kernel = readings(WRENCHES[:1])
    one_way = lower_triangles(np.repeat(np.diag([2e-9, 0, 0, 0, 0, 0])[..., None], n, axis=2))
    found = BatchFunction(kernel, backend)(one_way)
    np.testing.assert_allclose(found[0], 5e8)
    assert (found[1] == math.inf).all()
    assert (found[2] == math.inf).all()  # rigid against any moment
    assert (found[3] == math.inf).all()
    assert np.isnan(BatchFunction(kernel, backend)(np.full((21, n), np.nan))).all()
