"""Figures and the report of a study of uncertainty: for every kind of workspace, and for gaps."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from stiffkit.design.uncertainty.summary import part_rows, summaries
from stiffkit.plots import write_uncertainty_figures
from stiffkit.plots.uncertainty_bars import MOST_BARS, ranking_figure, sources_figure
from stiffkit.plots.uncertainty_maps import band_figure, banded
from stiffkit.report import write_uncertainty_page

LIMITS = {"x": (-0.1, 0.1), "y": (0.3, 0.4), "z": (0.0, 0.1)}


def study(
    axes: str = "xy",
    *,
    models: tuple[str, ...] = ("refined", "simplified"),
    n_sources: int = 2,
    n_parts: int = 3,
    listed: bool = False,
    sampled: bool = True,
) -> xr.Dataset:
    """Return a dataset as `run_uncertainty` gives it, with a gap in the workspace."""
    random = np.random.default_rng(0)
    shape = (5,) if listed else (5, 4, 3)[: len(axes)]
    dims = ("point",) if listed else tuple(axes)
    values = 2e-5 * random.uniform(0.5, 1.0, (len(models), *shape))
    sigma = 0.02 * values
    status = np.zeros(values.shape, dtype=np.int8)
    for array, gap in ((values, np.nan), (sigma, np.nan), (status, 1)):
        array.reshape(len(models), -1)[:, -1] = gap
    shares = random.uniform(size=(len(models), n_sources, *shape)) + 0.0 * values[:, None]
    shares /= shares.sum(axis=1, keepdims=True)
    about = {"units": "m", "long_name": "deflection of the tool point under push"}
    every = ("model", *dims)
    data: dict[str, Any] = {
        "status": (every, status),
        "push": (every, values, {**about, "quantity": "deflection_translation", "load": "push"}),
        "push_sigma": (every, sigma, about),
        "push_low": (every, values - 2.0 * sigma, about),
        "push_high": (every, values + 2.0 * sigma, about),
        "push_cause": (("model", "source", *dims), shares, {"units": "1"}),
        "part_kind": ("part", ["link", "drive", "joint", *["link"] * n_parts][:n_parts]),
        "part_mass": ("part", [2.0, np.nan, np.nan, *[1.0] * n_parts][:n_parts]),
    }
    parts = random.uniform(-0.1, 1.0, n_parts)
    parts /= parts.sum()
    for key, row in (("share", parts), ("share_at_worst", parts[::-1])):
        data[f"push_{key}"] = ("part", row)
    data["push_gain_per_kg"] = ("part", parts / data["part_mass"][1])
    attrs: dict[str, Any] = {
        "title": "A <test>",
        "robot": "five-bar",
        "robot_title": "Planar five-bar",
        "robot_hash": "0" * 64,
        "stiffkit_version": "0",
        "confidence": 0.95,
        "options": json.dumps({"parameters": [], "links": [{"name": "a&b", "relative": 0.02}]}),
    }
    if sampled:
        first = values.reshape(len(models), -1)
        for key, row in (
            ("first_order", first),
            ("first_order_sigma", 0.02 * first),
            ("sigma", 0.021 * first),
            ("coverage", 0.94 + 0.0 * first),
        ):
            data[f"push_sampled_{key}"] = (("model", "sampled_posture"), row)
        attrs |= {"samples": 100, "samples_refused": 3}
    coordinates = {
        axis: (
            ("point",) if listed else axis,
            np.linspace(*LIMITS[axis], shape[0 if listed else i]),
        )
        for i, axis in enumerate(axes)
    }
    names = {"model": list(models), "source": [f"source_{i}" for i in range(n_sources)]}
    return xr.Dataset(
        data, {**coordinates, **names, "part": [f"part_{i}" for i in range(n_parts)]}, attrs
    )


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return the figures of ``study()``."""
    return write_uncertainty_figures(study(), tmp_path_factory.mktemp("drawn"))


def test_everything_is_drawn_by_both_models(drawn: list[Path]) -> None:
    names = [path.name for path in drawn if path.suffix == ".svg"]
    maps = ["map-push-refined.svg", "map-push-simplified.svg"]
    rest = ["sources-refined", "sources-simplified", "ranking-push"]
    checks = ["check-refined.svg", "check-simplified.svg"]
    assert names == [*maps, "band-push.svg", *(f"{name}.svg" for name in rest), *checks]
    assert all(path.stat().st_size > 1000 for path in drawn)


@pytest.mark.parametrize(
    ("axes", "listed", "has_map"), [("x", False, False), ("xyz", False, True), ("xy", True, True)]
)
def test_every_kind_of_workspace_is_drawn(
    axes: str, listed: bool, has_map: bool, tmp_path: Path
) -> None:
    dataset = study(axes, listed=listed, models=("refined",))
    written = write_uncertainty_figures(dataset, tmp_path)
    names = [path.stem for path in written if path.suffix == ".svg"]
    maps = ["map-push-refined"] if has_map else []
    assert names == [*maps, "band-push", "sources-refined", "ranking-push", "check-refined"]
    assert all(path.stat().st_size > 1000 for path in written)


def test_what_does_not_scatter_is_left_out(tmp_path: Path) -> None:
    dataset = study(sampled=False)
    dataset["push_sigma"].loc[{"model": "simplified"}] = 0.0
    written = write_uncertainty_figures(dataset, tmp_path)
    stems = {path.stem for path in written}
    assert stems == {"map-push-refined", "band-push", "sources-refined", "ranking-push"}


def bars_of(axes: Axes) -> float:
    """Return how long all bars are together."""
    return sum(patch.get_width() for patch in axes.patches if isinstance(patch, Rectangle))


def test_many_bars_become_one() -> None:
    dataset = study(n_sources=30, n_parts=30)
    figure = sources_figure(dataset, ["push"], "refined")
    labels = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert len(labels) == MOST_BARS
    assert labels[-1] == "19 others"
    assert bars_of(figure.axes[0]) == pytest.approx(100.0)
    parts = ranking_figure(dataset, "push")
    names = [text.get_text() for text in parts.axes[0].get_yticklabels()]
    assert names[-1] == "18 others"
    assert bars_of(parts.axes[0]) == pytest.approx(100.0)


def test_bands_are_drawn_where_they_are() -> None:
    dataset = study("x", models=("refined",))
    own = banded(dataset, "push", "refined")
    assert own.unit.symbol == "µm"
    np.testing.assert_allclose(own.relative[:-1], 2.0)
    np.testing.assert_allclose(own.half_width[:-1], 4.0)
    above, below = band_figure(dataset, "push").axes
    edge = np.asarray(above.collections[-1].get_paths()[0].vertices)
    assert edge[:, 1].max() == pytest.approx(1.04e6 * float(dataset["push"].max()))
    assert below.get_ylabel() == "half the band (%)"


def test_summaries_leave_gaps_out() -> None:
    dataset = study()
    both = summaries(dataset)
    assert [one.model for one in both] == ["refined", "simplified"]
    first = both[0]
    assert first.postures == 19
    assert first.title == "Deflection, load push"
    values = dataset["push"].sel(model="refined")
    assert first.worst == float(values.max())
    assert first.worst_half == pytest.approx(0.04 * first.worst)
    assert float(values.sel(first.worst_at, method="nearest")) == first.worst
    assert sum(first.causes.values()) == pytest.approx(1.0)
    assert first.coverage is not None
    assert first.coverage.mean == pytest.approx(0.94)
    assert summaries(study(sampled=False))[0].coverage is None
    nowhere = dataset.copy(deep=True)
    nowhere["push_high"][:] = np.nan
    assert summaries(nowhere) == []


def test_parts_of_a_model_that_has_none() -> None:
    dataset = study()
    assert [row.share for row in part_rows(dataset, "push")] == sorted(
        dataset["push_share"].values, reverse=True
    )
    assert part_rows(dataset.drop_vars(["push_share", "part"]), "push") == []


def test_the_page_is_closed_and_says_everything(drawn: list[Path], tmp_path: Path) -> None:
    html = page(study(), drawn, tmp_path)
    assert "A &lt;test&gt;" in html
    assert "link a&amp;b: one factor for its compliance, standard deviation 2 %" in html
    assert html.count("<img") == sum(path.suffix == ".png" for path in drawn)
    assert "3 more cannot be built" in html
    assert "Nothing was sampled." not in html


def test_the_page_of_what_was_not_sampled_says_so(tmp_path: Path) -> None:
    html = page(study(sampled=False), [], tmp_path)
    assert "A &lt;test&gt;" in html
    assert "3 more cannot be built" not in html
    assert "Nothing was sampled." in html


def page(dataset: xr.Dataset, figures: list[Path], folder: Path) -> str:
    """Return the report, which refers to nothing outside it."""
    write_uncertainty_page(dataset, figures, folder / "report.html")
    html = (folder / "report.html").read_text(encoding="utf-8")
    assert not re.search(r'(?:src|href)="(?!data:)', html)
    assert "$" not in re.sub(r"data:[^\"]*", "", html)
    return html
