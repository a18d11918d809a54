"""The report of a stiffness map: what it says, what it keeps when it thins, that it is closed."""

from __future__ import annotations

import base64
import json
import re
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from synthetic_map import grid, synthetic_map  # type: ignore[import-not-found]
from tests.unit.page_reader import unpacked

from stiffkit.errors import OutputError
from stiffkit.report import write_report
from stiffkit.report.decimate import (
    block_sizes,
    coordinates_of_blocks,
    status_of_blocks,
    worst_of_blocks,
)
from stiffkit.report.payload import json_text, payload_of, worst_postures
from stiffkit.report.template import packed
from stiffkit.report.words import (
    key_figures,
    load_in_words,
    scope_in_words,
    status_in_words,
    texts_of,
)

SUMMARY = [("Drives", "motor_left.rz, motor_right.rz"), ("Links", "4 beams")]
HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)> & Söhne"


class Page(HTMLParser):
    """The visible text, the scripts and the addresses of a page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.scripts: list[str] = []
        self.words: list[str] = []
        self._inside = ""
        self.feed(html)
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        self._inside = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside == "script":
            self.scripts[-1] += data
        elif self._inside != "style":
            self.words.append(data)

    @property
    def data(self) -> Any:
        """What the page's own script reads."""
        return json.loads(unpacked(self.scripts[0]))


def report_of(dataset: xr.Dataset, folder: Path, **more: Any) -> Page:
    path = folder / "report.html"
    write_report(dataset, SUMMARY, path, **more)
    return Page(path.read_text(encoding="utf-8"))


def numbers(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def test_page_tells_what_was_found(tmp_path: Path) -> None:
    page = report_of(synthetic_map(grid(x=15, y=15)), tmp_path)
    for words in (
        "Synthetic five-bar",
        "225 postures: x from −150 mm to 150 mm (15 values), y from 225 mm to 525 mm (15 values)",
        "are out of reach",
        "are singular",
        "are uncontrolled",
        "platform: rotation about z of left_rod",
        "force (0, 100, 0) N",
        "compliance was made symmetric",
        "motor_left.rz, motor_right.rz",
        "0123456789abcdef",
        "stiffkit 0.1.0",
    ):
        assert words in page.text


def test_page_is_closed(tmp_path: Path) -> None:
    figure = tmp_path / "map.svg"
    figure.write_text('<svg xmlns="http://www.w3.org/2000/svg"/>', encoding="utf-8")
    page = report_of(synthetic_map(grid(x=4, y=4)), tmp_path, figures=[figure])
    assert all(address.startswith("data:") for address in page.addresses)
    assert "link" not in page.tags
    assert "iframe" not in page.tags
    assert page.tags.count("script") == 3
    assert page.tags.count("img") == 1
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "default-src 'none'" in html


def test_names_of_the_robot_file_stay_text(tmp_path: Path) -> None:
    dataset = synthetic_map(grid(x=4, y=4), title=HOSTILE, loads={HOSTILE: [0, 100.0, 0, 0, 0, 0]})
    dataset.attrs["notes"] = [HOSTILE]
    dataset.attrs["free_motions"] = [HOSTILE]
    dataset["joint_coordinate"] = [HOSTILE + ".rz", "b.rz", "c.z"]
    path = tmp_path / "report.html"
    write_report(dataset, [(HOSTILE, HOSTILE)], path)
    page = Page(path.read_text(encoding="utf-8"))
    assert page.tags.count("script") == 3
    assert "img" not in page.tags
    assert page.data["loads"] == [HOSTILE]
    assert page.text.count("alert(1)") >= 6


def test_data_survives_a_script_element() -> None:
    value = {"a": "</script><!-- & \u2028"}
    packed_text = packed(json_text(value))
    assert not set("<>&\u2028") & set(packed_text)
    assert json.loads(unpacked(packed_text)) == value
    assert packed(json_text(value)) == packed_text


def test_what_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match="JSON"):
        json_text([np.nan])


def test_values_reach_the_page_in_display_units(tmp_path: Path) -> None:
    dataset = synthetic_map(grid(x=6, y=5))
    data = report_of(dataset, tmp_path).data
    assert data["shape"] == [6, 5]
    assert data["axes"][0]["values"] == pytest.approx([-150, -90, -30, 30, 90, 150])
    shown = numbers(data["values"]['["deflection_xy","refined","push"]'])
    expected = dataset["deflection_xy"].sel(model="refined", load="push").values.ravel()
    np.testing.assert_allclose(shown, expected * 1e6, rtol=1e-6)
    status = dataset["status"].sel(model="refined").values.ravel()
    assert data["status"]["refined"] == "".join(map(str, status))
    names = [other["name"] for other in data["others"]]
    assert names == ["motor_left.rz", "motor_right.rz", "slide.z"]
    angle = numbers(data["others"][0]["data"])
    np.testing.assert_allclose(angle, np.degrees(dataset["joint"].values[0].ravel()), rtol=1e-6)


def test_worst_postures_are_ranked_from_all_postures() -> None:
    dataset = synthetic_map(grid(x=200, y=150))
    payload = payload_of(dataset)
    assert np.prod(payload["shape"]) <= 20_000
    rows = payload["worst"]['["deflection_xy","refined","push"]']
    values = dataset["deflection_xy"].sel(model="refined", load="push")
    worst = values.where(values == values.max(), drop=True)
    assert len(rows) == 10
    assert rows[0]["at"] == pytest.approx([float(worst.x[0]) * 1e3, float(worst.y[0]) * 1e3])
    least = payload["worst"]['["stiffness_translation_min","refined",""]'][0]
    assert float(least["value"]) == pytest.approx(
        float(dataset["stiffness_translation_min"].sel(model="refined").min()) / 1e6, rel=1e-3
    )


def test_worst_postures_stand_at_the_places_of_the_grid() -> None:
    dataset = synthetic_map(grid(x=5, y=4))
    # A solved pose misses the one that was asked for by rounding.
    dataset["tool"].values -= 5.5e-17
    payload = payload_of(dataset)
    places = [axis["values"] for axis in payload["axes"]]
    assert 0.0 in places[0]
    for rows in payload["worst"].values():
        assert all(x in places[0] and y in places[1] for x, y in (row["at"] for row in rows))


def test_worst_postures_leave_out_what_is_no_number() -> None:
    values = np.array([[1.0, np.nan], [np.inf, 3.0]])
    assert worst_postures(values, worst_is_largest=True) == [3, 0]
    assert worst_postures(values, worst_is_largest=False, count=1) == [0]
    assert worst_postures(np.full(3, np.nan), worst_is_largest=True) == []


@given(
    shape=st.lists(st.integers(1, 60), min_size=1, max_size=4).map(tuple),
    limit=st.integers(1, 500),
)
def test_blocks_are_few_enough_and_no_larger_than_need_be(
    shape: tuple[int, ...], limit: int
) -> None:
    sizes = block_sizes(shape, limit)
    counts = [-(-n // size) for n, size in zip(shape, sizes, strict=True)]
    assert np.prod(counts) <= limit
    if np.prod(shape) <= limit:
        assert set(sizes) == {1}


@given(
    values=hnp.arrays(
        np.float64,
        hnp.array_shapes(min_dims=1, max_dims=3, max_side=9),
        elements=st.one_of(st.floats(-1e3, 1e3), st.just(np.nan)),
    ),
    limit=st.integers(1, 20),
)
def test_no_extreme_value_is_lost_in_blocks(values: np.ndarray, limit: int) -> None:
    blocks = block_sizes(values.shape, limit)
    for largest, extreme in ((True, np.fmax), (False, np.fmin)):
        reduced = worst_of_blocks(values, blocks, worst_is_largest=largest)
        assert reduced.size <= limit
        np.testing.assert_equal(
            extreme.reduce(reduced, axis=None), extreme.reduce(values, axis=None)
        )


def test_blocks_keep_places_and_reasons() -> None:
    assert list(coordinates_of_blocks(np.linspace(0.0, 6.0, 7), 3)) == [1.0, 4.0, 6.0]
    status = np.array([1, 1, 0, 2, 2, 2, 4], dtype=np.int8)
    assert list(status_of_blocks(status, (3,))) == [0, 2, 4]


def test_a_large_map_makes_a_small_page_soon(tmp_path: Path) -> None:
    dataset = synthetic_map(grid(x=700, y=700))
    started = time.perf_counter()
    page = report_of(dataset, tmp_path)
    assert time.perf_counter() - started < 30.0
    assert (tmp_path / "report.html").stat().st_size < 5e6
    assert "blocks of 7 × 6 postures, each block at the worst value" in page.text
    assert "490\u202f000" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_small_maps_are_shown_whole(tmp_path: Path) -> None:
    assert "blocks of" not in report_of(synthetic_map(grid(x=5, y=5)), tmp_path).text


@pytest.mark.parametrize(
    "dataset",
    [
        synthetic_map(grid(y=9)),
        synthetic_map(grid(x=5, y=4, z=3)),
        synthetic_map(grid(x=5, y=4, z=3, rz=3)),
        synthetic_map(grid(x=5, y=4), models=["refined"]),
        synthetic_map({"x": np.linspace(-0.1, 0.1, 6)}, points=True),
        synthetic_map({"x": np.linspace(-0.1, 0.1, 6), "y": np.full(6, 0.375)}, points=True),
    ],
    ids=["1d", "3d", "4d", "one model", "points", "points on a line"],
)
def test_every_kind_of_map_has_a_report(dataset: xr.Dataset, tmp_path: Path) -> None:
    data = report_of(dataset, tmp_path).data
    cells = np.prod(data["shape"])
    assert all(numbers(text).size == cells for text in data["values"].values())
    assert all(len(text) == cells for text in data["status"].values())
    if data["isGrid"]:
        assert [len(axis["values"]) for axis in data["axes"]] == data["shape"]


def test_key_figures_are_best_median_and_worst() -> None:
    dataset = synthetic_map(grid(x=9, y=9))
    rows = {(row.quantity.name, row.load): row for row in key_figures(dataset)}
    push = rows["deflection_xy", "push"]
    values = dataset["deflection_xy"].sel(model="refined", load="push").values
    assert push.spreads["refined"].worst == pytest.approx(np.nanmax(values) * 1e6)
    assert push.spreads["refined"].best == pytest.approx(np.nanmin(values) * 1e6)
    assert push.ratio > 1.0
    stiffness = rows["stiffness_translation_min", None]
    assert stiffness.spreads["refined"].worst < stiffness.spreads["refined"].best
    rigid = rows["stiffness_rotation_min", None]
    assert np.isinf(rigid.spreads["simplified"].worst)
    assert np.isnan(rigid.ratio)
    # Neither model moves along z under a push in the plane.
    assert ("deflection_z", "push") not in rows


def test_models_with_different_status_are_told_apart() -> None:
    dataset = synthetic_map(grid(x=5, y=5))
    dataset["status"][:] = 0
    assert status_in_words(dataset) == ["All 25 postures have an answer."]
    dataset["status"].loc[{"model": "simplified", "x": 0.0, "y": 0.375}] = 2
    sentences = status_in_words(dataset)
    assert sentences[0] == "Refined model: all 25 postures have an answer."
    assert sentences[2].startswith("Simplified model: 1 (4 %) is singular")


def test_words_for_loads_scope_and_lists() -> None:
    assert load_in_words([0, 0, 9.81, 0, 0, 0]) == "force (0, 0, 9.81) N"
    assert load_in_words([1, 0, 0, 0, 0, 2]) == "force (1, 0, 0) N and moment (0, 0, 2) N m"
    assert load_in_words([0] * 6) == "no load"
    points = synthetic_map({"x": np.zeros(3), "y": np.full(3, 0.375)}, points=True)
    assert scope_in_words(points) == "3 given postures"
    dataset = xr.Dataset(attrs={"a": "one", "b": ["one", "two"], "c": [], "d": ""})
    lists = [texts_of(dataset, name) for name in "abcde"]
    assert lists == [["one"], ["one", "two"], [], [], []]


def test_a_map_without_any_answer_has_a_report(tmp_path: Path) -> None:
    dataset = synthetic_map(grid(x=5, y=5))
    dataset["status"][:] = 1
    page = report_of(dataset, tmp_path)
    assert "0 of 25 postures have an answer. 25 (100 %) are out of reach" in page.text


def test_files_that_cannot_be_read_or_written_are_named(tmp_path: Path) -> None:
    dataset = synthetic_map(grid(x=3))
    with pytest.raises(OutputError, match=re.escape("cannot write the report")):
        write_report(dataset, SUMMARY, tmp_path / "missing" / "report.html")
    with pytest.raises(OutputError, match=re.escape("cannot read the figure")):
        write_report(dataset, SUMMARY, tmp_path / "report.html", [tmp_path / "missing.svg"])


def test_plotly_is_imported_only_when_a_report_is_written() -> None:
    code = "import stiffkit.report, sys; sys.exit('plotly' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
