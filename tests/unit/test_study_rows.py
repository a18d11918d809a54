"""Rows of long studies: the same numbers as a map of each geometry, whatever stands beside it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.compiled import Backend, heyoka_available
from stiffkit.robot import RobotFile, load_robot
from stiffkit.study import Analysis, map_workspace
from stiffkit.study.sweep import Column, StudySpec, Varied
from stiffkit.study.sweep.sampling import parameter_values
from stiffkit.study.sweep.statistics import reduce
from stiffkit.study.sweep.work import Job, Prepared, compute_chunk, prepare
from stiffkit.units import Value, parse_quantity

Array = NDArray[np.float64]

BACKEND: Backend = "heyoka" if heyoka_available() else "numpy"

COLUMNS = (
    Column("weakest", "min", "stiffness_translation_min"),
    Column("worst", "max", "deflection_translation", "push"),
    Column("mean", "mean", "stiffness_rotation_min"),
    Column("p95", "percentile", "deflection_z", "lift", 95.0),
    Column("soft", "share above", "deflection_xy", "push", 2e-5),
    Column("firm", "share below", "deflection_xy", "push", 2e-5),
)


def five_bar(**changes: Any) -> StudySpec:
    """Geometries of a five-bar, some of which reach only a part of their workspace."""
    spec = StudySpec(
        title="Arms",
        robot="five-bar",
        varied=(
            Varied("proximal", (0.15, 0.2, 0.26), "mm"),
            Varied("distal", (0.28, 0.35, 0.42), "mm"),
        ),
        sample=None,
        seed=0,
        postures=60,
        models=("refined", "simplified"),
        frequency_postures=0,
        columns=COLUMNS,
    )
    return replace(spec, **changes)


@cache
def prepared(spec: StudySpec) -> Prepared:
    return prepare(spec, BACKEND)


Rows = dict[str, NDArray[Any]]


def rows_of(spec: StudySpec, numbers: list[int]) -> Rows:
    ready = prepared(spec)
    job = Job(str(hash(spec)), spec.plain(), ready.robot_hash, BACKEND)
    values = parameter_values(spec, np.array(numbers))
    return compute_chunk(job.plain(), ready.reference, values)


def mapped(spec: StudySpec, number: int) -> Any:
    """Return the map of one geometry, on the grid that the study has."""
    values = parameter_values(spec, np.array([number]))[:, 0]
    given = {v.name: float(x) for v, x in zip(spec.varied, values, strict=True)}
    robot = load_robot(spec.robot, given)
    counts = dict(zip(prepared(spec).swept, prepared(spec).shape, strict=True))
    robot = replace(robot, workspace=replace(robot.workspace, counts=counts))
    return map_workspace(robot, models=spec.models, frequencies=False)


def statistic(column: Column, values: Array) -> float:
    known = values[~np.isnan(values)]
    match column.statistic:
        case "min":
            return float(known.min())
        case "max":
            return float(known.max())
        case "mean":
            return float(known.mean())
        case "percentile":
            return float(np.percentile(known, column.value or 0.0))
        case "share above":
            return float(np.mean(known > (column.value or 0.0)))
    return float(np.mean(known < (column.value or 0.0)))


@pytest.mark.parametrize("number", [0, 2, 4, 8])
def test_a_row_is_the_reduction_of_that_geometrys_map(number: int) -> None:
    spec = five_bar()
    rows, expected = rows_of(spec, list(range(9))), mapped(spec, number)
    for m, model in enumerate(spec.models):
        status = expected.status.sel(model=model).values
        assert rows["postures_ok"][m, number] == np.sum(status == 0)
        assert rows["postures_unreachable"][m, number] == np.sum(status == 1)
        for column in spec.columns:
            if (model, column.name) == ("simplified", "mean"):
                continue  # Drives alone do not let this robot's tool turn: all but rounding.
            one = expected[column.quantity].sel(model=model)
            one = one if column.load is None else one.sel(load=column.load)
            wanted = statistic(column, one.values.ravel())
            assert rows[column.name][m, number] == pytest.approx(wanted, rel=1e-12, abs=1e-18)


def test_the_pose_of_an_extreme_is_where_the_map_has_it() -> None:
    spec = five_bar()
    rows, expected = rows_of(spec, [4]), mapped(spec, 4)
    weakest = expected.stiffness_translation_min.sel(model="refined")
    at = weakest.where(weakest == weakest.min(), drop=True)
    np.testing.assert_allclose(
        rows["weakest_at"][0, :, 0], [float(at[axis][0]) for axis in ("x", "y")], atol=1e-12
    )


def test_some_of_these_workspaces_are_reached_in_part() -> None:
    unreachable = rows_of(five_bar(), list(range(9)))["postures_unreachable"][0]
    assert unreachable[0] > 0
    assert unreachable[4] == 0


def same(first: dict[str, NDArray[Any]], second: dict[str, NDArray[Any]]) -> bool:
    return all(
        np.array_equal(first[name], second[name], equal_nan=first[name].dtype.kind == "f")
        for name in first
    )


@pytest.mark.parametrize("robot", ["five-bar", "biglide"])
def test_a_row_does_not_depend_on_its_neighbours(robot: str) -> None:
    spec = five_bar(frequency_postures=3)
    if robot == "biglide":
        lengths = (Varied("L1", (0.83, 0.87, 0.9), "m"), Varied("L2", (0.72, 0.77, 0.8), "m"))
        columns = tuple(replace(c, load="f_x" if c.load else None) for c in COLUMNS)
        spec = five_bar(robot=robot, varied=lengths, columns=columns, frequency_postures=3)
    together = rows_of(spec, list(range(9)))
    for number in (0, 4, 7):
        alone = rows_of(spec, [number])
        assert same({n: a[..., number : number + 1] for n, a in together.items()}, alone)
    backwards = rows_of(spec, list(range(8, -1, -1)))
    assert same({n: a[..., ::-1] for n, a in backwards.items()}, together)


def test_what_cannot_be_assembled_has_a_status_and_no_numbers() -> None:
    spec = five_bar(varied=(Varied("distal", (0.35, 0.1, -0.1), "mm"),))
    rows = rows_of(spec, [0, 1, 2])
    assert rows["geometry_status"].tolist() == [0, 2, 1]
    assert rows["reason"][0] == ""
    assert "no assembly" in rows["reason"][1]
    assert "positive" in rows["reason"][2]
    assert np.isnan(rows["weakest"][:, 1:]).all()
    assert np.isfinite(rows["weakest"][:, 0]).all()


def test_frequencies_are_those_of_the_full_model() -> None:
    from stiffkit.study.sweep.family import Family
    from stiffkit.vibration import ModalModel

    column = Column("slowest", "min", "frequency_first")
    spec = five_bar(frequency_postures=4, models=("refined",), columns=(column,))
    rows = rows_of(spec, [4, 5])
    family = Family(spec)
    for i, number in enumerate((4, 5)):
        values = parameter_values(spec, np.array([number]))[:, 0]
        geometry = family.geometry(values)
        analysis = Analysis(geometry.robot)
        kinematics = analysis.kinematics
        full = ModalModel(kinematics.tree, kinematics.length)
        poses = geometry.poses[:, family.frequency_postures]
        for f, (x, y) in enumerate(poses.T):
            q = kinematics.solve_at({"x": float(x), "y": float(y)}).coordinates[:, 0]
            exact = full.at(q, 1).frequencies_hz[0]
            assert rows["frequency_first"][f, i] == pytest.approx(exact, rel=1e-4)
        assert rows["slowest"][0, i] == rows["frequency_first"][:, i].min()
        assert 0.0 <= rows["frequency_error"][i] < 1e-2


def test_masses_that_cannot_be_spread_leave_the_stiffness() -> None:
    varied = (Varied("L1", (0.85, 0.79), "m"),)
    columns = (COLUMNS[0], Column("slowest", "min", "frequency_first"))
    spec = five_bar(robot="biglide", varied=varied, columns=columns, frequency_postures=2)
    rows = rows_of(spec, [0, 1])
    assert "no frequencies" in rows["reason"][1]
    assert np.isnan(rows["slowest"][0]).tolist() == [False, True]
    assert np.isfinite(rows["weakest"]).all()


@pytest.mark.skipif(not heyoka_available(), reason="nothing to compare with")
def test_compiled_and_interpreted_rows_agree() -> None:
    spec = five_bar(varied=(Varied("distal", (0.33, 0.36), "mm"),))
    ready = prepare(spec, "numpy")
    job = Job("interpreted", spec.plain(), ready.robot_hash, "numpy")
    values = parameter_values(spec, np.array([0, 1]))
    interpreted: Rows = compute_chunk(job.plain(), ready.reference, values)
    compiled = rows_of(spec, [0, 1])
    for name in ("weakest", "worst", "p95", "soft"):
        np.testing.assert_allclose(interpreted[name], compiled[name], rtol=1e-9, err_msg=name)


class TestReductions:
    """Against NumPy's own, with postures that have no answer."""

    values = np.array([[3.0, np.nan, 1.0, 2.0], [np.nan, np.nan, np.nan, np.nan]])

    @pytest.mark.parametrize("column", COLUMNS, ids=lambda c: c.statistic)
    def test_unknown_postures_do_not_count(self, column: Column) -> None:
        column = replace(column, value=None if column.value is None else min(column.value, 1.5))
        result, place = reduce(column, self.values)
        assert result[0] == pytest.approx(statistic(column, self.values[0]))
        assert np.isnan(result[1])
        assert place[1] == -1
        assert place[0] == {"min": 2, "max": 0}.get(column.statistic, -1)

    @pytest.mark.parametrize("percent", [0.0, 10.0, 50.0, 77.7, 100.0])
    def test_percentiles(self, percent: float) -> None:
        values = np.random.default_rng(0).normal(size=(3, 40))
        values[1, ::3] = np.nan
        found, _ = reduce(Column("p", "percentile", "deflection_z", "lift", percent), values)
        np.testing.assert_allclose(found, np.nanpercentile(values, percent, axis=1), rtol=1e-13)

    def test_what_does_not_yield_is_infinitely_stiff(self) -> None:
        values = np.array([[np.nan, np.inf, np.inf]])
        found, place = reduce(COLUMNS[0], values)
        assert found[0] == np.inf
        assert place[0] == 1


class TestRobotFile:
    """Robots with other parameters are those that reading the file anew gives."""

    @pytest.mark.parametrize("name", ["biglide", "delta", "orthoglide"])
    def test_every_parameter(self, name: str) -> None:
        from stiffkit.compiled import Constants
        from stiffkit.network import add_elasticity

        def numbers(robot: Any) -> Array:
            constants = Constants()
            add_elasticity(constants, robot, 1.0)
            return constants.values

        file = RobotFile(name)
        own = file.robot()
        for parameter in own.parameters.values():
            for factor in (1.01, 1.0):
                dims = parse_quantity(f"1 {parameter.unit}").dims if parameter.unit else None
                given = {parameter.name: Value(parameter.value * factor, dims)}
                again, anew = file.robot(given), load_robot(name, given)
                np.testing.assert_array_equal(numbers(again), numbers(anew))
                assert again.notes == anew.notes
                assert again.home.tool == anew.home.tool

    def test_what_no_parameter_changes_is_the_same_object(self) -> None:
        file = RobotFile("biglide")
        first, second = file.robot(), file.robot({"L1": 0.86})
        assert first.links["leg_2"] is second.links["leg_2"]
        assert first.links["leg_1"] is not second.links["leg_1"]


def test_workers_refuse_another_file_and_another_version() -> None:
    """What they would compute belongs to another study."""
    from stiffkit.errors import StiffkitError

    spec = five_bar()
    job = Job("changed", spec.plain(), "0" * 64, BACKEND)
    with pytest.raises(StiffkitError, match="has changed since the study began"):
        compute_chunk(job.plain(), prepared(spec).reference, parameter_values(spec, np.array([0])))
    old = replace(job, version="0.0.1", key="old")
    with pytest.raises(StiffkitError, match=r"of stiffkit 0\.0\.1"):
        compute_chunk(old.plain(), prepared(spec).reference, parameter_values(spec, np.array([0])))
