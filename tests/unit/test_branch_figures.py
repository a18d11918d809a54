"""Curves of modes that are followed by their shapes, in figures and in the report."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from synthetic_map import add_branches, grid, synthetic_map  # type: ignore[import-not-found]

from stiffkit.errors import OutputError
from stiffkit.plots import branch_figure, branch_lines, has_branches, style, write_figures
from stiffkit.report.payload import payload_of


def shown(figure: Figure, panel: int = 0) -> list[tuple[np.ndarray, np.ndarray]]:
    lines = figure.axes[panel].get_lines()
    return [(np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in lines]


def legend_of(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_each_mode_keeps_its_line_through_a_crossing() -> None:
    figure = branch_figure(add_branches(synthetic_map(grid(x=9, y=5))))
    assert figure.get_suptitle() == "Natural frequencies, refined model (Hz)"
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["at y = 375 mm", "at x = 0 mm"]
    first, second, _, last = shown(figure)
    x = np.linspace(-150.0, 150.0, 9)
    assert first[0] == pytest.approx(x)
    assert first[1] == pytest.approx(90.0 + 0.2 * x)
    assert second[1] == pytest.approx(100.0 - 0.2 * x)
    assert np.isnan(last[1]).sum() == 2
    assert legend_of(figure)[:4] == ["mode 1", "mode 2", "mode 3", "mode 4"]


def test_lines_can_be_told_apart_in_grey() -> None:
    figure = branch_figure(add_branches(synthetic_map(grid(x=40, y=5))))
    lines = figure.axes[0].get_lines()
    assert len({str(look["linestyle"]) for look in style.BRANCHES}) == 4
    assert len({str(line.get_color()) for line in lines}) == 4


def test_the_scale_begins_near_the_lowest_frequency() -> None:
    figure = branch_figure(add_branches(synthetic_map(grid(x=9, y=5))))
    low, high = figure.axes[0].get_ylim()
    assert 40.0 < low < 60.0
    assert 180.0 < high < 200.0


def test_one_coordinate_and_a_list_of_points() -> None:
    figure = branch_figure(add_branches(synthetic_map(grid(x=12))))
    assert len(figure.axes) == 1
    assert figure.axes[0].get_title(loc="left") == ""
    angles = np.linspace(0.0, 6.0, 20)
    points = {"x": 0.1 * np.cos(angles), "y": 0.375 + 0.1 * np.sin(angles)}
    listed = branch_figure(add_branches(synthetic_map(points, points=True)))
    assert listed.axes[0].get_xlabel() == "number of the point"
    assert shown(listed)[0][0] == pytest.approx(np.arange(1, 21))


def test_lines_end_where_the_status_says_so() -> None:
    dataset = add_branches(synthetic_map(grid(x=31, y=31)))
    (along_x, _) = branch_lines(dataset, "refined")
    status = dataset["status"].sel(model="refined").isel(y=15).values
    assert (along_x.status == status).all()


def test_maps_without_frequencies() -> None:
    dataset = synthetic_map(grid(x=5, y=5))
    assert not has_branches(dataset)
    assert payload_of(dataset)["branches"] is None
    nothing = add_branches(dataset)
    nothing["frequency_of_branch"][:] = np.nan
    assert not has_branches(nothing)
    with pytest.raises(OutputError, match="no natural frequencies"):
        branch_figure(nothing)


def test_it_is_one_of_the_figures_of_a_map(tmp_path: Path) -> None:
    loads = {"push": [0, 100.0, 0, 0, 0, 0]}
    without = synthetic_map(grid(x=5), loads=loads)
    names = [path.name for path in write_figures(without, tmp_path / "without")]
    more = [path.name for path in write_figures(add_branches(without), tmp_path / "with")]
    assert more == [*names, "curves-frequency.svg", "curves-frequency.png"]


def numbers(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def test_the_report_gets_the_same_curves() -> None:
    dataset: xr.Dataset = add_branches(synthetic_map(grid(x=9, y=5)))
    branches = payload_of(dataset)["branches"]
    assert (branches["model"], branches["unit"]) == ("refined", "Hz")
    along_x, along_y = branches["lines"]
    assert (along_x["axis"], along_x["unit"], along_x["fixed"]) == ("x", "mm", "y = 375 mm")
    assert numbers(along_x["x"]) == pytest.approx(np.linspace(-150.0, 150.0, 9), abs=1e-4)
    assert numbers(along_x["values"][0]) == pytest.approx(np.linspace(60.0, 120.0, 9))
    assert len(along_y["status"]) == 5
