"""Study files: what they say, and what is told where they are wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffkit.errors import FileError
from stiffkit.study.sweep import StudySpec, read_study
from stiffkit.study.sweep.sampling import parameter_values

HEAD = "study: Arms\nrobot: five-bar\n"
VARY = "vary:\n  proximal: {from: 180 mm, to: 220 mm, count: 5}\n  base: [300 mm, = 1.1 * base]\n"


def read(tmp_path: Path, text: str) -> StudySpec:
    path = tmp_path / "arms.yaml"
    path.write_text(text, encoding="utf-8")
    return read_study(path)


def test_a_grid_takes_every_combination_in_turn(tmp_path: Path) -> None:
    spec = read(tmp_path, HEAD + VARY)
    assert spec.n_geometries == 10
    values = parameter_values(spec, np.arange(10))
    np.testing.assert_allclose(values[0, ::2], [0.18, 0.19, 0.2, 0.21, 0.22])
    np.testing.assert_allclose(values[1, :4], [0.3, 0.33, 0.3, 0.33])
    np.testing.assert_array_equal(parameter_values(spec, np.array([7])), values[:, 7:8])


def test_a_latin_hypercube_fills_every_slice_once(tmp_path: Path) -> None:
    ranges = "vary:\n  proximal: {from: 180 mm, to: 220 mm}\n  base: {from: 0.3, to: 0.4}\n"
    sampling = "sampling: {latin hypercube: 50, seed: 3}\n"
    spec = read(tmp_path, HEAD + ranges + sampling)
    values = parameter_values(spec, np.arange(50))
    for row, (low, high) in zip(values, [(0.18, 0.22), (0.3, 0.4)], strict=True):
        slices = np.floor((row - low) / (high - low) * 50).astype(int)
        assert sorted(slices) == list(range(50))
    other = read(tmp_path, HEAD + ranges + sampling.replace("3", "4"))
    assert not np.allclose(parameter_values(other, np.arange(50)), values)


def test_what_is_left_out_has_a_meaning(tmp_path: Path) -> None:
    spec = read(tmp_path, HEAD + VARY)
    assert spec.models == ("refined",)
    assert spec.postures == 1000
    assert spec.frequency_postures == 0
    assert [column.name for column in spec.columns][:2] == ["weakest", "weakest_rotation"]
    assert {c.load for c in spec.columns if c.quantity == "deflection_translation"} == {
        "push",
        "lift",
    }


def test_plain_data_and_back(tmp_path: Path) -> None:
    results = "results:\n  soft: {share above: 20 um, of: deflection_xy, load: push}\n"
    spec = read(tmp_path, HEAD + VARY + results)
    assert StudySpec.from_plain(spec.plain()) == spec
    assert spec.columns[0].value == pytest.approx(2e-5)


def test_a_robot_file_beside_the_study(tmp_path: Path) -> None:
    from stiffkit.robot.catalogue import find_robot

    text = find_robot("five-bar").read_text(encoding="utf-8")
    (tmp_path / "own.yaml").write_text(text, encoding="utf-8")
    spec = read(tmp_path, "study: Arms\nrobot: own.yaml\n" + VARY)
    assert spec.robot == str(tmp_path / "own.yaml")


@pytest.mark.parametrize(
    ("text", "place", "what", "mend"),
    [
        ("study: Arms\nrobot: five-bra\n" + VARY, ":2: robot", "no robot 'five-bra'", "five-bar"),
        (HEAD, "", "'vary' is missing", "vary:"),
        (HEAD + "vary: {proximl: [1]}\n", ":3: vary.proximl", "no parameter 'proximl'", "proximal"),
        (HEAD + "vary: {base: [2 kg]}\n", ":3: vary.base[0]", "is a mass", ""),
        (HEAD + "vary: {base: {from: 1, to: 2}}\n", ":3: vary.base", "'count' is missing", "count"),
        (
            HEAD + "vary: {base: {from: 1, to: 2, count: 2.5}}\n",
            ":3: vary.base.count",
            "no whole number",
            "1000",
        ),
        (
            HEAD + "vary: {base: [1]}\nsampling: {latin hypercube: 5}\n",
            ":3: vary.base",
            "needs a range",
            "from",
        ),
        (HEAD + VARY + "sampling: random\n", ":6: sampling", "no way to choose", "latin hypercube"),
        (
            HEAD + VARY + "results: {a: {min: stifness_translation_min}}\n",
            ":6: results.a.min",
            "no quantity",
            "stiffness_translation_min",
        ),
        (
            HEAD + VARY + "results: {a: {max: deflection_xy}}\n",
            ":6: results.a",
            "under which load?",
            "push",
        ),
        (
            HEAD + VARY + "results: {a: {max: deflection_xy, load: pull}}\n",
            ":6: results.a.load",
            "no load case 'pull'",
            "push",
        ),
        (
            HEAD + VARY + "results: {a: {share above: 2 N, of: deflection_xy, load: push}}\n",
            ":6: results.a.share above",
            "a length is expected",
            "",
        ),
        (
            HEAD + VARY + "results: {a: {percentile: 95}}\n",
            ":6: results.a",
            "percentile of what?",
            "deflection_z",
        ),
        (
            HEAD + VARY + "results: {a: {min: stiffness_rotation_min, max: deflection_z}}\n",
            ":6: results.a",
            "min and max stands here",
            "one of",
        ),
        (
            HEAD + VARY + "results: {base: {min: stiffness_rotation_min}}\n",
            ":6: results.base",
            "name of a parameter",
            "another name",
        ),
        (
            HEAD + VARY + "results: {model: {min: stiffness_rotation_min}}\n",
            ":6: results.model",
            "of its own",
            "another name",
        ),
        (
            HEAD + VARY + "results: {a: {min: frequency_first}}\n",
            ":6: results.a.min",
            "computes no frequencies",
            "frequencies: {postures: 10}",
        ),
        (
            HEAD + VARY + "models: [simplified]\nfrequencies: {postures: 3}\n",
            ":7: frequencies",
            "of the refined model",
            "'refined'",
        ),
    ],
)
def test_what_is_wrong_is_told_with_its_place(
    text: str, place: str, what: str, mend: str, tmp_path: Path
) -> None:
    with pytest.raises(FileError) as caught:
        read(tmp_path, text)
    message = str(caught.value)
    assert f"arms.yaml{place}" in message
    assert what in message
    assert mend in message


def test_too_many_geometries_are_refused(tmp_path: Path) -> None:
    counts = "{from: 0.1, to: 0.2, count: 10000}"
    text = HEAD + f"vary: {{base: {counts}, proximal: {counts}}}\n"
    with pytest.raises(FileError, match="100000000 geometries"):
        read(tmp_path, text)
