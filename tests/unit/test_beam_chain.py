"""Chains of beams, and their comparison with parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffkit.errors import FileError
from stiffkit.fea import read_link_spec
from stiffkit.fea.beams import compare
from stiffkit.link import Material, beam_compliance, rectangle, round_bar
from stiffkit.link.beam_chain import BeamPiece, chain_compliance, chain_end
from stiffkit.spatial import axis_rotation, twist_shift

ALLOY = Material("alloy", E=70e9, nu=0.346, density=2700.0)
BAR = rectangle(16e-3, 26e-3)


def test_one_beam_is_a_beam() -> None:
    k = chain_compliance([BeamPiece(0.15, BAR)], ALLOY, np.array([0.15, 0.0, 0.0]))
    np.testing.assert_allclose(k, beam_compliance(0.15, BAR, ALLOY), rtol=1e-13, atol=1e-30)


def test_a_beam_cut_in_three_is_the_same_beam() -> None:
    pieces = [BeamPiece(length, BAR) for length in (0.03, 0.07, 0.05)]
    k = chain_compliance(pieces, ALLOY, np.array([0.15, 0.0, 0.0]))
    whole = beam_compliance(0.15, BAR, ALLOY)
    scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    assert np.abs((k - whole) / scale).max() < 1e-12


def test_an_l_by_hand() -> None:
    # Round, so no axis of the section matters: 0.2 m along x, then 0.1 m along y.
    round_ = round_bar(20e-3)
    pieces = [BeamPiece(0.2, round_), BeamPiece(0.1, round_, axis_rotation("z", np.pi / 2))]
    tip = np.array([0.2, 0.1, 0.0])
    np.testing.assert_allclose(chain_end(pieces).position, tip, atol=1e-15)
    k = chain_compliance(pieces, ALLOY, tip)
    first, second = (beam_compliance(length, round_, ALLOY) for length in (0.2, 0.1))
    # Along z the first bends and twists, with a lever of 0.1 m, and the second bends.
    expected = first[2, 2] + 0.1**2 * first[3, 3] + second[2, 2]
    assert k[2, 2] == pytest.approx(expected, rel=1e-12)
    # Along x: the first stretches and is bent by the moment of the lever, the second bends.
    assert k[0, 0] == pytest.approx(first[0, 0] + 0.1**2 * first[5, 5] + second[1, 1], rel=1e-12)


def test_the_way_to_the_tip_is_rigid() -> None:
    pieces = [BeamPiece(0.15, BAR)]
    end = chain_compliance(pieces, ALLOY, np.array([0.15, 0.0, 0.0]))
    X = twist_shift([0.01, -0.02, 0.03])
    k = chain_compliance(pieces, ALLOY, np.array([0.16, -0.02, 0.03]))
    np.testing.assert_allclose(k, X @ end @ X.T, rtol=1e-12, atol=1e-20)


SPEC = """\
link: Foot
cad: {part: orthoglide-foot}
material: {E: 70 GPa, nu: 0.346, density: 2700}
base: {faces: {name: carriage}, interface: clamped}
tip: {faces: {name: bearing}, interface: rigid}
beams:
  single beam: {length: 150 mm, section: {rectangle: [16 mm, 26 mm]}}
  two beams:
    - {length: 0.1, section: {round: 26 mm}}
    - {length: 50 mm, section: {round: 20 mm}, rotate: {y: -10 deg}}
"""


def specification(folder: Path, text: str) -> Path:
    path = folder / "foot.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_approximations_are_read_and_compared(tmp_path: Path) -> None:
    spec = read_link_spec(specification(tmp_path, SPEC))
    single, two = compare(spec.beams, np.array([0.15, 0.0, 0.0]))
    whole = beam_compliance(0.15, BAR, ALLOY)
    assert (single.name, two.name) == ("single beam", "two beams")
    np.testing.assert_allclose(single.ratios(whole), 1.0, rtol=1e-12)
    assert not single.has_gap
    # 50 mm that rise by 10 degrees end 8.7 mm beside the straight line.
    assert two.gap == pytest.approx(2 * 0.05 * np.sin(np.radians(5.0)), rel=1e-12)
    assert two.has_gap


@pytest.mark.parametrize(
    ("old", "new", "key", "told"),
    [
        ("150 mm", "0 mm", "beams.single beam.length", "must be positive"),
        ("{round: 26 mm}", "{square: 26 mm}", "beams.two beams[0].section.square", "unknown key"),
        (
            "{E: 70 GPa, nu: 0.346, density: 2700}",
            "{E: [10 GPa, 5 GPa, 4 GPa], nu: [0.3, 0.3, 0.3], G: [3 GPa, 3 GPa, 2 GPa],"
            " density: 1500}",
            "beams",
            "not isotropic",
        ),
        (
            "tip: {faces: {name: bearing}, interface: rigid}",
            "ports: {left: {faces: {name: bearing}, interface: rigid},"
            " right: {faces: {name: fillet}, interface: rigid}}",
            "beams",
            "link has none",
        ),
    ],
)
def test_what_is_wrong_with_beams_is_told_at_its_key(
    tmp_path: Path, old: str, new: str, key: str, told: str
) -> None:
    with pytest.raises(FileError, match=told) as caught:
        read_link_spec(specification(tmp_path, SPEC.replace(old, new)))
    assert caught.value.key == key
