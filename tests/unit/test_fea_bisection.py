"""Elements that are cut, on a real mesh with curved sides."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.fea_parts import part

pytest.importorskip("ngsolve")

from stiffkit.fea.bisection import bisect
from stiffkit.fea.mesh import MeshSettings, PartMesh, bisect_mesh, mesh_part
from stiffkit.fea.meshcheck import check_mesh, triangle_areas
from stiffkit.fea.tets import TET_EDGES, jacobian_bounds, volumes


@pytest.fixture(scope="module")
def plate() -> PartMesh:
    return mesh_part(part("plate_with_hole"), MeshSettings(0.02))


def some(mesh: PartMesh, share: float, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).random(len(mesh.tets)) < share


def test_the_shape_stays_as_it_is(plate: PartMesh) -> None:
    found = bisect(plate, some(plate, 0.2))
    new = volumes(found.mesh.points, found.mesh.tets)
    old = volumes(plate.points, plate.tets)
    np.testing.assert_allclose(np.bincount(found.parents, new), old, rtol=1e-10)
    area = triangle_areas(found.mesh.points, found.mesh.triangles)
    before = np.bincount(plate.triangle_face, triangle_areas(plate.points, plate.triangles))
    np.testing.assert_allclose(np.bincount(found.mesh.triangle_face, area), before, rtol=1e-6)


def test_the_mesh_stays_whole_whatever_is_chosen(plate: PartMesh) -> None:
    mesh = plate
    for seed in range(3):
        mesh, parents = bisect_mesh(part("plate_with_hole"), mesh, some(mesh, 0.1, seed))
        assert len(parents) == len(mesh.tets)
        # Middle nodes are shared: each pair of corners has one.
        corners = [np.sort(mesh.tets[:, [i, j]], axis=1) for i, j in TET_EDGES]
        pairs = np.concatenate(corners)
        middles = mesh.tets[:, 4:].T.ravel()
        assert len(np.unique(pairs, axis=0)) == len(np.unique(middles))
        # What follows the corners is no vertex: NGSolve would give it functions of no element.
        assert mesh.tets[:, :4].max() < mesh.tets[:, 4:].min()
        assert mesh.curved.nv == len(np.unique(mesh.tets[:, :4]))
    assert mesh.cuts == 3


def test_chosen_elements_lose_their_longest_edge(plate: PartMesh) -> None:
    chosen = np.zeros(len(plate.tets), dtype=bool)
    chosen[7] = True
    found = bisect(plate, chosen)
    assert np.sum(found.parents == 7) >= 2
    assert len(found.mesh.tets) < len(plate.tets) + 60


def test_cutting_again_and_again_makes_no_flat_elements(plate: PartMesh) -> None:
    def flattest(mesh: object) -> float:
        p = mesh.points[mesh.tets[:, :4]]  # type: ignore[attr-defined]
        volume = np.abs(np.linalg.det(p[:, 1:] - p[:, :1])) / 6.0
        longest = max(
            np.linalg.norm(p[:, i] - p[:, j], axis=1).max(initial=0.0) for i, j in TET_EDGES
        )
        edges = np.max([np.linalg.norm(p[:, i] - p[:, j], axis=1) for i, j in TET_EDGES], axis=0)
        assert longest > 0.0
        return float((volume / edges**3).min())

    first, mesh = flattest(plate), plate
    for _ in range(8):
        # Always around the same corner, as at a singular point.
        distance = np.linalg.norm(
            mesh.points[mesh.tets[:, :4]].mean(axis=1) - plate.points[0], axis=1
        )
        chosen = distance <= np.partition(distance, 5)[5]
        mesh, _ = bisect_mesh(part("plate_with_hole"), mesh, chosen)
    assert flattest(mesh) > 0.1 * first
    lower, mean = jacobian_bounds(mesh.points, mesh.tets)
    assert np.all(lower > 0.0)
    assert np.all(mean > 0.0)


def test_nothing_chosen_changes_nothing(plate: PartMesh) -> None:
    found = bisect(plate, np.zeros(len(plate.tets), dtype=bool))
    np.testing.assert_array_equal(found.mesh.tets, plate.tets)
    check_mesh(part("plate_with_hole"), found.mesh)
