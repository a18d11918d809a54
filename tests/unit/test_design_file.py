"""Design files: what they say, and what is told where they are wrong."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from design_cantilever import design  # type: ignore[import-not-found]

from stiffkit.design.spec import Constraint, Evolution, Gradient
from stiffkit.errors import FileError

VARY = "vary:\n  width: {from: 20 mm, to: 60 mm}\n"
GOAL = "objectives:\n  weight: {minimise: mass}\n"


def constraint(folder: Path, text: str) -> tuple[Constraint, ...]:
    spec = design(
        folder, f"{VARY}{GOAL}constraints:\n  own: {text}\n  all: {{workspace: reached}}\n"
    )
    found: tuple[Constraint, ...] = spec.constraints[:-1]
    return found


def test_ranges_whole_numbers_and_choices(tmp_path: Path) -> None:
    text = """\
vary:
  width: {from: 20 mm, to: = 1.5 * width}
  teeth: {integers: [10, 14]}
  length: {choose: [900 mm, 1 m]}
  place:
    choose:
      short: {travel: 80 mm, height: 30 mm}
      long: {height: 50 mm, travel: 120 mm}
"""
    spec = design(tmp_path, text + GOAL)
    width, teeth, length, place = spec.variables
    assert (width.kind, width.values) == ("continuous", ((0.02, 0.06),))
    assert (teeth.kind, teeth.values) == ("integer", ((10.0, 11.0, 12.0, 13.0, 14.0),))
    assert (length.kind, length.values) == ("choice", ((0.9, 1.0),))
    assert place.parameters == ("travel", "height")
    assert place.values == ((0.08, 0.12), (0.03, 0.05))
    assert place.options == ("short", "long")
    assert [p.name for p in spec.parameters] == ["width", "teeth", "length", "travel", "height"]


def test_measures(tmp_path: Path) -> None:
    (found,) = constraint(tmp_path, "{max: deflection_z, load: weight, below: 2 mm}")
    assert found.measure.column is not None
    assert (found.measure.column.load, found.above, found.bound) == ("weight", False, 2e-3)
    (found,) = constraint(tmp_path, "{percentile: 95, of: deflection_z, load: push, below: start}")
    assert found.bound is None
    (found,) = constraint(tmp_path, "{of: size, above: 900 mm}")
    assert (found.measure.kind, found.above, found.bound) == ("size", True, 0.9)
    (found,) = constraint(tmp_path, "{stroke: slide, below: 300 mm}")
    assert (found.measure.kind, found.measure.joint) == ("stroke", "slide.y")
    low, high = constraint(tmp_path, "{joint: slide.y, from: -200 mm, to: 300 mm}")
    assert (low.measure.name, low.above, low.bound) == ("own_lowest", True, -0.2)
    assert (high.measure.name, high.above, high.bound) == ("own_highest", False, 0.3)
    (found,) = constraint(tmp_path, "{workspace: reached, above: 0.9}")
    assert (found.measure.kind, found.bound) == ("reached", 0.9)


def test_what_is_left_out_has_a_meaning(tmp_path: Path) -> None:
    spec = design(tmp_path, VARY + GOAL)
    assert spec.models == ("refined",)
    assert spec.postures == 200
    (whole,) = spec.constraints
    assert (whole.measure.kind, whole.above, whole.bound) == ("reached", True, 1.0)
    assert spec.methods.gradient == Gradient(starts=8, points=0)
    assert spec.methods.evolution is None
    two = GOAL + "  stiff: {maximise: {min: stiffness_translation_min}}\n"
    assert design(tmp_path, VARY + two).methods.evolution == Evolution(40, 25)
    whole_numbers = design(tmp_path, "vary: {teeth: {integers: [10, 12]}}\n" + GOAL).methods
    assert whole_numbers.gradient is None
    assert whole_numbers.evolution is not None


def test_plain_data_is_json(tmp_path: Path) -> None:
    spec = design(tmp_path, VARY + GOAL + "derived: {height: = width}\n")
    plain = json.loads(json.dumps(spec.plain()))
    assert plain["derived"] == [["height", "= width"]]
    assert plain["objectives"][0]["measure"]["name"] == "weight"


@pytest.mark.parametrize(
    ("text", "place", "what", "mend"),
    [
        (VARY, "", "'objectives' is missing", "objectives:"),
        ("vary: {widht: {from: 1, to: 2}}\n" + GOAL, ":3: vary.widht", "no parameter", "width"),
        ("vary: {width: {from: 2, to: 1}}\n" + GOAL, ":3: vary.width", "not below", "exchange"),
        ("vary: {width: {from: 2}}\n" + GOAL, ":3: vary.width", "a range", "from: 300 mm"),
        ("vary: {width: {from: 1 kg, to: 2}}\n" + GOAL, ":3: vary.width.from", "is a mass", ""),
        (
            "vary: {teeth: {integers: [5, 5]}}\n" + GOAL,
            ":3: vary.teeth.integers",
            "whole numbers",
            "[10, 20]",
        ),
        (
            "vary: {teeth: {integers: [5, 6.5]}}\n" + GOAL,
            ":3: vary.teeth.integers[1]",
            "no whole number",
            "",
        ),
        (
            "vary: {a: {choose: {one: {width: 1}, two: {height: 1}}}}\n" + GOAL,
            ":3: vary.a.choose.two",
            "this option sets height, and the first one width",
            "the same parameters",
        ),
        (
            "vary: {width: {from: 1, to: 2}, a: {choose: {b: {width: 1}, c: {width: 2}}}}\n" + GOAL,
            ":3: vary.a",
            "parameter 'width' is varied by 'width' already",
            "one of the two",
        ),
        (VARY + "objectives: {a: {minimise: cost}}\n", ":5: objectives.a", "'cost'", "mass"),
        (
            VARY + "objectives: {width: {minimise: mass}}\n",
            ":5: objectives.width",
            "name of a parameter",
            "another name",
        ),
        (
            VARY + "objectives: {front: {minimise: mass}}\n",
            ":5: objectives.front",
            "of the result already",
            "another name",
        ),
        (VARY + GOAL + "derived: {width: 1}\n", ":7: derived.width", "is varied", "'vary'"),
        (VARY + GOAL + "derived: {twice: 1 kg}\n", ":7: derived.twice", "is a mass", ""),
        (
            VARY + GOAL + "constraints: {a: {of: mass}}\n",
            ":7: constraints.a",
            "no bound stands here",
            "below",
        ),
        (
            VARY + GOAL + "constraints: {a: {of: mass, below: 3 m}}\n",
            ":7: constraints.a.below",
            "a mass is expected",
            "",
        ),
        (
            VARY + GOAL + "constraints: {a: {of: mass, load: push, below: 3}}\n",
            ":7: constraints.a.load",
            "cannot stand beside 'of'",
            "two constraints",
        ),
        (
            VARY + GOAL + "constraints: {a: {joint: slide}}\n",
            ":7: constraints.a",
            "between what",
            "from",
        ),
        (
            VARY + GOAL + "constraints: {a: {joint: slid, from: 0}}\n",
            ":7: constraints.a.joint",
            "no joint 'slid'",
            "slide",
        ),
        (
            VARY + GOAL + "constraints: {a: {joint: slide.x, from: 0}}\n",
            ":7: constraints.a.joint",
            "which coordinate",
            "slide.y",
        ),
        (
            VARY + GOAL + "constraints: {a: {max: deflection_z, from: 1, below: 2}}\n",
            ":7: constraints.a.from",
            "belongs to a 'joint'",
            "above",
        ),
        (
            VARY + GOAL + "constraints: {a: {below: 2}}\n",
            ":7: constraints.a",
            "nothing that is measured",
            "stroke",
        ),
        (
            VARY + GOAL + "constraints: {a: {min: frequency_first, above: 2 Hz}}\n",
            ":7: constraints.a.min",
            "no frequencies",
            "frequencies: {postures",
        ),
        (
            "vary: {teeth: {integers: [5, 6]}}\n" + GOAL + "method: {gradient: {}}\n",
            ":6: method.gradient",
            "no gradient",
            "evolution",
        ),
        (
            "vary: {width: {from: 1, to: 2}, height: {from: 1, to: 2}}\n"
            + GOAL
            + "method: {grid: {steps: 2000}}\n",
            ":6: method.grid",
            "4000000 designs",
            "steps",
        ),
        (VARY + GOAL + "method: {swarm: {}}\n", ":7: method.swarm", "unknown key", "grid"),
    ],
)
def test_what_is_wrong_is_told_at_its_place(
    tmp_path: Path, text: str, place: str, what: str, mend: str
) -> None:
    with pytest.raises(FileError) as caught:
        design(tmp_path, text)
    told = str(caught.value)
    assert place in told
    assert what in told
    assert mend in told
