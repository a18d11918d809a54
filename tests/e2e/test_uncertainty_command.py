"""``stiffkit uncertainty``: the tables, JSON, the dataset, figures and the report."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from .commandline import output_of, refusal_of, run
from .identification import write_identification

STUDY = """\
uncertainty: Five-bar from the workshop
robot: five-bar
parameters:
  proximal: {tolerance: 0.1 mm}
links:
  left_arm: {sigma: 2 %}
quantities:
  weakest: stiffness_translation_min
  push: {deflection_translation: push}
postures: 20
samples: 30
models: [refined, simplified]
"""

BEAM = """\
robot: One beam
links:
  beam: {compliance: out/beam.link.yaml}
joints:
  root: {prismatic: z, from: base, to: beam.base, drive: rigid}
tool: {at: beam.tip}
home: {z: 0}
workspace: {z: [-10 mm, 10 mm]}
loads:
  down: {force: [0, 0, -1 N]}
"""


@pytest.fixture
def here(tmp_path: Path) -> Path:
    (tmp_path / "shop.yaml").write_text(STUDY, encoding="utf-8")
    return tmp_path


def test_everything_is_written(here: Path) -> None:
    told = output_of("uncertainty", "shop.yaml", "-o", "out", cwd=here)
    assert "Five-bar from the workshop, refined model" in told
    assert "Five-bar from the workshop, simplified model" in told
    assert "of 30 robots drawn at random" in told
    assert "which part to stiffen first, for push" in told
    assert "open out/report.html" in told
    import xarray as xr

    with xr.open_dataset(here / "out" / "uncertainty.nc", engine="h5netcdf") as dataset:
        assert dataset["push_sigma"].attrs["units"] == "m"
        assert dataset.sizes["source"] == 2
    figures = {path.stem for path in (here / "out" / "figures").glob("*.png")}
    expected = {"map-weakest-refined", "map-push-simplified", "band-push", "ranking-push"}
    assert expected | {"sources-refined", "check-refined", "check-simplified"} <= figures
    assert {path.stem for path in (here / "out" / "figures").glob("*.svg")} == figures
    page = (here / "out" / "report.html").read_text(encoding="utf-8")
    assert "proximal: 200 mm, within ± 0.1 mm, evenly distributed" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert not list(here.rglob("*.partial"))


def test_earlier_results_are_replaced_and_other_files_kept(here: Path) -> None:
    less = STUDY.replace("[refined, simplified]", "[refined]").replace("samples: 30", "samples: 0")
    (here / "shop.yaml").write_text(less, encoding="utf-8")
    (here / "out").mkdir()
    for name in ("uncertainty.nc", "notes.txt"):
        (here / "out" / name).write_text("before", encoding="utf-8")
    told = output_of("uncertainty", "shop.yaml", "-o", "out", cwd=here)
    assert "drawn at random" not in told
    assert (here / "out" / "uncertainty.nc").stat().st_size > 1000
    assert (here / "out" / "notes.txt").read_text(encoding="utf-8") == "before"
    assert not list((here / "out" / "figures").glob("check*"))


def test_json_says_the_same(here: Path) -> None:
    found = json.loads(output_of("uncertainty", "shop.yaml", "--json", cwd=here))
    assert [p.name for p in here.iterdir()] == ["shop.yaml"]
    first = found["quantities"][0]
    assert (first["name"], first["model"], first["units"]) == ("weakest", "refined", "N/m")
    assert sum(first["causes"].values()) == pytest.approx(1.0)
    assert sum(part["share"] for part in found["parts"]["push"]) == pytest.approx(1.0)
    assert 0.5 < first["coverage"]["lowest"] <= first["coverage"]["highest"] <= 1.0
    of_drives = next(q for q in found["quantities"] if q["model"] == "simplified")
    assert of_drives["causes"]["left_arm"] == 0.0


def test_from_a_displacement_field_to_a_band(tmp_path: Path) -> None:
    write_identification(tmp_path)
    output_of("identify", "beam.yaml", "-o", "out", cwd=tmp_path)
    (tmp_path / "one-beam.yaml").write_text(BEAM, encoding="utf-8")
    study = "uncertainty: Beam\nrobot: one-beam.yaml\nsamples: 400\npostures: 3\n"
    (tmp_path / "study.yaml").write_text(study, encoding="utf-8")
    found = json.loads(output_of("uncertainty", "study.yaml", "--json", cwd=tmp_path))
    sag = next(q for q in found["quantities"] if q["name"] == "deflection_down")
    assert sag["causes"] == {"beam": pytest.approx(1.0)}
    # The file's covariance of k33, two-sided 95 %, under 1 N.
    link = yaml.safe_load((tmp_path / "out" / "beam.link.yaml").read_text(encoding="utf-8"))
    sigma = link["covariance"][6 * 2 + 2][6 * 2 + 2] ** 0.5
    assert sag["mean"]["half_width"] == pytest.approx(1.959964 * sigma, rel=1e-3)
    assert sag["coverage"]["mean"] == pytest.approx(0.95, abs=0.05)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("five-bar\n", "five-bra\n", "no robot 'five-bra'"),
        ("proximal:", "proxima:", "no parameter 'proxima'"),
        ("0.1 mm", "0 mm", "must be above zero"),
        ("sigma: 2 %", "sigma: -2 %", "is not between 0 and 100 %"),
        ("{sigma: 2 %}", "identified", "was not identified"),
        ("left_arm", "left_leg", "no link 'left_leg'"),
        ("stiffness_translation_min", "stifness", "'stifness' is no quantity"),
        ("translation: push", "translation: pull", "no load case 'pull'"),
        ("samples: 30", "samples: many", "many"),
        ("uncertainty: Five", "doubt: Five", "'doubt'"),
    ],
)
def test_what_is_wrong_is_told_at_once(here: Path, old: str, new: str, told: str) -> None:
    assert old in STUDY
    (here / "shop.yaml").write_text(STUDY.replace(old, new, 1), encoding="utf-8")
    message = refusal_of("uncertainty", "shop.yaml", "-o", "out", cwd=here)
    assert told in message
    assert "shop.yaml" in message
    assert not (here / "out").exists()


def test_other_things_that_are_wrong(here: Path) -> None:
    assert "nowhere.yaml" in refusal_of("uncertainty", "nowhere.yaml", cwd=here)
    (here / "out").mkdir()
    (here / "out" / "report.html").write_text("mine", encoding="utf-8")
    message = refusal_of("uncertainty", "shop.yaml", "-o", "out", cwd=here)
    assert "is there already" in message
    assert (here / "out" / "report.html").read_text(encoding="utf-8") == "mine"


def test_the_schema_is_printed(here: Path) -> None:
    schema = json.loads(output_of("schema", "uncertainty", cwd=here))
    assert "parameters" in schema["properties"]
    assert run("uncertainty", "--help", cwd=here).returncode == 0
