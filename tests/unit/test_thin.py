"""Fewer postures to draw: evenly picked, ends and middle among them, and branches along."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic_map import grid, synthetic_map  # type: ignore[import-not-found]

from stiffkit.plots.sweep import sweep_of
from stiffkit.plots.thin import thinned


@pytest.mark.parametrize("counts", [{"x": 201, "y": 101}, {"x": 41, "y": 31, "z": 21}, {"x": 999}])
def test_a_grid_keeps_its_ends_and_its_middle(counts: dict[str, int]) -> None:
    whole = synthetic_map(grid(**counts))
    few = thinned(whole, 500)
    assert np.prod(sweep_of(few).shape) <= 500
    assert np.prod(sweep_of(few).shape) > 300
    for axis in counts:
        values, all_values = few[axis].values, whole[axis].values
        middle = all_values[len(all_values) // 2]
        assert values[0] == all_values[0]
        assert values[-1] == all_values[-1]
        assert middle in values
        steps = np.diff(values)
        assert steps.max() <= 2.0 * steps.min() + 1e-12


def test_values_are_those_of_the_postures_kept() -> None:
    whole = synthetic_map(grid(x=31, y=41))
    few = thinned(whole, 200)
    name = "stiffness_translation_min"
    np.testing.assert_array_equal(few[name], whole[name].sel(x=few["x"], y=few["y"]))


def test_what_is_small_enough_stays() -> None:
    whole = synthetic_map(grid(x=11, y=11))
    assert sweep_of(thinned(whole)).shape == (11, 11)
    assert "compliance" not in thinned(whole)


def test_a_list_of_points() -> None:
    angle = np.linspace(0.0, 2.0, 1000)
    whole = synthetic_map({"x": np.cos(angle), "y": np.sin(angle)}, points=True)
    few = thinned(whole, 100)
    assert sweep_of(few).count <= 100
    assert few["x"].values[-1] == whole["x"].values[-1]
