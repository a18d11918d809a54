"""The report of a design study: what it says, and that it needs no other place."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
import xarray as xr
from synthetic_designs import (  # type: ignore[import-not-found]
    infeasible,
    many_objectives,
    one_objective,
    one_parameter,
    two_objectives,
)
from synthetic_map import grid, synthetic_map  # type: ignore[import-not-found]

from stiffkit.errors import OutputError
from stiffkit.plots import style
from stiffkit.plots.designs import designs_of
from stiffkit.report import write_design_report
from stiffkit.report.design_page_words import comparison_in_words, outcome_in_words
from stiffkit.report.pictures import figure


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make pictures coarse, which is many times faster."""
    monkeypatch.setattr(style, "DPI", 50)


def text_of(page: str) -> str:
    """Return what a reader sees of a page, on one line."""
    body = page[page.index("<body>") :]
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", body)).split())


def report_of(dataset: xr.Dataset, folder: Path) -> str:
    return write_design_report(dataset, folder).read_text(encoding="utf-8")


def test_the_page_says_what_came_out(tmp_path: Path) -> None:
    dataset = two_objectives()
    page = report_of(dataset, tmp_path)
    text = text_of(page)
    designs = designs_of(dataset)
    own = designs.chosen["refined"]
    deflection = 1e6 * dataset["largest_deflection"].values[0]
    assert f"{deflection[own]:.2f} µm instead of 15 µm (−30 %)" in text
    for part in (
        "Legs of the synthetic machine",
        "300 designs were tried",
        "wall, wall of the legs: from 2.007 mm to 7.985 mm",
        "gear, size of the gear: from 3 to 6, whole numbers",
        "lowest frequency: above 40 Hz",
        "At an end of its range: gear (highest, 6).",
        "The choice of the simplified model, judged by the refined one",
        "Front (18 designs) by the refined model",
        "geometries evaluated",
        "60 3.8",
        "SHA-256 of the robot file",
        "postures, each design 400",
    ):
        assert part in text
    assert (tmp_path / "figures" / "tradeoff.png").is_file()


def test_the_simplified_models_choice_is_judged_by_the_refined_one() -> None:
    dataset = two_objectives()
    designs = designs_of(dataset)
    own, foreign = designs.chosen["refined"], designs.chosen["simplified"]
    sentences = comparison_in_words(designs)
    values = dataset["largest_deflection"].values
    assert (
        f"The simplified model chooses design {foreign}, the refined model design {own}:"
        in (sentences[0])
    )
    worse = 100.0 * (values[0, foreign] / values[0, own] - 1.0)
    assert sentences[1] == (
        f"Largest deflection of design {foreign}: the simplified model promises "
        f"{1e6 * values[1, foreign]:.3f} µm, the refined model finds "
        f"{1e6 * values[0, foreign]:.2f} µm, {worse:.2g} % worse than the "
        f"{1e6 * values[0, own]:.2f} µm of design {own}."
    )
    assert sentences[-1] == "By the refined model it keeps all bounds."
    dataset["lowest_frequency"].values[0, foreign] = 35.0
    assert comparison_in_words(designs_of(dataset))[-1] == (
        "By the refined model it breaks a bound: lowest frequency 35 Hz, above 40 Hz was asked."
    )
    dataset.attrs["chosen"] = json.dumps({"refined": own, "simplified": own})
    assert comparison_in_words(designs_of(dataset)) == [
        f"Both models choose the same design, design {own}."
    ]


def test_what_holds_a_design_back_is_told() -> None:
    dataset = one_objective()
    designs = designs_of(dataset)
    chosen = designs.chosen["refined"]
    dataset["mass"].values[0, chosen] = 61.9
    dataset["mass"].values[0, 0] = 67.0
    sentences = outcome_in_words(designs_of(dataset), "refined")
    assert f"Design {chosen}, found by gradients, the best one." in sentences
    assert "At its bound: mass below 62 kg." in sentences
    assert "The start breaks a bound: mass 67 kg, below 62 kg was asked." in sentences
    dataset.attrs["chosen"] = json.dumps({"refined": 0})
    assert outcome_in_words(designs_of(dataset), "refined")[0] == (
        "None of the designs is better than the start."
    )


def test_where_nothing_is_feasible_the_clash_is_told(tmp_path: Path) -> None:
    text = text_of(report_of(infeasible(), tmp_path))
    assert "What clashes no design keeps all bounds: lowest_frequency above 400 Hz" in text
    assert "of these keep all bounds: none by the refined model, none by the simplified" in text
    assert "No design keeps all bounds by the refined model, so none is chosen." in text
    assert "75 breaks its bound" in text


def test_the_page_needs_no_other_place_and_is_small(tmp_path: Path) -> None:
    maps = {"start": synthetic_map(grid(x=40, y=40)), "chosen": synthetic_map(grid(x=40, y=40))}
    path = write_design_report(two_objectives(3000), tmp_path, maps)
    page = path.read_text(encoding="utf-8")
    assert "default-src 'none'" in page
    assert "<script" not in page
    assert not re.findall(r"(?:src|href)=\"(?!data:)", page)
    assert len(page) < 1_000_000
    assert "Over the workspace" in page
    assert "More (3)" in page


def test_a_drawing_larger_than_its_picture_is_shown_as_that(tmp_path: Path) -> None:
    drawing, picture = tmp_path / "any.svg", tmp_path / "any.png"
    drawing.write_text("<svg>font: 7px 'DejaVu Sans'</svg>")
    picture.write_bytes(b"png")
    assert "data:image/png;base64,cG5n" in figure(drawing)
    picture.write_bytes(b"png" * 100)
    shown = re.fullmatch(r'.*image/svg\+xml,(.*)">.*', figure(drawing))
    assert shown is not None
    # Where the font is not installed there is one of the same widths.
    assert "'DejaVu Sans', Verdana" in unquote(html.unescape(shown[1]))
    drawing.unlink()
    with pytest.raises(OutputError, match="cannot read the figure"):
        figure(drawing)


def test_names_from_files_are_text(tmp_path: Path) -> None:
    dataset = one_objective()
    dataset.attrs["title"] = "<b>Legs</b> & more"
    dataset.attrs["message"] = "<i>clash</i>"
    dataset["L1"].attrs["long_name"] = "<script>alert(1)</script>"
    dataset["worst_deflection"].attrs["long_name"] = "a < b"
    page = report_of(dataset, tmp_path)
    for markup in ("<b>Legs", "<i>clash", "<script>"):
        assert markup not in page
    assert "<b>Legs</b> & more" in text_of(page)


def test_of_a_large_front_the_first_are_listed(tmp_path: Path) -> None:
    dataset = two_objectives()
    dataset["front"].values[0, :120] = 1
    page = report_of(dataset, tmp_path)
    table = page[page.index("Front (") :]
    table = table[: table.index("</table>")]
    assert table.count("<tr") == 1 + 1 + 50
    assert "more are in the dataset." in page


@pytest.mark.parametrize(
    ("make", "models"), [(one_parameter, [0, 1]), (many_objectives, [0]), (one_objective, [1])]
)
def test_every_kind_of_study_has_a_page(
    make: Callable[[], xr.Dataset], models: list[int], tmp_path: Path
) -> None:
    dataset = make().isel(model=models)
    chosen = json.loads(dataset.attrs["chosen"])
    names = [str(name) for name in dataset["model"].values]
    dataset.attrs["chosen"] = json.dumps({name: chosen[name] for name in names})
    page = report_of(dataset, tmp_path)
    assert ("judged by the refined one" in page) == (len(models) == 2)


def test_options_and_derived_parameters_stand_in_the_tables(tmp_path: Path) -> None:
    dataset = one_objective()
    count = dataset.sizes["design"]
    about = {"kind": "derived", "units": "m", "low": 0.0, "high": 1.0}
    dataset["gap"] = ("design", 2.0 * dataset["L1"].values, about)
    words = np.array([f"tube {i}" for i in range(count)], dtype=object)
    dataset["section"] = ("design", words, {"long_name": "option"})
    text = text_of(report_of(dataset, tmp_path))
    chosen = json.loads(dataset.attrs["chosen"])["refined"]
    assert "gap, which follows from the others" in text
    assert "gap follows mm 1900" in text
    assert f"section choice tube 0 tube {chosen}" in text


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot make the folder"):
        write_design_report(one_objective(), tmp_path / "file")
