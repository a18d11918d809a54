"""Every kind of page is sound HTML, keeps to itself, and says what it can without its script."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from synthetic_designs import two_objectives  # type: ignore[import-not-found]
from synthetic_map import grid, synthetic_map  # type: ignore[import-not-found]
from tests.e2e.identification import write_identification
from tests.unit.page_reader import StrictReader
from tests.unit.test_uncertainty_pictures import study

from stiffkit.identify import identify_link, read_spec
from stiffkit.plots import style, write_figures, write_uncertainty_figures
from stiffkit.report import (
    write_design_report,
    write_identify_page,
    write_modes_page,
    write_report,
    write_uncertainty_page,
)
from stiffkit.report.reproduction_page import (
    PageRow,
    PageTable,
    PaperOnPage,
    write_reproduction_page,
)
from stiffkit.robot import load_robot
from stiffkit.study import analyse_modes

PART = """\
link: Bar
cad: bar.step
material: steel
base: {faces: {near: [0, 5 mm, 5 mm]}, interface: clamped}
tip: {faces: {near: [60 mm, 5 mm, 5 mm]}, interface: average}
modes: 0
mesh: {size: 10 mm, order: 2}
"""

STATEMENT = PageRow("Table 2", "1.5", "1.5 < 2", "0 %", "agrees")


def make_map(folder: Path, page: Path) -> None:
    dataset = synthetic_map(grid(x=6, y=5))
    write_report(dataset, [("links", "4")], page, write_figures(dataset, folder / "figures"))


def make_volume(folder: Path, page: Path) -> None:
    write_report(synthetic_map(grid(x=4, y=3, z=3)), [], page)


def make_design(folder: Path, page: Path) -> None:
    write_design_report(two_objectives(), folder).rename(page)


def make_uncertainty(folder: Path, page: Path) -> None:
    dataset = study()
    write_uncertainty_page(dataset, write_uncertainty_figures(dataset, folder / "figures"), page)


def make_modes(folder: Path, page: Path) -> None:
    write_modes_page(analyse_modes(load_robot("biglide"), n=3), page)


def make_identified(folder: Path, page: Path) -> None:
    write_identify_page(identify_link(read_spec(write_identification(folder))), page)


def make_link(folder: Path, page: Path) -> None:
    shapes = pytest.importorskip("netgen.occ")
    from stiffkit.fea import link_from_cad
    from stiffkit.plots import write_link_figures
    from stiffkit.report import write_link_page

    shapes.Box((0, 0, 0), (60, 10, 10)).WriteStep(str(folder / "bar.step"))
    (folder / "bar.yaml").write_text(PART, encoding="utf-8")
    link = link_from_cad(folder / "bar.yaml")
    write_link_page(link, write_link_figures(link, folder / "figures"), page)


def make_reproduction(folder: Path, page: Path) -> None:
    figure = style.new_figure(style.COLUMN, style.COLUMN)
    figure.add_subplot().plot([0.0, 1.0], [0.0, 1.0])
    drawings = [path for path in style.save(figure, folder / "figure-3") if path.suffix == ".svg"]
    tables = [PageTable("What the text says", (STATEMENT,))]
    paper = PaperOnPage("Author 2009", "A. Author, a journal, 2009", tables, drawings)
    write_reproduction_page([paper, paper], "stiffkit reproduce", page)


KINDS = (
    make_map,
    make_volume,
    make_design,
    make_uncertainty,
    make_modes,
    make_identified,
    make_link,
    make_reproduction,
)
SCRIPTED = {make_map, make_volume, make_modes, make_identified}


@pytest.mark.parametrize("make", KINDS, ids=lambda make: make.__name__.removeprefix("make_"))
def test_every_kind_of_page_is_sound(
    make: Callable[[Path, Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(style, "DPI", 40)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path = tmp_path / "page.html"
    make(tmp_path, path)
    page = path.read_text(encoding="utf-8")
    reader = StrictReader(page)
    assert reader.faults == []
    assert "<h2>How this was made</h2>" in page
    assert '<th scope="row">stiffkit version</th>' in page or "stiffkit 0.1.0</td>" in page
    assert "default-src 'none'" in page
    assert not re.search(r'(?:src|href)="(?!data:)|https?://', page)
    assert path.stat().st_size < 3e6
    if make in SCRIPTED:
        assert page.count('class="needs-script"') + page.count(" needs-script") > 0
        assert page.count('<p class="notice"') == 2
        assert re.search(r"<head>.*<noscript><style>.*</head>", page, re.DOTALL)
    else:
        assert "<script" not in page


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ("<p><b>bold</p></b>", "closes nothing"),
        ("<div>", "closes nothing"),
        ('<img src="data:,">', "no alternative text"),
        ('<p id="a"></p><p id="a"></p>', "not the only one"),
        ('<section aria-labelledby="b"></section>', "nothing has the id 'b'"),
        ("<select></select>", "a control without a label"),
        ("<h3>deep</h3>", "a level of headings"),
        ("<p><div></div></p>", "a block in a paragraph"),
        ("<table><tbody><tr>text</tr></tbody></table>", "text in tr"),
    ],
)
def test_the_strict_reader_hears_what_is_wrong(body: str, fault: str) -> None:
    """Without this, its silence over the pages would say nothing."""
    around = (
        '<!DOCTYPE html>\n<html lang="en"><head><title>t</title></head><body><header><h1>t</h1>'
        "</header><main>{}</main><footer></footer></body></html>"
    )
    assert StrictReader(around.format("")).faults == []
    assert any(fault in told for told in StrictReader(around.format(body)).faults)


def test_lines_of_drawings_keep_their_places() -> None:
    from stiffkit.report.pictures import _path

    assert _path("M 1.25678 -2 \nL 1e-7 3.5 \nz\n") == "M1.26-2L0,3.5z"
    places = np.linspace(-1e3, 1e3, 7) / 3.0
    written = _path("M " + " ".join(f"{x:.6f}" for x in places))
    read = [float(x) for x in re.findall(r"-?[\d.]+", written)]
    np.testing.assert_allclose(read, places, atol=5.1e-3)
