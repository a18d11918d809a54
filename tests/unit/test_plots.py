"""Figures of stiffness maps: units, drawing of every kind of map, files that repeat exactly."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from synthetic_map import grid, synthetic_map  # type: ignore[import-not-found]

from stiffkit.errors import OutputError
from stiffkit.plots import (
    QUANTITIES,
    Kind,
    curve_figure,
    display_unit,
    format_value,
    is_planar,
    map_figure,
    middle_posture,
    model_comparison_figure,
    ratio_of,
    sweep_of,
    values_of,
    write_figures,
)
from stiffkit.plots.scale import Scale

PATH = np.linspace(0.0, 2.0 * np.pi, 30)
CIRCLE = {"x": 0.1 * np.cos(PATH), "y": 0.375 + 0.17 * np.sin(PATH)}
HELIX = {**CIRCLE, "z": 0.2 + 0.01 * PATH}


def texts_of(figure: Figure) -> str:
    """Return all that a figure says: heading, titles, labels, legend, notes."""
    parts = [figure.get_suptitle()]
    for axes in figure.axes:
        parts += [axes.get_title(loc=where) for where in ("left", "center")]
        parts += [axes.get_xlabel(), axes.get_ylabel(), *(t.get_text() for t in axes.texts)]
    for legend in figure.legends:
        parts += [text.get_text() for text in legend.get_texts()]
    return " | ".join(parts)


@pytest.mark.parametrize(
    ("kind", "values", "symbol"),
    [
        (Kind.DEFLECTION, [2e-5, 3e-5, 1e-3], "µm"),
        (Kind.DEFLECTION, [2e-3, np.nan, np.inf], "mm"),
        (Kind.DEFLECTION, [5e-12], "nm"),
        (Kind.DEFLECTION, [0.0, 0.0], "µm"),
        (Kind.DEFLECTION, [0.001 * (1 - 1e-12)], "mm"),
        (Kind.STIFFNESS, [3e7], "N/µm"),
        (Kind.STIFFNESS, [3e4], "N/mm"),
        (Kind.ROTATIONAL_STIFFNESS, [2e5], "kN m/rad"),
        (Kind.ROTATION, [2e-4], "µrad"),
        (Kind.POSITION, [3.0], "mm"),
        (Kind.RATIO, [3.0], ""),
    ],
)
def test_display_unit_fits_the_median(kind: Kind, values: list[float], symbol: str) -> None:
    assert display_unit(kind, values).symbol == symbol


def test_display_unit_converts_and_writes() -> None:
    unit = display_unit(Kind.STIFFNESS, [5e6])
    assert unit.of([5e6, 1e7]) == pytest.approx([5.0, 10.0])
    assert unit.text(5e6) == "5 N/µm"
    assert unit.label("Stiffness") == "Stiffness (N/µm)"
    assert display_unit(Kind.ANGLE, ()).text(np.pi / 6) == "30°"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (12.345, "12.35"),
        (120.0, "120"),
        (-0.5, "−0.5"),
        (0.0, "0"),
        (np.nan, "–"),
        (np.inf, "∞"),
        (12345.6, "12346"),
        (1.5e-5, "1.500e−05"),
    ],
)
def test_format_value(value: float, text: str) -> None:
    assert format_value(value) == text


def test_rounding_error_is_zero_and_infinite_stiffness_stays() -> None:
    dataset = synthetic_map(grid(x=5, y=5))
    dataset["deflection_z"].loc[{"model": "simplified", "load": "push"}] = 1e-22
    z = values_of(dataset, QUANTITIES["deflection_z"], "simplified", "push")
    assert np.nanmax(z) == 0.0
    stiff = values_of(dataset, QUANTITIES["stiffness_rotation_min"], "simplified", None)
    computed = dataset["status"].sel(model="simplified").values == 0
    assert np.isinf(stiff[computed]).all()
    assert np.isnan(stiff[~computed]).all()


def test_values_are_hidden_where_the_status_says_so() -> None:
    dataset = synthetic_map(grid(x=5, y=5))
    dataset["status"][:] = 1
    values = values_of(dataset, QUANTITIES["deflection_xy"], "refined", "push")
    assert np.isnan(values).all()


def test_ratio_is_refined_over_simplified() -> None:
    dataset = synthetic_map(grid(x=5, y=5))
    ratio = ratio_of(dataset, QUANTITIES["deflection_xy"], "push")
    refined = dataset["deflection_xy"].sel(model="refined", load="push").values
    simplified = dataset["deflection_xy"].sel(model="simplified", load="push").values
    assert ratio[2, 2] == pytest.approx(refined[2, 2] / simplified[2, 2])
    assert np.isnan(ratio_of(dataset, QUANTITIES["deflection_z"], "lift")).all()


def test_sweep_of_grid_and_of_points() -> None:
    assert sweep_of(synthetic_map(grid(x=3, rz=4))).axes == ("x", "rz")
    points = sweep_of(synthetic_map({**CIRCLE, "z": np.full(30, 0.2)}, points=True))
    assert points.axes == ("x", "y")
    assert points.shape == (30,)
    assert not points.is_grid


def test_planar_and_spatial() -> None:
    assert is_planar(synthetic_map(grid(x=3, y=3)))
    assert is_planar(synthetic_map(grid(x=3, rz=3)))
    assert not is_planar(synthetic_map(grid(x=3, y=3, z=2)))


def test_middle_posture_is_a_computed_one() -> None:
    status = np.zeros((5, 5), dtype=np.int8)
    assert middle_posture(status) == (2, 2)
    status[1:4, 1:4] = 1
    row, column = middle_posture(status)
    assert status[row, column] == 0
    assert middle_posture(np.ones((5, 4), dtype=np.int8)) == (2, 2)


def test_scale_turns_logarithmic_only_for_a_wide_spread() -> None:
    assert not Scale.of(np.array([1.0, 5.0])).is_log
    wide = Scale.of(np.array([0.0, 1.0, np.nan, 50.0, np.inf]))
    assert wide.is_log
    assert (wide.low, wide.high) == (1.0, 50.0)
    assert Scale.of(np.array([2.0, 2.0])).levels(np.array([2.0, 2.0])).size == 0
    levels = wide.levels(np.array([1.0, 50.0]))
    assert list(levels) == [2.0, 5.0, 10.0, 20.0]


def test_map_names_quantity_unit_load_and_gaps() -> None:
    dataset = synthetic_map(grid(x=15, y=15))
    said = texts_of(map_figure(dataset, "deflection_xy", "refined", "push"))
    for word in (
        "Deflection in the xy plane, load push",
        "refined model",
        "µm",
        "x (mm)",
        "out of reach",
        "singular",
        "uncontrolled",
    ):
        assert word in said


def test_unevenly_spaced_coordinates_keep_their_places() -> None:
    x = np.array([-0.15, -0.14, -0.1, 0.0, 0.15])
    dataset = synthetic_map({"x": x, **grid(y=6)}, models=["refined"])
    axes = map_figure(dataset, "deflection_xy", "refined", "push").axes[0]
    assert axes.get_xlim() == pytest.approx((-155.0, 225.0))
    assert axes.get_ylim() == pytest.approx((195.0, 555.0))


def test_map_of_three_coordinates_shows_slices() -> None:
    dataset = synthetic_map(grid(x=5, y=5, z=9))
    said = texts_of(map_figure(dataset, "deflection_translation", "refined", "push"))
    assert said.count("z = ") == 6
    assert "z = 50 mm" in said
    assert "z = 350 mm" in said


def test_map_of_four_coordinates_holds_the_last_in_the_middle() -> None:
    dataset = synthetic_map(grid(x=5, y=5, z=3, rz=3))
    said = texts_of(map_figure(dataset, "deflection_translation", "refined", "push"))
    assert "z = 200 mm, rz = 0°" in said


@pytest.mark.parametrize("coordinates", [CIRCLE, HELIX, {"x": np.linspace(-0.1, 0.1, 7)}])
def test_points_are_drawn(coordinates: dict[str, np.ndarray]) -> None:
    dataset = synthetic_map(coordinates, points=True)
    assert "refined model" in texts_of(
        map_figure(dataset, "deflection_translation", "refined", "push")
    )
    assert "simplified model" in texts_of(curve_figure(dataset, "deflection_translation", "push"))


def test_comparison_shares_one_colour_scale_and_shows_the_ratio() -> None:
    dataset = synthetic_map(grid(x=15, y=15))
    figure = model_comparison_figure(dataset, "stiffness_translation_min")
    refined, simplified, ratio = (axes for axes in figure.axes if axes.get_xlabel())
    limits = [
        {i.get_clim() for i in axes.images if i.get_cmap().name in ("viridis", "cividis")}
        for axes in (refined, simplified, ratio)
    ]
    assert limits[0] == limits[1] != limits[2]
    (low, high) = limits[0].pop()
    values = dataset["stiffness_translation_min"].values / 1e6
    assert (low, high) == pytest.approx((np.nanmin(values), np.nanmax(values)))
    assert "refined / simplified" in texts_of(figure)


def test_comparison_says_what_a_model_leaves_out() -> None:
    dataset = synthetic_map(grid(x=15, y=15))
    zero = texts_of(model_comparison_figure(dataset, "deflection_z", "lift"))
    assert "zero in this model" in zero
    assert "ratio" not in zero
    assert "rigid in this model" in texts_of(
        model_comparison_figure(dataset, "stiffness_rotation_min")
    )


def test_curves_run_through_the_middle_in_every_direction() -> None:
    dataset = synthetic_map(grid(x=7, y=7, rz=3))
    figure = curve_figure(dataset, "deflection_xy", "push")
    said = texts_of(figure)
    assert len(figure.axes) == 3
    assert "at y = 375 mm, rz = 0°" in said
    assert "at x = 0 mm, y = 375 mm" in said
    expected = dataset["deflection_xy"].sel(model="refined", load="push").values[:, 3, 1]
    drawn = np.asarray(figure.axes[0].lines[0].get_ydata(), dtype=np.float64)
    np.testing.assert_allclose(drawn, expected * 1e6)


def test_what_the_map_does_not_hold_is_named() -> None:
    dataset = synthetic_map(grid(x=3, y=3), models=["refined"])
    with pytest.raises(OutputError, match=r"no quantity 'weight' to draw\s+mend:.*deflection_xy"):
        map_figure(dataset, "weight", "refined")
    with pytest.raises(OutputError, match=r"no load 'pull'\s+mend:.*push, lift"):
        map_figure(dataset, "deflection_xy", "refined", "pull")
    with pytest.raises(OutputError, match="no model 'simplified'"):
        map_figure(dataset, "deflection_xy", "simplified", "push")
    with pytest.raises(OutputError, match="nothing to compare"):
        model_comparison_figure(dataset, "deflection_xy", "push")
    with pytest.raises(OutputError, match="sweeps over no tool coordinate"):
        sweep_of(dataset.isel(x=0, y=0))


def test_a_map_without_any_answer_is_still_drawn() -> None:
    dataset = synthetic_map(grid(x=5, y=5))
    dataset["status"][:] = 1
    assert "no posture has an answer" in texts_of(
        map_figure(dataset, "deflection_xy", "refined", "push")
    )


def test_write_figures_repeats_byte_for_byte(tmp_path: Path) -> None:
    dataset = synthetic_map(grid(x=9), loads={"push up/down": [0, 100, 0, 0, 0, 0]})
    first = write_figures(dataset, tmp_path / "first")
    second = write_figures(dataset, tmp_path / "second")
    assert [path.name for path in first] == [path.name for path in second]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    assert "compare-deflection_xy-push_up_down.svg" in {path.name for path in first}
    assert {path.suffix for path in first} == {".svg", ".png"}
    assert sorted(first) == sorted((tmp_path / "first").iterdir())


def test_svg_keeps_text_as_text_and_has_no_date(tmp_path: Path) -> None:
    dataset = synthetic_map(
        grid(x=9, y=9), models=["refined"], loads={"$<b>": [0, 9.0, 0, 0, 0, 0]}
    )
    written = write_figures(dataset, tmp_path)
    path = next(p for p in written if p.name.startswith("map-deflection_xy") and p.suffix == ".svg")
    root = ElementTree.parse(path).getroot()  # noqa: S314 - our own file
    words = " ".join(root.itertext())
    assert "Deflection in the xy plane, load $<b>" in words
    assert "x (mm)" in words
    assert "date" not in path.read_text(encoding="utf-8").lower()


def test_load_names_that_look_alike_get_files_of_their_own(tmp_path: Path) -> None:
    loads = {"a b": [0, 1.0, 0, 0, 0, 0], "a/b": [1.0, 0, 0, 0, 0, 0], "A_B": [1.0, 1, 0, 0, 0, 0]}
    dataset = synthetic_map(grid(x=4), models=["refined"], loads=loads)
    names = {path.stem for path in write_figures(dataset, tmp_path)}
    assert {f"curves-deflection_xy-{n}" for n in ("a_b", "a_b-2", "A_B-3")} <= names


def test_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OutputError, match="cannot make the folder"):
        write_figures(synthetic_map(grid(x=3)), tmp_path / "file" / "figures")


def test_logarithmic_colours_are_used_when_the_models_lie_far_apart() -> None:
    dataset = synthetic_map(grid(x=9, y=9))
    figure = model_comparison_figure(dataset, "stiffness_translation_min")
    assert any(isinstance(image.norm, LogNorm) for axes in figure.axes for image in axes.images)
