"""Figures of design studies: what they read, what they draw, and that it can be read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from synthetic_designs import (  # type: ignore[import-not-found]
    infeasible,
    many_objectives,
    one_objective,
    one_parameter,
    two_objectives,
)
from synthetic_map import grid, synthetic_map  # type: ignore[import-not-found]

from stiffkit.errors import OutputError
from stiffkit.plots import design_figures, style, write_design_figures
from stiffkit.plots.design_curves import parameter_figure, progress_figure
from stiffkit.plots.design_maps import design_maps_figure, map_choices
from stiffkit.plots.design_parallel import parallel_figure
from stiffkit.plots.design_tradeoff import matrix_figure, tradeoff_figure
from stiffkit.plots.designs import change_text, designs_of, unit_for

Array = NDArray[np.float64]


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make pictures coarse, which is many times faster."""
    monkeypatch.setattr(style, "DPI", 50)


def points_of(line: Line2D) -> Array:
    """Return the points (n, 2) of a line."""
    return np.asarray(line.get_xydata())


def texts_of(figure: Figure) -> str:
    """Return all that a figure says."""
    parts = [figure.get_suptitle()]
    for axes in figure.axes:
        parts += [axes.get_title(loc="left"), axes.get_xlabel(), axes.get_ylabel()]
        parts += [text.get_text() for text in (*axes.texts, *axes.get_xticklabels())]
    for legend in figure.legends:
        parts += [text.get_text() for text in legend.get_texts()]
    return " | ".join(parts).replace("\n", " ").replace("\N{NO-BREAK SPACE}", " ")


# --- what is read ---


def test_what_a_dataset_says() -> None:
    dataset = two_objectives()
    designs = designs_of(dataset)
    assert [one.name for one in designs.parameters] == ["scale", "wall", "gear"]
    assert [one.unit.symbol for one in designs.parameters] == ["", "mm", ""]
    assert [one.title for one in designs.objectives] == ["largest deflection", "moving mass"]
    assert designs.objectives[0].unit.symbol == "µm"
    assert [one.goal for one in designs.constraints] == ["above 40 Hz", "above 0.85"]
    assert designs.count == 300
    for model in ("refined", "simplified"):
        members = designs.front_of(model)
        first, second = (one.values[model][members] for one in designs.objectives)
        # On a front, what is worse in one objective is better in the other.
        assert (np.diff(first) > 0.0).all()
        assert (np.diff(second) < 0.0).all()
        assert designs.chosen[model] in members


def test_bounds_by_model_derived_parameters_and_options() -> None:
    dataset = one_objective()
    dataset["mass"].attrs["bound_by_model"] = np.array([62.0, 55.0])
    about = {"kind": "derived", "units": "m", "low": 0.0, "high": 1.0}
    dataset["a"] = ("design", 2.0 * dataset["L1"].values, about)
    words = np.array(["thin"] * dataset.sizes["design"], dtype=object)
    dataset["section"] = ("design", words, {"long_name": "option"})
    designs = designs_of(dataset)
    mass = designs.constraints[0]
    assert mass.goal == "below 62 kg or 55 kg"
    heavy = int(np.argmin(np.abs(mass.values["refined"] - 58.0)))
    assert not mass.is_broken("refined", heavy)
    assert mass.is_broken("simplified", heavy)
    assert [one.name for one in designs.derived] == ["a"]
    assert designs.options["section"][3] == "thin"


def test_a_constraint_is_kept_active_or_broken() -> None:
    dataset = one_objective()
    dataset["mass"].values[0, :4] = [62.0 * (1.0 + 1e-9), 61.8, 61.0, 62.01]
    dataset["mass"].values[0, 4] = np.nan
    mass = designs_of(dataset).constraints[0]
    assert [mass.is_broken("refined", i) for i in range(5)] == [False, False, False, True, True]
    assert [mass.is_active("refined", i) for i in range(4)] == [True, True, False, True]


def test_what_holds_no_designs_is_refused() -> None:
    dataset = one_objective()
    for broken in (
        dataset.drop_vars(["L1", "L2"]),
        dataset.drop_vars("worst_deflection"),
        synthetic_map(grid(x=3, y=3)),
        dataset.isel(design=[]),
    ):
        with pytest.raises(OutputError, match="holds no designs"):
            design_figures(broken)


@pytest.mark.parametrize(
    ("value", "start", "text"),
    [
        (0.7, 1.0, "−30 %"),
        (1.0004, 1.0, "0 %"),
        (0.99, 1.0, "−1 %"),
        (2.3456, 1.0, "+135 %"),
        (1.0, 0.0, "–"),
        (np.nan, 1.0, "–"),
    ],
)
def test_changes(value: float, start: float, text: str) -> None:
    assert change_text(value, start) == text


@pytest.mark.parametrize(
    ("units", "value", "is_parameter", "symbol"),
    [
        ("m", 2.0, True, "mm"),
        ("m", 2e-5, False, "µm"),
        ("rad", 0.3, True, "°"),
        ("N/m", 3e7, True, "N/µm"),
        ("Pa", 7e10, True, "GPa"),
        ("1", 0.5, False, ""),
        ("kg", 3.0, False, "kg"),
        ("m^3", 3.0, False, "m^3"),
    ],
)
def test_units(units: str, value: float, is_parameter: bool, symbol: str) -> None:
    assert unit_for(units, np.array([value]), is_parameter=is_parameter).symbol == symbol


# --- which figures there are ---


def test_each_kind_of_study_gets_its_figures() -> None:
    maps = {"start": synthetic_map(grid(x=5, y=5)), "chosen": synthetic_map(grid(x=6, y=4))}
    names = {
        two_objectives: ["tradeoff", "parallel"],
        one_parameter: ["objectives", "over-alpha"],
        many_objectives: ["objectives", "parallel"],
        one_objective: ["parallel", "progress"],
        infeasible: ["tradeoff"],
    }
    for make, expected in names.items():
        assert [name for name, _ in design_figures(make())] == expected
    with_maps = [name for name, _ in design_figures(two_objectives(), maps)]
    assert with_maps[2:] == [
        "maps-deflection_xy-push",
        "maps-deflection_z-lift",
        "maps-stiffness_translation_min",
        "maps-stiffness_rotation_min",
    ]


@pytest.mark.parametrize("make", [two_objectives, one_objective, one_parameter, infeasible])
def test_studies_of_one_model_have_them_too(make: Callable[[], xr.Dataset], tmp_path: Path) -> None:
    both = [name for name, _ in design_figures(make())]
    written = write_design_figures(make().isel(model=[1]), tmp_path)
    assert [path.stem for path in written[::2]] == both


def test_designs_without_an_answer_do_no_harm() -> None:
    for make in (two_objectives, one_parameter, one_objective, many_objectives):
        dataset = make()
        lost = np.arange(dataset.sizes["design"]) % 7 == 3
        for variable in dataset.data_vars.values():
            if "role" in variable.attrs:
                variable.values[:, lost] = np.nan
        for name in ("feasible", "front"):
            dataset[name].values[:, lost] = 0
        first = next(v for v in dataset.data_vars.values() if v.attrs.get("role") == "objective")
        first.values[1] = np.nan
        assert design_figures(dataset)


def test_files_repeat_exactly(tmp_path: Path) -> None:
    first = write_design_figures(one_parameter(), tmp_path / "a")
    second = write_design_figures(one_parameter(), tmp_path / "b")
    assert [path.name for path in first] == [
        f"{name}.{suffix}" for name in ("objectives", "over-alpha") for suffix in ("svg", "png")
    ]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


# --- what they show ---


def test_the_tradeoff_shows_fronts_by_both_models() -> None:
    designs = designs_of(two_objectives())
    figure = tradeoff_figure(designs)
    text = texts_of(figure)
    for part in (
        "judged by the refined model",
        "judged by the simplified model",
        "← better   largest deflection (µm)",
        "← better   moving mass (kg)",
        "chosen by the simplified model",
        "not feasible",
    ):
        assert part in text
    left = figure.axes[0]
    for model in designs.models:
        members = designs.front_of(model)
        expected = [one.unit.of(one.values["refined"][members]) for one in designs.objectives]
        drawn = [np.array_equal(np.transpose(expected), points_of(line)) for line in left.lines]
        assert sum(drawn) == 1, model
    # Start and both chosen designs lie within both panels.
    for axes, model in zip(figure.axes, designs.models, strict=True):
        for number in (0, *designs.chosen.values()):
            x, y = (one.unit.of(one.values[model][number]) for one in designs.objectives)
            assert axes.get_xlim()[0] < x < axes.get_xlim()[1]
            assert axes.get_ylim()[0] < y < axes.get_ylim()[1]


def test_the_matrix_has_one_model_on_each_side() -> None:
    designs = designs_of(many_objectives())
    figure = matrix_figure(designs)
    assert len(figure.axes) == 16
    for row, column, model in ((2, 0, "refined"), (0, 2, "simplified")):
        axes = figure.axes[4 * row + column]
        x, y = designs.objectives[column], designs.objectives[row]
        members = designs.front_of(model)
        expected = np.transpose([o.unit.of(o.values[model][members]) for o in (x, y)])
        assert any(np.array_equal(expected, points_of(line)) for line in axes.lines)
    assert "frequency (Hz) (large is good)" in texts_of(figure)


def test_parallel_coordinates_span_ranges_and_show_bounds() -> None:
    designs = designs_of(two_objectives())
    figure = parallel_figure(designs)
    text = texts_of(figure)
    for part in ("wall (mm)", "minimise", "above 40 Hz", "front of the refined model (18 designs)"):
        assert part in text
    axes = figure.axes[0]
    across = [line for line in axes.lines if len(points_of(line)) == 7]
    assert len(across) == 18 + 3
    wall = designs.parameters[1]
    start = np.asarray(across[18].get_ydata())
    assert start[1] == pytest.approx((wall.values[0] - wall.low) / (wall.high - wall.low))


def test_a_constraint_that_tells_nothing_has_no_axis() -> None:
    dataset = one_objective()
    dataset["mass"].values[:] = 50.0
    assert "mass" not in texts_of(parallel_figure(designs_of(dataset)))
    dataset = one_parameter()
    dataset["mass"].values[:] = 50.0
    assert "mass" not in texts_of(parameter_figure(designs_of(dataset)))


def test_curves_over_the_parameter_have_both_models() -> None:
    designs = designs_of(one_parameter())
    figure = parameter_figure(designs)
    assert "mass: below 190 kg" in texts_of(figure)
    axes = figure.axes[2]
    order = np.argsort(designs.parameters[0].values, kind="stable")
    frequency = designs.objectives[2]
    curves = [line for line in axes.lines if len(points_of(line)) > 1]
    for curve, model in zip(curves, designs.models, strict=True):
        assert np.array_equal(curve.get_ydata(), frequency.values[model][order])
    # What the simplified model chooses also stands on the curve of the refined one.
    foreign = designs.chosen["simplified"]
    hollow = [designs.parameters[0].values[foreign], frequency.values["refined"][foreign]]
    points = [points_of(line).tolist() for line in axes.lines]
    assert [hollow] in points


def test_a_bound_far_from_all_values_does_not_squeeze_them() -> None:
    dataset = one_parameter()
    dataset["mass"].attrs["bound"] = 5000.0
    figure = parameter_figure(designs_of(dataset))
    assert figure.axes[3].get_ylim()[1] < 300.0
    assert "beyond the bound" not in texts_of(figure)


def test_progress_only_gets_better() -> None:
    figure = progress_figure(designs_of(one_objective()))
    assert "Best feasible worst deflection so far" in texts_of(figure)
    for axes in figure.axes:
        steps = [line for line in axes.lines if len(points_of(line)) > 2]
        assert len(steps) == 2
        for line in steps:
            values = np.asarray(line.get_ydata(), dtype=float)
            known = values[np.isfinite(values)]
            assert known.size
            assert (np.diff(known) <= 0.0).all()


# --- maps ---


def pair_of_maps(**counts: int) -> dict[str, xr.Dataset]:
    start, chosen = synthetic_map(grid(**counts)), synthetic_map(grid(**counts))
    chosen["deflection_xy"] = 0.5 * chosen["deflection_xy"]
    return {"start": start, "chosen": chosen}


def test_maps_share_their_colours() -> None:
    maps = pair_of_maps(x=9, y=8)
    quantity, load, model = map_choices(maps, [("deflection_xy", "push")])[0]
    figure = design_maps_figure(maps, quantity, load, model)
    assert (quantity.name, load, model) == ("deflection_xy", "push", "refined")
    images = [axes.images[0] for axes in figure.axes[:2]]
    assert images[0].get_clim() == images[1].get_clim()
    text = texts_of(figure)
    assert "Deflection in the xy plane, load push, refined model" in text
    assert "start" in text
    assert "chosen" in text


@pytest.mark.parametrize("counts", [{"x": 7}, {"x": 5, "y": 4, "z": 3}])
def test_maps_over_other_workspaces(counts: dict[str, int]) -> None:
    maps = pair_of_maps(**counts)
    for quantity, load, model in map_choices(maps, []):
        assert design_maps_figure(maps, quantity, load, model).axes


def test_maps_show_what_was_asked_if_they_have_it() -> None:
    maps = pair_of_maps(x=4, y=4)
    asked = [("frequency_first", None), ("deflection_z", "lift"), ("deflection_z", "lift")]
    chosen = map_choices(maps, asked)
    assert [(quantity.name, load) for quantity, load, _ in chosen] == [("deflection_z", "lift")]
