"""Meshes are checked against the part, and broken ones are refused."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

pytest.importorskip("netgen.occ")

from fea_parts import mesh, part  # type: ignore[import-not-found]

from stiffkit.errors import CadError
from stiffkit.fea import MeshSettings, PartMesh, coarse_settings, mesh_part
from stiffkit.fea.arrays import MeshArrays
from stiffkit.fea.meshcheck import check_mesh
from stiffkit.fea.tets import jacobian_bounds, straighten, volumes


@pytest.fixture(scope="module")
def plate() -> PartMesh:
    whole: PartMesh = mesh("plate_with_hole", 0.0025)
    return whole


def broken(of: PartMesh, **changes: Any) -> MeshArrays:
    """The arrays of a mesh, some of them replaced."""
    whole = {name.name: getattr(of, name.name) for name in fields(MeshArrays)}
    return MeshArrays(**{**whole, **changes})


def test_volume_and_area_are_those_of_the_part(plate: PartMesh) -> None:
    assert abs(plate.check.volume_error) < 3e-4
    assert abs(plate.check.area_error) < 2e-3
    assert plate.check.flattest > 0.0
    assert plate.failures == ()


def test_ngsolve_sees_the_same_body(plate: PartMesh) -> None:
    from ngsolve import BND, CF, Integrate

    whole = part("plate_with_hole")
    volume = Integrate(CF(1.0), plate.curved, order=4)
    assert volume == pytest.approx(volumes(plate.points, plate.tets).sum(), rel=1e-12)
    for face in whole.faces:
        region = plate.curved.Boundaries(f"f{face.index}")
        area = Integrate(CF(1.0), plate.curved, BND, definedon=region, order=6)
        assert area == pytest.approx(face.area, rel=5e-3), face.describe()
    assert Integrate(CF(1.0), plate.straight) == pytest.approx(whole.volume, rel=0.02)


def test_a_hole_in_the_surface_is_found(plate: PartMesh) -> None:
    keep = np.arange(len(plate.triangles)) != 7
    holed = broken(plate, triangles=plate.triangles[keep], triangle_face=plate.triangle_face[keep])
    with pytest.raises(CadError, match="not closed: 1 outer sides"):
        check_mesh(part("plate_with_hole"), holed)


def test_a_missing_element_is_found(plate: PartMesh) -> None:
    hollow = broken(plate, tets=plate.tets[1:], tet_solid=plate.tet_solid[1:])
    with pytest.raises(CadError, match="not closed"):
        check_mesh(part("plate_with_hole"), hollow)


def test_a_face_that_was_not_meshed_is_found(plate: PartMesh) -> None:
    hole = next(f for f in part("plate_with_hole").faces if f.kind == "cylinder")
    face = plate.triangle_face.copy()
    face[face == hole.index] = 0 if hole.index != 0 else 1
    with pytest.raises(CadError, match="did not mesh face"):
        check_mesh(part("plate_with_hole"), broken(plate, triangle_face=face))


def test_an_element_that_is_turned_over_is_found(plate: PartMesh) -> None:
    tets = plate.tets.copy()
    tets[0, [0, 1]] = tets[0, [1, 0]]
    with pytest.raises(CadError, match="turned over"):
        check_mesh(part("plate_with_hole"), broken(plate, tets=tets))


def test_another_volume_is_found(plate: PartMesh) -> None:
    with pytest.raises(CadError, match="volume"):
        check_mesh(part("plate_with_hole"), broken(plate, points=1.01 * plate.points))


def test_the_jacobian_bound_holds_at_random_points() -> None:
    rng = np.random.default_rng(3)
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    nodes = np.vstack([corners, [(corners[i] + corners[j]) / 2 for i, j in pairs]])
    nodes[4:] += 0.08 * rng.standard_normal((6, 3))
    lower, mean = jacobian_bounds(nodes, np.arange(10, dtype=np.int32)[None, :])
    from stiffkit.fea.tets import gradients

    inside = rng.dirichlet(np.ones(4), size=500)
    values = np.abs(np.linalg.det(np.einsum("ni,qnj->qij", nodes, gradients(inside))))
    assert lower[0] <= values.min()
    assert values.min() - lower[0] < 0.3 * mean[0]
    assert values.mean() == pytest.approx(mean[0], rel=0.05)


def test_straightening_mends_an_element_that_bulges_too_much() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    nodes = np.vstack([corners, [(corners[i] + corners[j]) / 2 for i, j in pairs]])
    nodes[4] += [0.0, 0.6, 0.6]
    tets = np.arange(10, dtype=np.int32)[None, :]
    assert jacobian_bounds(nodes, tets)[0][0] < 0.0
    assert straighten(nodes, tets, 4) == 1
    assert jacobian_bounds(nodes, tets)[0][0] > 0.0


def test_other_settings_are_tried_before_giving_up() -> None:
    impossible = MeshSettings(size=1.0, feature=1e-3)
    with pytest.raises(CadError, match="could not be meshed; tried:") as caught:
        mesh_part(part("plate_with_hole"), impossible, timeout=0.01)
    assert caught.value.what.count("size") == 5


def test_a_real_part_begins_coarse() -> None:
    settings = coarse_settings(part("foot"))
    coarse = mesh_part(part("foot"), settings)
    assert coarse.check.n_tets < 4000
    assert abs(coarse.check.volume_error) < 2e-3
