"""Faces picked by descriptions, and descriptions that pick the wrong ones."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("netgen.occ")

from fea_parts import part  # type: ignore[import-not-found]

from stiffkit.errors import CadError
from stiffkit.fea import FacePick, Interface, find_ports, pick_faces
from stiffkit.fea.distance import distances_to_triangles


@pytest.mark.parametrize(
    "pick",
    [
        FacePick(names=("tip",)),
        FacePick(names=("t?p",)),
        FacePick(colour=(1.0, 0.0, 0.0)),
        FacePick(near=((1.01, 0.004, 0.004),)),
        FacePick(box=((0.99, -1.0, -1.0), (1.01, 1.0, 1.0))),
        FacePick(kind="plane", near=((1.0, 0.005, 0.005),), count=1),
    ],
)
def test_each_description_picks_the_tip(pick: FacePick) -> None:
    assert [face.name for face in pick_faces(part("beam"), pick)] == ["tip"]


def test_two_points_pick_two_faces() -> None:
    pick = FacePick(near=((0.0, 0.005, 0.005), (1.0, 0.005, 0.005)), count=2)
    assert {face.name for face in pick_faces(part("beam"), pick)} == {"base", "tip"}


def test_no_match_lists_the_candidates() -> None:
    with pytest.raises(CadError, match="no face has name top") as caught:
        pick_faces(part("beam"), FacePick(names=("top",)))
    assert '"tip"' in caught.value.mend


def test_a_point_between_two_faces_is_ambiguous() -> None:
    with pytest.raises(CadError, match="more than one face is nearest"):
        pick_faces(part("beam"), FacePick(near=((1.01, 0.005, 0.01),)))


def test_too_many_faces_are_listed() -> None:
    with pytest.raises(CadError, match="6 faces have kind plane, and it must be 1") as caught:
        pick_faces(part("beam"), FacePick(kind="plane", count=1))
    assert caught.value.mend.count("face ") >= 6


def test_interfaces_that_overlap_are_refused() -> None:
    tip = FacePick(names=("tip",))
    with pytest.raises(CadError, match="a and b overlap"):
        find_ports(part("beam"), [Interface("a", tip), Interface("b", tip)])
    with pytest.raises(CadError, match="two interfaces are called a"):
        find_ports(part("beam"), [Interface("a", tip), Interface("a", FacePick(names=("base",)))])


def test_the_reference_point_is_the_centroid_of_all_faces() -> None:
    pick = FacePick(names=("base", "tip"))
    (port,) = find_ports(part("beam"), [Interface("both", pick)])
    np.testing.assert_allclose(port.point, [0.5, 0.005, 0.005], atol=1e-9)
    (port,) = find_ports(part("beam"), [Interface("both", pick, point=(1.0, 2.0, 3.0))])
    np.testing.assert_allclose(port.point, [1.0, 2.0, 3.0])


def test_kind_and_axes_are_checked() -> None:
    with pytest.raises(CadError, match="unknown kind 'glued'"):
        Interface("a", FacePick(), "glued")
    with pytest.raises(CadError, match="perpendicular"):
        Interface("a", FacePick(), axes=np.ones((3, 3)))


def test_distances_to_a_triangle() -> None:
    triangle = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    for point, wanted in [
        ((0.2, 0.2, 3.0), 3.0),
        ((-3.0, 0.0, 4.0), 5.0),
        ((0.5, -2.0, 0.0), 2.0),
        ((1.0, 1.0, 0.0), np.sqrt(0.5)),
    ]:
        assert distances_to_triangles(np.array(point), triangle)[0] == pytest.approx(wanted)
