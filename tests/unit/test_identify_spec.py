"""Specifications of identifications: what they mean, and what is said where they are wrong."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from tests.unit.identified_beam import CASES, LOADS, TIP, beam_compliance, cube, displaced, face

from stiffkit.errors import FieldError, FileError
from stiffkit.identify import IdentifiedLink, advise_link, as_json, identify_link, read_spec
from stiffkit.identify.spec import SCHEMA_FILE
from stiffkit.link.file import read_link_file
from stiffkit.spatial import axis_rotation
from stiffkit.spatial.rotation import Array

SIGMA = 5e-8


def wrench_of(row: Array) -> dict[str, list[str]]:
    force, moment = [f"{x:g} N" for x in row[:3]], [f"{x:g} N m" for x in row[3:]]
    return {"force": force, "moment": moment}


def content(**changes: Any) -> dict[str, Any]:
    """A specification of the cantilever; changes to None take keys away."""
    whole = {
        "identify": "Cantilever",
        "units": {"length": "mm"},
        "fields": "beam.csv",
        "reference": ["1000 mm", 0, 0],
        "loads": {name: wrench_of(row) for name, row in zip(CASES, LOADS, strict=True)},
    }
    return {key: value for key, value in (whole | changes).items() if value is not None}


def write_table(
    path: Path, points: Array, u: Array, cases: tuple[str, ...] = CASES, scale: float = 1e3
) -> None:
    """Write a table of nodes and displacements, in mm."""
    heads = ["node", "x", "y", "z", *(f"{case}:u{axis}" for case in cases for axis in "xyz")]
    columns = [np.arange(1, len(points) + 1), scale * points, *(scale * u)]
    np.savetxt(path, np.column_stack(columns), "%.12g", ",", header=",".join(heads), comments="")


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """A directory with a field of the end face in ``beam.csv``."""
    points = face()
    u = displaced(points, beam_compliance(), LOADS, SIGMA)
    write_table(tmp_path / "beam.csv", points, u)
    return tmp_path


def write_spec(here: Path, **changes: Any) -> Path:
    path = here / "beam.yaml"
    path.write_text(yaml.safe_dump(content(**changes), sort_keys=False), encoding="utf-8")
    return path


def identified(here: Path, **changes: Any) -> IdentifiedLink:
    return identify_link(write_spec(here, **changes))


def refusal(here: Path, **changes: Any) -> FileError:
    with pytest.raises(FileError) as caught:
        identified(here, **changes)
    assert caught.value.mend or "for example" in caught.value.what
    return caught.value


def scaled_difference(k: Array, expected: Array) -> float:
    size = np.sqrt(np.diag(expected))
    return float(np.max(np.abs(k - expected) / np.outer(size, size)))


# --- what a specification means -------------------------------------------------------------------


def test_compliance_of_the_beam(here: Path) -> None:
    link = identified(here)
    k = beam_compliance()
    error = np.abs(link.compliance - k) / link.standard_error
    assert error.max() < 5.0
    assert link.sigma == pytest.approx(SIGMA, rel=0.05)
    # Of 26 zeros one may stand out by chance.
    assert link.significant[k != 0.0].all()
    assert link.significant[k == 0.0].sum() <= 2
    assert not link.doubts


def test_link_file_holds_all(here: Path) -> None:
    link = identified(here)
    path = here / "beam.link.yaml"
    link.write(path)
    read = read_link_file(path)
    assert read.title == "Cantilever"
    np.testing.assert_array_equal(read.compliance, link.compliance)
    np.testing.assert_array_equal(read.compliance, read.compliance.T)
    np.testing.assert_allclose(read.ports["tip"].position, TIP)
    assert read.covariance is not None
    np.testing.assert_allclose(np.sqrt(np.diag(read.covariance)).reshape(6, 6), link.standard_error)
    told = read.provenance
    table = hashlib.sha256((here / "beam.csv").read_bytes()).hexdigest()
    assert told["fields"] == [{"file": "beam.csv", "sha256": table}]
    assert told["specification"]["sha256"] == link.spec.content_hash
    assert told["node_count"] == 121
    assert told["estimator"] == "lin"
    assert told["sigma"] == link.sigma


def test_link_axes_turn_everything(here: Path) -> None:
    """The same body, exported in axes that are turned and shifted."""
    R, shift = axis_rotation("z", 0.7) @ axis_rotation("x", -0.4), np.array([0.2, -0.1, 0.05])
    points = face() @ R.T + shift
    u = displaced(face(), beam_compliance(), LOADS, SIGMA) @ R.T
    write_table(here / "turned.csv", points, u)
    turned = (LOADS.reshape(-1, 3) @ R.T).reshape(-1, 6)
    base = {"at": shift.tolist(), "rotate": [{"z": "0.7 rad"}, {"x": "-0.4 rad"}]}
    there = identified(
        here,
        fields="turned.csv",
        base=base,
        reference=(R @ TIP + shift).tolist(),
        loads={
            name: {"force": row[:3].tolist(), "moment": row[3:].tolist()}
            for name, row in zip(CASES, turned, strict=True)
        },
    )
    plain = identified(here)
    np.testing.assert_allclose(there.found.reference, TIP, atol=1e-12)
    assert scaled_difference(there.compliance, plain.compliance) < 1e-7
    np.testing.assert_allclose(there.standard_error, plain.standard_error, rtol=1e-5)


def test_loads_act_where_they_say(here: Path) -> None:
    """A force beside the reference point has a moment about it."""
    lever = np.array([0.1, 0.02, -0.03])
    wrenches = LOADS.copy()
    wrenches[1, 3:] = np.cross(lever, LOADS[1, :3])
    write_table(
        here / "lever.csv", face(), displaced(face(), beam_compliance(), wrenches, SIGMA, seed=1)
    )
    loads = content()["loads"]
    loads["Fy"] = {"force": loads["Fy"]["force"], "at": (TIP + lever).tolist()}
    link = identified(here, fields="lever.csv", loads=loads)
    np.testing.assert_allclose(link.wrenches, wrenches, atol=1e-12)
    assert (np.abs(link.compliance - beam_compliance()) < 5.0 * link.standard_error).all()


def test_one_file_for_each_case_and_a_list_of_loads(here: Path) -> None:
    u = displaced(face(), beam_compliance(), LOADS, SIGMA)
    names = []
    for case, one in zip(CASES, u, strict=True):
        names.append(f"{case}_only.csv")
        write_table(here / names[-1], face(), one[None], ("whatever",))
    by_list = identified(here, fields=names, loads=[wrench_of(row) for row in LOADS])
    assert by_list.found.case_names == tuple(f"{case}_only" for case in CASES)
    renamed = [{"file": n, "name": case} for n, case in zip(names, CASES, strict=True)]
    by_name = identified(here, fields=renamed)
    assert by_name.found.case_names == CASES
    np.testing.assert_array_equal(by_name.compliance, by_list.compliance)
    np.testing.assert_array_equal(by_name.compliance, identified(here).compliance)


def test_cases_without_load_are_left_out_and_named(here: Path) -> None:
    u = displaced(face(), beam_compliance(), LOADS, SIGMA)
    write_table(here / "more.csv", face(), np.concatenate([u, u[:1]]), (*CASES, "preload"))
    link = identified(here, fields="more.csv")
    assert any("left out: preload" in note for note in link.notes)
    np.testing.assert_array_equal(link.compliance, identified(here).compliance)


def test_regions_intersect(here: Path) -> None:
    link = identified(
        here,
        select={
            "near": "5.1 mm",
            "box": [["999 mm", 0, "-9 mm"], ["1001 mm", "9 mm", "9 mm"]],
            "layer": {"normal": [2, 0, 0]},
        },
    )
    points = face()
    inside = (np.linalg.norm(points - TIP, axis=1) < 5.1e-3) & (points[:, 1] > -1e-9)
    np.testing.assert_array_equal(link.chosen.field.nodes, np.flatnonzero(inside) + 1)


def test_sets_and_areas_from_a_deck(here: Path) -> None:
    """Node sets and faces come from an input deck, where the table has none."""
    points, count = face(), 11
    lines = ["*NODE", *(f"{i + 1}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(1e3 * points))]
    lines.append("*ELEMENT, TYPE=S4, ELSET=SKIN")
    corners = [(r * count + c + 1) for r in range(count - 1) for c in range(count - 1)]
    lines += [f"{i}, {n}, {n + 1}, {n + 1 + count}, {n + count}" for i, n in enumerate(corners, 1)]
    lines += ["*NSET, NSET=TIP, GENERATE", "1, 121, 1"]
    (here / "beam.inp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    link = identified(here, sets="beam.inp", select={"set": "TIP"}, weights="area")
    assert "100 mm^2 of 100 quad" in link.chosen.weights_words
    weights = link.chosen.field.relative_weights
    assert weights.max() == pytest.approx(4.0 * weights.min())


@pytest.mark.parametrize("estimator", ["lin", "exact", "svd+", "svd-", "svd+-"])
def test_estimators(here: Path, estimator: str) -> None:
    link = identified(here, estimator=estimator)
    assert as_json(link)["estimator"] == estimator
    others = {other.name for other in link.alternatives}
    assert others == {"lin", "exact", "svd+", "svd-", "svd+-"} - {estimator}
    assert scaled_difference(link.compliance, beam_compliance()) < 1e-3


@pytest.mark.parametrize(
    ("given", "treatment", "percent"),
    [("keep", "keep", 10.0), ({"drop": "5 %"}, "drop", 5.0), ({"drop": 0.2}, "drop", 20.0)],
)
def test_outliers(here: Path, given: Any, treatment: str, percent: float) -> None:
    options = read_spec(write_spec(here, outliers=given)).options
    assert (options.outliers, options.drop_percent) == (treatment, percent)


def test_planted_outliers_are_named(here: Path) -> None:
    u = displaced(face(), beam_compliance(), LOADS, SIGMA)
    u[2, [0, 10, 110], 2] += 2e-6
    write_table(here / "beam.csv", face(), u)
    robust = identified(here, outliers="robust")
    assert robust.found.outliers is not None
    assert set(robust.found.outliers.nodes[2]) == {1, 11, 111}
    before = next(other for other in robust.alternatives if other.name == "with outliers")
    assert before.sigma > 1.5 * robust.sigma
    k = beam_compliance()
    assert scaled_difference(robust.compliance, k) < scaled_difference(before.compliance, k)


def test_confidence_and_sigma(here: Path) -> None:
    options = read_spec(write_spec(here, confidence="95 %", sigma="each")).options
    assert options.level == pytest.approx(0.95)
    assert not options.pooled
    assert read_spec(write_spec(here, confidence=0.9)).options.level == 0.9


def test_cleaned(here: Path) -> None:
    link = identified(here, clean=True)
    assert ((link.compliance != 0.0) == link.significant).all()
    assert (link.compliance == 0.0).sum() >= 24
    link.write(here / "beam.link.yaml")
    assert read_link_file(here / "beam.link.yaml").provenance["cleaned"] is True


def test_as_estimated(here: Path) -> None:
    link = identified(here, symmetrize=False)
    np.testing.assert_array_equal(link.compliance, link.found.compliance)
    assert any("no robot can take it so" in note for note in link.notes)


def test_one_layer_beside_a_volume(here: Path) -> None:
    points = cube(5)
    write_table(here / "cube.csv", points, displaced(points, beam_compliance(), LOADS, SIGMA))
    link = identified(
        here,
        fields="cube.csv",
        select={"layer": {"normal": [1, 0, 0]}},
        compare={"volume": {"select": {"near": "9 mm"}}, "same": {"weights": "equal"}},
    )
    volume, same = link.alternatives[-2:]
    np.testing.assert_array_equal(same.compliance, link.compliance)
    assert (link.found.node_count, volume.name, volume.node_count) == (25, "volume", 125)
    assert scaled_difference(volume.compliance, beam_compliance()) < 1e-3


def test_displacements_have_a_unit_of_their_own(here: Path) -> None:
    u = displaced(face(), beam_compliance(), LOADS, SIGMA)
    write_table(here / "um.csv", face(), 1e3 * u)
    link = identified(here, fields="um.csv", units={"length": "mm", "displacement": "um"})
    assert scaled_difference(link.compliance, identified(here).compliance) < 1e-9


def test_advice_from_a_specification_and_from_a_link_file(here: Path) -> None:
    spec = write_spec(here)
    own = advise_link(spec)
    assert [advice.load for advice in own.loads] == ["Fx", "Fy", "Fz", "Mx", "My", "Mz"]
    identify_link(spec).write(here / "beam.link.yaml")
    # The paper's field: 0.01 to 0.2 degrees for 0.2 % (section 3.5).
    paper = advise_link(here / "beam.link.yaml", sigma=5e-8, size=0.01, count=1331)
    bending = paper.loads[4]
    turns = np.degrees(0.006 * np.array([bending.lowest, bending.highest]))
    assert turns == pytest.approx([0.01, 0.2], rel=0.2)
    with pytest.raises(FieldError, match="how its deflections will be read"):
        advise_link(here / "beam.link.yaml")
    with pytest.raises(FieldError, match="no cubic field"):
        advise_link(here / "beam.link.yaml", sigma=5e-8, size=0.01, count=3)


# --- what is said where it is wrong ---------------------------------------------------------------


def test_too_few_cases(here: Path) -> None:
    loads = content()["loads"]
    del loads["Mz"]
    told = refusal(here, loads=loads)
    assert "only 5 load cases" in told.what
    assert "Mz" in told.what
    assert told.key == "loads"
    assert told.line is not None


def test_dependent_loads(here: Path) -> None:
    loads = content()["loads"] | {"Mz": wrench_of(2.0 * LOADS[1])}
    told = refusal(here, loads=loads)
    assert "dependent" in told.what
    assert told.key == "loads"


def test_load_of_no_case(here: Path) -> None:
    told = refusal(here, loads=content()["loads"] | {"Fyy": wrench_of(LOADS[1])})
    assert told.key == "loads.Fyy"
    assert "did you mean" in told.mend


def test_load_that_is_zero(here: Path) -> None:
    told = refusal(here, loads=content()["loads"] | {"Fy": {"force": [0, 0, 0]}})
    assert "load case Fy has no load" in told.what


def test_list_of_loads_of_another_length(here: Path) -> None:
    told = refusal(here, loads=[wrench_of(row) for row in LOADS[:4]])
    assert "4 loads and 6 load cases" in told.what


def test_moment_for_a_force(here: Path) -> None:
    told = refusal(here, loads=content()["loads"] | {"Fy": {"force": [0, "1 N m", 0]}})
    assert told.key == "loads.Fy.force[1]"


def test_mismatched_nodes(here: Path) -> None:
    points, u = face(), displaced(face(), beam_compliance(), LOADS, SIGMA)
    write_table(here / "first.csv", points, u[:3], CASES[:3])
    write_table(here / "second.csv", points[:-2], u[3:, :-2], CASES[3:])
    told = refusal(here, fields=["first.csv", "second.csv"])
    assert "only in one of" in told.what
    assert told.key == "fields"


def test_nan_displacements(here: Path) -> None:
    lines = (here / "beam.csv").read_text(encoding="utf-8").splitlines()
    cells = lines[7].split(",")
    lines[7] = ",".join([*cells[:5], "nan", *cells[6:]])
    (here / "beam.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    told = refusal(here)
    assert told.path.name == "beam.csv"
    assert "node 7" in told.what


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"units": {"length": "m", "displacement": "mm"}, "reference": [1000, 0, 0]}, "span|times"),
        ({"units": {"length": "mm", "displacement": "m"}}, "displacements"),
        ({"units": {"length": "um"}, "reference": [0.001, 0, 0]}, "span|times|levers"),
    ],
)
def test_units_wrong_by_a_thousand_are_doubted(
    here: Path, changes: dict[str, Any], word: str
) -> None:
    link = identified(here, **changes)
    assert link.doubts, word
    assert any(part in doubt for doubt in link.doubts for part in word.split("|")), link.doubts


def test_moments_wrong_by_a_thousand_are_doubted(here: Path) -> None:
    rows = LOADS * np.repeat([1.0, 1e3], 3)
    loads = {name: wrench_of(row) for name, row in zip(CASES, rows, strict=True)}
    link = identified(here, loads=loads)
    assert any("moments" in doubt for doubt in link.doubts)


def test_displacements_too_small_by_a_thousand_are_doubted(here: Path) -> None:
    """No body of this size is so stiff."""
    ends = np.array([[x, y, z] for x in (0.0, 1.0) for y in (-5e-3, 5e-3) for z in (-5e-3, 5e-3)])
    points = np.concatenate([ends[:4], face()])
    u = 1e-3 * displaced(points, beam_compliance(), LOADS)
    u[:, :4] = 0.0
    write_table(here / "stiff.csv", points, u)
    select = {"layer": {"normal": [1, 0, 0]}}
    link = identified(here, fields="stiff.csv", select=select)
    assert any("diamond" in doubt for doubt in link.doubts)
    write_table(here / "right.csv", points, 1e3 * u)
    assert not identified(here, fields="right.csv", select=select).doubts


def test_reference_in_another_unit_is_doubted(here: Path) -> None:
    link = identified(here, reference=["1000 m", 0, 0])
    assert any("reference point" in doubt for doubt in link.doubts)


def test_empty_selection(here: Path) -> None:
    told = refusal(here, select={"near": "10 um", "layer": {"normal": [0, 0, 1], "at": [0, 0, 9]}})
    assert "no node is selected" in told.what
    assert told.key == "select"


def test_unknown_set(here: Path) -> None:
    told = refusal(here, select={"set": "TIP"})
    assert "no node set 'TIP'" in told.what
    assert told.key == "select"


def test_nodes_on_a_line(here: Path) -> None:
    told = refusal(here, select={"nodes": [1, 2, 3]})
    assert told.key == "select"


def test_areas_without_elements(here: Path) -> None:
    told = refusal(here, weights="area")
    assert "no face" in told.what


def test_truncated_field(here: Path) -> None:
    text = (here / "beam.csv").read_text(encoding="utf-8")
    (here / "beam.csv").write_text(text[: len(text) // 2], encoding="utf-8")
    told = refusal(here)
    assert told.path.name == "beam.csv"
    assert told.line is not None


def test_file_of_another_format(here: Path) -> None:
    (here / "beam.frd").write_bytes((here / "beam.csv").read_bytes())
    told = refusal(here, fields="beam.frd")
    assert "CalculiX" in told.what
    (here / "beam.csv").write_bytes(bytes(range(256)) * 8)
    assert refusal(here).path.name == "beam.csv"


def test_no_such_file(here: Path) -> None:
    told = refusal(here, fields="beem.csv")
    assert "there is no file" in told.what
    assert told.key == "fields"
    assert told.path.name == "beam.yaml"


@pytest.mark.parametrize(
    ("changes", "key", "what"),
    [
        ({"units": None}, "", "'units' is missing"),
        ({"units": {"length": "N"}}, "units.length", "a length is expected"),
        ({"units": {"length": "3 mm"}}, "units.length", "not the name of a unit"),
        ({"units": {"length": "furlongish"}}, "units.length", "furlongish"),
        ({"reference": [1, 2]}, "reference", "2 values"),
        ({"reference": ["1 N", 0, 0]}, "reference[0]", "a length is expected"),
        ({"referense": [0, 0, 0]}, "referense", "unknown key"),
        ({"estimator": "best"}, "estimator", "must be one of lin"),
        ({"outliers": "drop"}, "outliers", "no treatment of outliers"),
        ({"outliers": {"drop": "60 %"}}, "outliers.drop", "not between 0 and 50 %"),
        ({"outliers": {"drop": "ten %"}}, "outliers.drop", "no quantity"),
        ({"confidence": 95}, "confidence", "not between 0 and 100 %"),
        ({"outliers": "robust", "estimator": "exact"}, "estimator", "robust fit is linear"),
        ({"select": {"near": "-1 mm"}}, "select.near", "distance"),
        ({"select": {"box": [[1, 0, 0], [0, 1, 1]]}}, "select.box", "holds no point"),
        ({"select": {"layer": {"normal": [0, 0, 0]}}}, "select.layer", "normal"),
        ({"select": {}}, "select", "one of these is needed"),
        ({"fields": {"file": "beam.csv"}}, "fields", "a list"),
        ({"fields": [{"file": "beam.csv", "cases": ["Fxx"]}]}, "fields[0]", "no load case 'Fxx'"),
        ({"fields": [{"file": "beam.csv", "name": "a"}]}, "fields[0]", "for one load case"),
    ],
)
def test_wrong_specifications(here: Path, changes: dict[str, Any], key: str, what: str) -> None:
    told = refusal(here, **changes)
    assert what in told.what
    assert told.key == key
    assert told.path.name == "beam.yaml"


def test_no_body_has_it(here: Path) -> None:
    """Loads of the wrong sign give a negative compliance, which no robot could take."""
    loads = content()["loads"] | {"Mx": wrench_of(-LOADS[3])}
    link = identified(here, loads=loads)
    assert not link.found.positive_definite
    with pytest.raises(FileError, match="not the compliance of a body"):
        link.write(here / "beam.link.yaml")
    assert not (here / "beam.link.yaml").exists()


def test_schema_tells_every_key() -> None:
    """Each key of the schema has a description, for the reference and for editors."""

    def check(node: Any, where: str) -> None:
        for name, one in node.get("properties", {}).items():
            assert one.get("description") or "$ref" in one, f"{where}.{name}"
            check(one, f"{where}.{name}")

    schema = json.loads(SCHEMA_FILE.read_text("utf-8"))
    check(schema, "")
    for name, one in schema["$defs"].items():
        assert one["description"], name
        check(one, name)
