"""Fields of a solved part through `identify`: the same compliance, and what it leaves."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("netgen.occ")

from tests.unit import fea_parts

from stiffkit.fea import (
    FacePick,
    Interface,
    PartMesh,
    Port,
    PortModel,
    SolveSettings,
    fields,
    find_ports,
    link_from_cad,
    reduce_part,
)
from stiffkit.fea.cad_link import as_json
from stiffkit.fea.fields import face_field, face_nodes, node_field
from stiffkit.fea.reading import RIGID, describe_readings, read_faces
from stiffkit.identify import identify
from stiffkit.report.link_page import write_link_page
from stiffkit.spatial import axis_rotation
from stiffkit.spatial.frame import Frame

TIP = 1
TURNED = Frame(axis_rotation("z", 0.4) @ axis_rotation("x", -1.1), np.array([0.02, -0.01, 0.03]))


def foot_ports(base: str, tip: str) -> tuple[Port, ...]:
    return find_ports(
        fea_parts.part("foot"),
        [
            Interface("base", FacePick(names=("ground",)), base),
            Interface("tip", FacePick(names=("bore",)), tip),
        ],
    )


def solved(mesh: PartMesh, ports: tuple[Port, ...], order: int) -> PortModel:
    return reduce_part(mesh, ports, [fea_parts.STEEL], SolveSettings(order, threads=1))


def foot(base: str = "clamped", tip: str = "average", order: int = 3) -> PortModel:
    return solved(fea_parts.mesh("foot", 0.025), foot_ports(base, tip), order)


def beam(order: int = 4, tip: str = "average") -> PortModel:
    part = fea_parts.part("beam", length=100.0)
    mesh = fea_parts.mesh("beam", 0.01, length=100.0)
    return solved(mesh, fea_parts.ends(part, tip=tip), order)


@pytest.mark.parametrize("order", [1, 2, 3, 5])
def test_the_fit_is_what_the_solution_reads_on_a_curved_face(order: int) -> None:
    assert read_faces(foot(order=order), TIP).difference < 1e-9


def test_elements_of_unlike_orders_are_read_too() -> None:
    mesh = fea_parts.mesh("foot", 0.025)
    orders = np.where(mesh.points[mesh.tets[:, 0], 2] > 0.1, 3, 4).astype(np.intp)
    settings = SolveSettings(order=4, orders=orders, threads=1)
    model = reduce_part(mesh, foot_ports("clamped", "average"), [fea_parts.STEEL], settings)
    assert read_faces(model, TIP).difference < 1e-6


@pytest.mark.parametrize(
    ("base", "tip"), [("average", "average"), ("average", "rigid"), ("clamped", "rigid")]
)
def test_the_fit_is_what_the_solution_reads_of_every_kind(base: str, tip: str) -> None:
    assert read_faces(foot(base, tip), TIP, TURNED).difference < 1e-9


def test_weights_are_the_area_of_the_faces() -> None:
    model = foot()
    face = fea_parts.part("foot").faces[model.ports[TIP].faces[0]]
    whole = sum(fea_parts.part("foot").faces[i].area for i in model.ports[TIP].faces)
    field = face_field(model, TIP)
    assert field.weights.sum() == pytest.approx(whole, rel=5e-3)
    assert face.axis_point is not None
    assert face.axis is not None
    assert face.radius is not None
    away = np.linalg.norm(np.cross(field.points - face.axis_point, face.axis), axis=1)
    np.testing.assert_allclose(away, face.radius, rtol=2e-2)


def test_axes_of_a_frame_are_those_of_points_loads_and_displacements() -> None:
    model = foot()
    plain, turned = (read_faces(model, TIP, frame).found.compliance for frame in (None, TURNED))
    turn = np.kron(np.eye(2), TURNED.rotation)
    scale = np.sqrt(np.outer(np.diag(turned), np.diag(turned)))
    np.testing.assert_allclose(turned / scale, turn.T @ plain @ turn / scale, rtol=0, atol=1e-9)


def test_fewer_points_are_as_good_on_a_plane_face(monkeypatch: pytest.MonkeyPatch) -> None:
    model = beam(5)
    many = read_faces(model, TIP)
    monkeypatch.setattr(fields, "MANY", 10)
    few = read_faces(model, TIP)
    assert few.found.node_count < many.found.node_count
    assert few.difference < 1e-9


def test_residuals_of_an_axial_load_are_the_poisson_contraction() -> None:
    # Strain -nu F / (E A) in the plane of a square face of width b: each of two axes has a root
    # mean square of strain times b / sqrt(12), the third has none.
    reading = read_faces(beam(), TIP)
    strain = fea_parts.STEEL.nu / (fea_parts.STEEL.E * 1e-4)
    expected = strain * 0.01 / np.sqrt(12.0) * np.sqrt(2.0 / 3.0)
    assert reading.found.estimate.sigma[0] == pytest.approx(expected, rel=1e-2)
    told = reading.describe()["loads"]["Fx"]
    assert told["structured"]
    assert "Poisson contraction" in told["residuals"]
    # Against the elongation, to which the contraction is in the ratio of nu b / L.
    assert told["share"] == pytest.approx(0.266 * np.sqrt(2.0 / 12.0) * 0.01 / 0.1, rel=1e-2)


def test_intervals_are_said_to_be_nominal() -> None:
    told = read_faces(beam(), TIP).describe()
    assert "no confidence intervals" in told["meaning"]
    assert json.loads(json.dumps(told, allow_nan=False)) == told


def test_rigid_faces_are_said_to_be_rigid() -> None:
    reading = read_faces(beam(tip="rigid"), TIP)
    assert reading.shares.max() < 1e-9
    told = reading.describe()
    assert told["meaning"] == RIGID
    assert not any(load["structured"] for load in told["loads"].values())


def test_each_port_but_the_held_one_is_read() -> None:
    part = fea_parts.part("beam", length=100.0)
    side = max((face for face in part.faces if not face.name), key=lambda face: face.centre[2])
    ports = find_ports(
        part,
        [
            Interface("base", FacePick(names=("base",)), "clamped"),
            Interface("tip", FacePick(names=("tip",))),
            Interface("side", FacePick(indices=(side.index,))),
        ],
    )
    model = solved(fea_parts.mesh("beam", 0.01, length=100.0), ports, 3)
    told = describe_readings(model, Frame())
    assert set(told) == {"tip", "side"}
    assert max(one["difference"] for one in told.values()) < 1e-9


@pytest.mark.parametrize("order", [1, 2, 3])
def test_nodes_of_a_rigid_face_move_by_the_compliance(order: int) -> None:
    model = foot(tip="rigid", order=order)
    nodes = face_nodes(model.solver.body.mesh, model.ports[TIP].faces, order)
    field = node_field(model, TIP, nodes, TURNED)
    np.testing.assert_array_equal(field.nodes, nodes)
    at = TURNED.inverse.point(model.ports[TIP].point)
    k = identify(field, np.eye(6), at).compliance
    own = read_faces(model, TIP, TURNED).found.compliance
    scale = np.sqrt(np.outer(np.diag(own), np.diag(own)))
    np.testing.assert_allclose(k / scale, own / scale, rtol=0, atol=1e-9)


def test_linear_elements_have_no_nodes_between_corners() -> None:
    model = foot(order=1)
    mesh = model.solver.body.mesh
    quadratic = face_nodes(mesh, model.ports[TIP].faces, 2)
    field = node_field(model, TIP, quadratic)
    np.testing.assert_array_equal(field.nodes, face_nodes(mesh, model.ports[TIP].faces, 1))
    assert field.node_count < len(quadratic)


SPEC = """
link: Bar
cad: bar.step
material: steel
base: {faces: {near: [0, 5 mm, 5 mm]}, interface: clamped}
tip: {faces: {near: [60 mm, 5 mm, 5 mm]}, interface: average}
modes: 0
mesh: {size: 10 mm, order: 2}
"""


def test_a_link_keeps_and_tells_what_its_faces_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from netgen.occ import Box

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    Box((0, 0, 0), (60, 10, 10)).WriteStep(str(tmp_path / "bar.step"))
    (tmp_path / "bar.yaml").write_text(SPEC, encoding="utf-8")
    first, second = (link_from_cad(tmp_path / "bar.yaml") for _ in range(2))
    assert second.from_cache
    told = as_json(second)["part"]["readings"]["tip"]
    assert told == first.solved.facts["readings"]["tip"]
    assert told["difference"] < 1e-9
    first.write(tmp_path / "bar.link.yaml")
    kept = yaml.safe_load((tmp_path / "bar.link.yaml").read_text("utf-8"))
    sigmas = [load["sigma"] for load in told["loads"].values()]
    assert kept["provenance"]["residuals"]["tip"] == pytest.approx(sigmas)
    write_link_page(first, [], tmp_path / "report.html")
    assert "Poisson contraction" in (tmp_path / "report.html").read_text("utf-8")
