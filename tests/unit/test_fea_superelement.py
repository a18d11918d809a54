"""Ports of every kind: symmetry, rigid motions, mass, materials, solvers."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

pytest.importorskip("netgen.occ")

from fea_parts import STEEL, ends, mesh, part  # type: ignore[import-not-found]

from stiffkit.errors import CadError, LinkError
from stiffkit.fea import (
    FacePick,
    Interface,
    Orthotropic,
    Part,
    Port,
    PortModel,
    SolveSettings,
    find_ports,
    named_ports,
    reduce_part,
)
from stiffkit.fea.adapt import AdaptSettings, adapt
from stiffkit.fea.elasticity import Elasticity
from stiffkit.fea.estimate import whitened
from stiffkit.fea.memory import direct_bytes
from stiffkit.link import Material
from stiffkit.spatial.twist import twist_shift

ORDER_2 = SolveSettings(order=2, threads=1)
KINDS = [(b, t) for b in ("clamped", "rigid", "average") for t in ("rigid", "average")]


def short_beam(base: str, tip: str, settings: SolveSettings = ORDER_2) -> PortModel:
    """A bar of 50 x 10 x 10 mm."""
    ports = ends(part("beam", length=50.0), base, tip)
    model: PortModel = reduce_part(mesh("beam", 0.01, length=50.0), ports, [STEEL], settings)
    return model


def rigid_motion(model: PortModel) -> np.ndarray:
    """Twists (6m, 6) of all ports for unit twists of the first."""
    first = model.ports[0].point
    return np.vstack([twist_shift(port.point - first) for port in model.ports])


@pytest.mark.parametrize(("base", "tip"), KINDS)
def test_every_pair_of_kinds(base: str, tip: str) -> None:
    model = short_beam(base, tip)
    k = model.compliance
    assert np.array_equal(k, k.T)
    assert model.asymmetry < 1e-9
    assert np.linalg.eigvalsh(k)[0] > 0.0
    L, E, A = 0.05, STEEL.E, 1e-4
    assert k[0, 0] == pytest.approx(L / E / A, rel=0.03)
    assert k[4, 4] == pytest.approx(L / E / (A**2 / 12.0), rel=0.03)
    T = rigid_motion(model)
    assert np.abs(model.stiffness @ T).max() < 1e-8 * np.abs(model.stiffness).max()
    values, M = model.modes(2)
    assert values[0] > 0.0
    np.testing.assert_allclose(M[12:, 12:], np.eye(2), atol=1e-9)
    moved = np.vstack([T, np.zeros((2, 6))])
    rigid = moved.T @ M @ moved
    mass, centre, inertia = part("beam", length=50.0).mass_properties(STEEL.density)
    assert rigid[0, 0] == pytest.approx(mass, rel=1e-9)
    arm = centre - model.ports[0].point
    about = inertia + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(rigid[3:, 3:], about, atol=1e-9 * about.max())


def test_rigid_interfaces_stiffen() -> None:
    soft, tip, both = (
        short_beam(*kinds).compliance
        for kinds in (("average", "average"), ("average", "rigid"), ("rigid", "rigid"))
    )
    assert np.linalg.eigvalsh(soft - tip)[0] > -1e-12 * soft.max()
    assert np.linalg.eigvalsh(tip - both)[0] > -1e-12 * soft.max()


def test_holding_the_other_end_is_the_same_superelement() -> None:
    ports = ends(part("beam", length=50.0), "average", "average")
    body = mesh("beam", 0.01, length=50.0)
    here, there = (reduce_part(body, ports, [STEEL], ORDER_2, held=i) for i in (0, 1))
    scale = np.sqrt(np.outer(np.diag(here.stiffness), np.diag(here.stiffness)))
    assert np.abs((here.stiffness - there.stiffness) / scale).max() < 1e-8


def test_an_average_base_beside_a_rigid_port() -> None:
    ports = ends(part("beam", length=50.0), "average", "rigid")
    body = mesh("beam", 0.01, length=50.0)
    here, there = (reduce_part(body, ports, [STEEL], ORDER_2, held=i) for i in (0, 1))
    scale = np.sqrt(np.outer(np.diag(here.stiffness), np.diag(here.stiffness)))
    assert np.abs((here.stiffness - there.stiffness) / scale).max() < 1e-8


def test_three_ports() -> None:
    whole = part("beam", length=50.0)
    picks = {"base": (0.0, 0.005, 0.005), "tip": (0.05, 0.005, 0.005), "top": (0.02, 0.005, 0.01)}
    for kinds in (
        ("average",) * 3,
        ("clamped", "average", "average"),
        ("average", "rigid", "average"),
    ):
        ports = find_ports(
            whole,
            [
                Interface(name, FacePick(near=(point,)), kind)
                for (name, point), kind in zip(picks.items(), kinds, strict=True)
            ],
        )
        model = reduce_part(mesh("beam", 0.01, length=50.0), ports, [STEEL], ORDER_2)
        assert model.compliance.shape == (12, 12)
        K = model.stiffness
        assert np.abs(K @ rigid_motion(model)).max() < 1e-8 * np.abs(K).max()
        # Nothing acts on the third port: the others have the compliance that they have alone.
        two = reduce_part(mesh("beam", 0.01, length=50.0), ports[:2], [STEEL], ORDER_2)
        np.testing.assert_allclose(
            model.compliance[:6, :6], two.compliance, atol=1e-7 * two.compliance.max()
        )


def test_link_axes_run_from_base_to_tip() -> None:
    model = short_beam("clamped", "average")
    frame = model.link_frame()
    np.testing.assert_allclose(frame.rotation, np.eye(3), atol=1e-9)
    link = model.to_link(3, frame.rotation)
    np.testing.assert_allclose(link.compliance, model.compliance)
    assert link.mass.shape == (15, 15)
    back = reduce_part(
        mesh("beam", 0.01, length=50.0), model.ports[::-1], [STEEL], ORDER_2, held=0
    ).link_frame()
    np.testing.assert_allclose(back.rotation[:, 0], [-1.0, 0.0, 0.0], atol=1e-9)
    assert np.linalg.det(back.rotation) == pytest.approx(1.0)


def test_rigid_ports_must_not_touch() -> None:
    whole = part("beam", length=50.0)
    ports = find_ports(
        whole,
        [
            Interface("tip", FacePick(names=("tip",)), "rigid"),
            Interface("top", FacePick(near=((0.02, 0.005, 0.01),)), "rigid"),
        ],
    )
    with pytest.raises(CadError, match="touch each other"):
        reduce_part(mesh("beam", 0.01, length=50.0), ports, [STEEL], ORDER_2)


def test_an_isotropic_material_as_an_orthotropic_one() -> None:
    E, nu, G = STEEL.E, STEEL.nu, STEEL.G
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    same = Orthotropic("steel", E, E, E, nu, nu, nu, G, G, G, STEEL.density, axes=turn)
    ports = ends(part("beam", length=50.0))
    body = mesh("beam", 0.01, length=50.0)
    k, wanted = (reduce_part(body, ports, [law], ORDER_2).compliance for law in (same, STEEL))
    np.testing.assert_allclose(k, wanted, atol=1e-9 * wanted.max())


def test_a_stretched_orthotropic_bar() -> None:
    law = Orthotropic("print", 3e9, 2e9, 1e9, 0.3, 0.3, 0.3, 1e9, 0.8e9, 0.6e9, 1200.0)
    ports = ends(part("beam", length=50.0), "average", "average")
    body = mesh("beam", 0.01, length=50.0)
    along = reduce_part(body, ports, [law], ORDER_2).compliance[0, 0]
    assert along == pytest.approx(0.05 / 3e9 / 1e-4, rel=1e-6)
    turned = replace(law, axes=np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]))
    across = reduce_part(body, ports, [turned], ORDER_2).compliance[0, 0]
    assert across == pytest.approx(0.05 / 1e9 / 1e-4, rel=1e-6)


def test_impossible_materials() -> None:
    with pytest.raises(LinkError, match="nu12"):
        Orthotropic("bad", 1e9, 1e9, 1e9, 0.9, 0.9, 0.9, 1e9, 1e9, 1e9, 1.0)
    with pytest.raises(LinkError, match="E2 is -1 "):
        Orthotropic("bad", 1e9, -1.0, 1e9, 0.3, 0.3, 0.3, 1e9, 1e9, 1e9, 1.0)
    with pytest.raises(LinkError, match="between"):
        Material("rubber", E=1e6, nu=0.5, density=1000.0)


def test_two_solids_of_two_materials() -> None:
    whole = part("two_materials")
    faces = [
        Interface(n, FacePick(near=((x, 0.005, 0.005),)), "average")
        for n, x in (("a", 0.0), ("b", 0.1))
    ]
    ports = find_ports(whole, faces)
    soft = Material("soft", E=1e9, nu=0.0, density=1000.0)
    hard = Material("hard", E=4e9, nu=0.0, density=3000.0)
    model = reduce_part(mesh("two_materials", 0.01), ports, [soft, hard], ORDER_2)
    assert model.compliance[0, 0] == pytest.approx(0.05 / 1e-4 * (1e-9 + 0.25e-9), rel=1e-6)
    assert model.modes(0)[1][:12:6, :12:6].sum() == pytest.approx(5e-6 * 4000.0, rel=1e-9)
    with pytest.raises(CadError, match="2 solids and 3 materials"):
        reduce_part(mesh("two_materials", 0.01), ports, [soft] * 3, ORDER_2)


@pytest.mark.parametrize(("base", "tip"), KINDS)
def test_the_iterative_solver_agrees(base: str, tip: str) -> None:
    settings = SolveSettings(order=3, threads=1)
    direct = short_beam(base, tip, settings)
    small = short_beam(base, tip, replace(settings, solver="iterative"))
    scale = np.sqrt(np.outer(np.diag(direct.compliance), np.diag(direct.compliance)))
    assert np.abs((small.compliance - direct.compliance) / scale).max() < 1e-7


def test_too_little_memory_is_predicted() -> None:
    with pytest.raises(CadError, match="unknowns directly takes about"):
        short_beam("clamped", "average", replace(ORDER_2, solver="direct", memory=1e4))
    short_beam("clamped", "average", replace(ORDER_2, memory=1e4))
    assert direct_bytes(250_000) > 2e9


def test_a_wrong_factorisation_is_noticed_and_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = short_beam("clamped", "average").compliance
    whole = Elasticity._invert

    def wrong_in_blocks(body: Elasticity) -> object:
        inverse = whole(body)
        return 0.5 * inverse if body._blocked else inverse

    monkeypatch.setattr("stiffkit.fea.elasticity._REFINEMENTS", 1)
    monkeypatch.setattr(Elasticity, "_invert", wrong_in_blocks)
    k = short_beam("clamped", "average").compliance
    np.testing.assert_allclose(k, wanted, atol=1e-8 * wanted.max())


def test_the_adaptive_loop_ends_below_its_tolerance_or_says_why() -> None:
    whole = part("beam", length=50.0)
    settings = AdaptSettings(tolerance=0.02, solve=ORDER_2)
    seen: list[int] = []
    result = adapt(
        whole, ends(whole), [STEEL], settings, progress=lambda x: seen.append(x.n_unknowns)
    )
    assert result.converged
    assert result.estimate <= 0.02
    assert seen == [level.n_unknowns for level in result.history]
    few = adapt(whole, ends(whole), [STEEL], replace(settings, tolerance=1e-9, max_unknowns=3000))
    assert not few.converged
    assert "of 3000 allowed" in few.stopped


def foot_ports(foot: Part) -> tuple[Port, ...]:
    return named_ports(foot, {"ground": "clamped", "bore": "average"})


def test_each_solution_on_a_mesh_contains_the_one_before() -> None:
    """Curved faces and cut elements included: the compliance only grows, for every wrench."""
    whole = part("foot")
    settings = AdaptSettings(tolerance=6e-3, solve=SolveSettings(threads=1))
    result = adapt(whole, foot_ports(whole), [STEEL], settings)
    assert result.converged
    assert result.mesh.cuts > 0
    own = [level for level in result.history if level.mesh == result.level.mesh]
    assert len(own) >= 3
    for before, after in pairwise(own):
        gained = whitened(after.compliance - before.compliance, after.compliance)
        assert np.linalg.eigvalsh(gained)[0] > -1e-9


def test_a_mesh_that_cannot_be_bettered_in_time_leaves_the_first_answer() -> None:
    whole = part("foot")
    settings = AdaptSettings(tolerance=1e-5, max_unknowns=8000)
    result = adapt(whole, foot_ports(whole), [STEEL], settings)
    assert not result.converged
    assert result.estimate == min(level.estimate for level in result.history)
    assert result.model.n_unknowns == result.level.n_unknowns
    assert np.all(np.isfinite(result.model.modes(2)[1]))


def test_a_link_needs_two_ports() -> None:
    with pytest.raises(CadError, match="two ports"):
        reduce_part(
            mesh("beam", 0.01, length=50.0),
            ends(part("beam", length=50.0))[:1],
            [STEEL],
            ORDER_2,
        )


def test_a_solve_that_fails_leaves_the_one_before_it_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its factor was given back to make room, and its modes are still asked for."""
    solved: list[int] = []

    def once(*arguments: Any) -> PortModel:
        settings: SolveSettings = arguments[3]
        solved.append(settings.order)
        if len(solved) == 3:
            raise CadError("the memory does not suffice")
        model: PortModel = reduce_part(*arguments)
        return model

    monkeypatch.setattr(import_module("stiffkit.fea.adapt"), "reduce_part", once)
    bar = part("beam", length=50.0)
    found = adapt(bar, ends(bar, "clamped", "average"), [STEEL], AdaptSettings(tolerance=1e-9))
    assert "memory" in found.stopped
    assert not found.converged
    assert solved[-1] == solved[-3]
    assert found.model.modes(2)[0].size == 2
