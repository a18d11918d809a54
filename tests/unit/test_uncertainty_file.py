"""Files about uncertainty: what they say, and what is told where they are wrong."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from stiffkit.design.uncertainty import UncertaintySpec, read_uncertainty
from stiffkit.errors import FileError

HEAD = "uncertainty: Workshop\nrobot: five-bar\n"
ARM = "parameters: {proximal: {tolerance: 0.1 mm}}\n"

OWN = """\
robot: Own
parameters: {offset: 0 mm, beam: 500 mm}
links:
  beam: {beam: {length: = beam, section: {round: 20 mm}, material: steel}}
  block: {rigid: {}}
joints:
  root: {prismatic: z, from: base, to: beam.base, drive: rigid}
  end: {fixed: true, from: beam.tip, to: block}
tool: {at: block}
home: {z: 0}
workspace: {z: [-10 mm, 10 mm]}
"""
OWN_HEAD = "uncertainty: Own\nrobot: own.yaml\n"


def read(here: Path, text: str) -> UncertaintySpec:
    (here / "own.yaml").write_text(OWN, encoding="utf-8")
    path = here / "shop.yaml"
    path.write_text(text, encoding="utf-8")
    return read_uncertainty(path)


def test_errors_of_parameters(tmp_path: Path) -> None:
    text = "parameters:\n  proximal: {tolerance: 0.1 mm}\n  distal: {sigma: 2 %}\n"
    spec = read(tmp_path, HEAD + text + "  base: {sigma: = 0.01 * base}\n")
    proximal, distal, base = spec.parameters
    assert (proximal.distribution, distal.distribution) == ("uniform", "normal")
    assert proximal.value == pytest.approx(0.2)
    # Evenly distributed over a width of 2 t: t / sqrt(3).
    assert proximal.sigma == pytest.approx(1e-4 / np.sqrt(3.0))
    assert distal.sigma == pytest.approx(0.02 * distal.value)
    assert base.sigma == pytest.approx(0.01 * base.value)
    assert spec.sources == ("proximal", "distal", "base")


def test_errors_of_links(tmp_path: Path) -> None:
    spec = read(tmp_path, HEAD + "links: {left_arm: {sigma: 2 %}, right_rod: {sigma: 0.05}}\n")
    assert [(u.name, u.relative) for u in spec.links] == [("left_arm", 0.02), ("right_rod", 0.05)]


def test_what_is_left_out_has_a_meaning(tmp_path: Path) -> None:
    spec = read(tmp_path, HEAD + ARM)
    assert spec.links == ()
    assert spec.models == ("refined",)
    assert (spec.postures, spec.samples, spec.seed) == (500, 1000, 0)
    assert spec.confidence == 0.95
    assert spec.standard_deviations == pytest.approx(1.959964)
    assert [(a.name, a.quantity, a.load) for a in spec.asked] == [
        ("weakest", "stiffness_translation_min", None),
        ("deflection_push", "deflection_translation", "push"),
        ("deflection_lift", "deflection_translation", "lift"),
    ]


def test_quantities(tmp_path: Path) -> None:
    text = "quantities: {a: stiffness_rotation_min, b: {deflection_z: lift}}\nconfidence: 99 %\n"
    spec = read(tmp_path, HEAD + ARM + text)
    assert [(a.name, a.quantity, a.load) for a in spec.asked] == [
        ("a", "stiffness_rotation_min", None),
        ("b", "deflection_z", "lift"),
    ]
    assert spec.confidence == 0.99
    assert json.loads(json.dumps(spec.plain()))["asked"][1]["load"] == "lift"


def test_a_source_is_told_from_another_of_its_name(tmp_path: Path) -> None:
    text = "parameters: {beam: {sigma: 1 %}}\nlinks: {beam: {sigma: 1 %}}\n"
    assert read(tmp_path, OWN_HEAD + text).sources == ("beam", "link beam")


@pytest.mark.parametrize(
    ("text", "place", "what", "mend"),
    [
        (HEAD, "shop.yaml", "nothing here is uncertain", "'parameters' or 'links'"),
        (HEAD + "links: {}\n", "shop.yaml", "nothing here is uncertain", "'links'"),
        ("robot: five-bar\n", "shop.yaml", "'uncertainty' is missing", ""),
        (HEAD.replace("bar", "bra"), ":2: robot", "no robot 'five-bra'", "five-bar"),
        (HEAD + "parameter: {}\n", ":3", "'parameter'", "parameters"),
        (
            HEAD + "parameters: {proxima: {sigma: 1 %}}\n",
            ":3: parameters.proxima",
            "no parameter 'proxima'",
            "proximal",
        ),
        (
            HEAD + "parameters: {proximal: {sigma: -1 mm}}\n",
            "parameters.proximal.sigma",
            "must be above zero",
            "known exactly",
        ),
        (
            HEAD + "parameters: {proximal: {sigma: 0 %}}\n",
            "parameters.proximal.sigma",
            "is not between 0 and 100 %",
            "2 %",
        ),
        (
            HEAD + "parameters: {proximal: {tolerance: 0}}\n",
            "parameters.proximal.tolerance",
            "must be above zero",
            "known exactly",
        ),
        (
            HEAD + "parameters: {proximal: {sigma: 2 kg}}\n",
            "parameters.proximal.sigma",
            "is a mass",
            "",
        ),
        (
            HEAD + "parameters: {proximal: {}}\n",
            "parameters.proximal",
            "no error stands here",
            "tolerance: 0.1 mm",
        ),
        (
            HEAD + "parameters: {proximal: {sigma: 1 mm, tolerance: 1 mm}}\n",
            "parameters.proximal",
            "sigma and tolerance stands here",
            "standard deviation",
        ),
        (
            OWN_HEAD + "parameters: {offset: {sigma: 1 %}}\n",
            "parameters.offset.sigma",
            "the parameter 'offset' is 0",
            "with a unit",
        ),
        (
            OWN_HEAD + "links: {block: {sigma: 1 %}}\n",
            "links.block",
            "'block' is rigid",
            "leave it out",
        ),
        (
            HEAD + "links: {left_arm: identified}\n",
            "links.left_arm",
            "was not identified",
            "{sigma: 2 %}",
        ),
        (HEAD + "links: {left_arm: known}\n", "links.left_arm", "no error of a link", "identified"),
        (HEAD + "links: {left_am: identified}\n", "links.left_am", "no link", "left_arm"),
        (HEAD + "links: {left_arm: {sigma: -2 %}}\n", "links.left_arm.sigma", "between 0", "2 %"),
        (
            HEAD + ARM + "quantities: {a: stifness_translation_min}\n",
            "quantities.a",
            "no quantity",
            "stiffness_translation_min",
        ),
        (
            HEAD + ARM + "quantities: {a: {deflection_xy: pull}}\n",
            "quantities.a.deflection_xy",
            "no load case 'pull'",
            "push",
        ),
        (
            HEAD + ARM + "quantities: {a: deflection_xy}\n",
            "quantities.a",
            "under which load?",
            "{deflection_xy: LOAD}",
        ),
        (
            HEAD + ARM + "quantities: {a: {stiffness_rotation_min: push}}\n",
            "quantities.a.stiffness_rotation_min",
            "the same for all loads",
            "'stiffness_rotation_min'",
        ),
        (
            OWN_HEAD + "links: {beam: {sigma: 1 %}}\nquantities: {a: deflection_z}\n",
            "quantities.a",
            "under which load?",
            "has no loads",
        ),
        (
            HEAD + ARM + "quantities: {a: frequency_first}\n",
            "quantities.a",
            "no error bars",
            "stiffnesses",
        ),
        (
            HEAD + ARM + "quantities: {a_sigma: stiffness_rotation_min}\n",
            "quantities.a_sigma",
            "of its own",
            "another name",
        ),
        (
            HEAD + ARM + "quantities: {model: stiffness_rotation_min}\n",
            "quantities.model",
            "of its own",
            "another name",
        ),
        (HEAD + ARM + "confidence: 95\n", "confidence", "is not between 0 and 100 %", "95 %"),
        (HEAD + ARM + "samples: 10.5\n", "samples", "no whole number", "1000"),
        (HEAD + ARM + "samples: -1\n", "samples", "-1", ""),
        (HEAD + ARM + "models: [refind]\n", "models[0]", "refind", "refined"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(
    text: str, place: str, what: str, mend: str, tmp_path: Path
) -> None:
    with pytest.raises(FileError) as caught:
        read(tmp_path, text)
    message = str(caught.value)
    assert "shop.yaml" in message
    assert place in message
    assert what in message
    assert mend in message


def test_errors_that_do_not_depend_on_each_other_are_told_together(tmp_path: Path) -> None:
    text = HEAD + "parameters: {proxima: {sigma: 1 %}}\nlinks: {left_am: {sigma: 1 %}}\n"
    with pytest.raises(FileError, match="no parameter 'proxima'") as caught:
        read(tmp_path, text)
    assert "no link 'left_am'" in str(caught.value)
