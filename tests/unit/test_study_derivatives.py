"""Derivatives in the tables of long studies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.errors import FileError
from stiffkit.study.sweep import Column, StudySpec, Varied, create_study, read_study, run_study
from stiffkit.study.sweep.statistics import reduce, shares

STEP = 1e-4

COLUMNS = (
    Column("worst", "max", "deflection_translation", "push"),
    Column("typical", "mean", "deflection_translation", "push"),
    Column("p90", "percentile", "deflection_z", "lift", 90.0),
    Column("soft", "share above", "deflection_xy", "push", 2e-5),
)


def test_derivatives_are_those_of_the_table(tmp_path: Path) -> None:
    """Five values of a parameter beside each other give the middle one's by differences."""
    middle = 0.2
    near = tuple(middle * (1.0 + STEP * i) for i in (-2, -1, 0, 1, 2))
    spec = StudySpec(
        title="Arms",
        robot="five-bar",
        varied=(Varied("proximal", near, "mm"), Varied("distal", (0.37,), "mm")),
        sample=None,
        seed=0,
        postures=30,
        models=("refined", "simplified"),
        frequency_postures=0,
        columns=COLUMNS,
        derivatives=True,
    )
    assert StudySpec.from_plain(spec.plain()) == spec
    table = run_study(create_study(tmp_path / "out", spec, backend="numpy"))
    weights = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * STEP * middle)
    for column in COLUMNS[:3]:
        for model in spec.models:
            own = table[column.name].sel(model=model).values
            if not own.any():
                continue
            found = table[f"{column.name}_by_proximal"].sel(model=model)
            assert float(found[2]) == pytest.approx(weights @ own, rel=1e-6)
    assert table["worst_by_proximal"].attrs["units"] == "m/(m)"
    assert "soft_by_proximal" not in table


@pytest.mark.parametrize("statistic", ["min", "max", "mean", "percentile"])
def test_shares_are_the_derivatives_of_a_statistic(statistic: str) -> None:
    rng = np.random.default_rng(3)
    values: NDArray[np.float64] = rng.normal(size=17)
    values[[2, 9]] = np.nan
    column = Column("any", statistic, "deflection_z", "lift", 37.0)  # type: ignore[arg-type]
    change = rng.normal(size=17)
    step = 1e-7
    both = [reduce(column, (values + sign * step * change)[None])[0][0] for sign in (1.0, -1.0)]
    weights = shares(column, values)
    assert not weights[[2, 9]].any()
    assert weights @ change == pytest.approx((both[0] - both[1]) / (2.0 * step), rel=1e-6)


def test_shares_of_nothing_and_of_leaps() -> None:
    nothing = np.full(3, np.nan)
    assert not shares(Column("any", "mean", "deflection_z", "lift"), nothing).any()
    leaps = shares(Column("any", "share above", "deflection_z", "lift", 1.0), np.ones(3))
    assert np.isnan(leaps).all()


def test_a_name_that_is_taken(tmp_path: Path) -> None:
    path = tmp_path / "arms.yaml"
    path.write_text(
        "study: Arms\nrobot: five-bar\nvary:\n  base: [300 mm, 310 mm]\nderivatives: true\n"
        "results:\n  firm: {min: stiffness_translation_min}\n"
        "  firm_by_base: {max: stiffness_translation_min}\n",
        encoding="utf-8",
    )
    with pytest.raises(FileError, match="'firm_by_base'"):
        read_study(path)
