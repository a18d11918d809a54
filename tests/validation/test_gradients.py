"""Exact derivatives against differences, for every parameter of the catalogue's robots.

Differences of the fourth order across a ten-thousandth of a parameter are good to some 1e-9 of the
quantity; 1e-6 of it is asked. The postures lie inside the workspace, where no branches meet.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffkit.compiled import GeometriesFunction
from stiffkit.kinematics import SpanningTree
from stiffkit.robot import list_robots, load_robot
from stiffkit.stiffness import Model
from stiffkit.stiffness.indices import full_matrices
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.closing import Closing
from stiffkit.study.sweep.engine import Engine, compliances
from stiffkit.study.sweep.family import Family, Geometry
from stiffkit.study.sweep.gradients import Gradients, PosturesOf
from stiffkit.study.sweep.group import Groups
from stiffkit.study.sweep.prepare import make_anchors
from stiffkit.study.sweep.spec import Column, StudySpec, Varied
from stiffkit.vibration import ModalModel

Array = NDArray[np.float64]

FROM_CAD = {"biglide-cad", "orthoglide-cad"}
"""Their parameters are those of parts, each of which would be solved anew."""

ALIKE = {"orthoglide", "orthoglide-multi-beam", "biglide-elastic-tool"}
"""Slow, and others of the same mechanism are there."""

STENCIL = ((1e-4, 8.0 / 12.0), (2e-4, -1.0 / 12.0))


def engine_of(name: str, models: tuple[Model, ...] = ("refined",)) -> Engine:
    """Return an engine with all parameters of a robot varied."""
    robot = load_robot(name)
    varied = tuple(
        Varied(p.name, (0.99 * p.value, 1.01 * p.value), p.unit) for p in robot.parameters.values()
    )
    column = Column("weakest", "min", "stiffness_translation_min")
    spec = StudySpec("all parameters", name, varied, 1, 0, 30, models, 0, (column,))
    groups = Groups(Family(spec), "numpy")
    return Engine(groups, make_anchors(groups), None)


def sizes_of(postures: PosturesOf) -> Array:
    """Return how large the parameters are (k,), by their values or their ranges."""
    return np.asarray(np.maximum(np.abs(postures.values), 0.1 * postures.family.span))


def inner_postures(postures: PosturesOf) -> NDArray[np.intp]:
    """Return a few postures that are not at the workspace's ends."""
    grid = postures.family.grid
    inside = grid.inside & postures.reached
    if not grid.listed:
        for name, values in grid.values().items():
            ends = grid.axes[name][[0, -1]]
            inside &= (values != ends[0]) & (values != ends[1])
    return np.flatnonzero(inside)[:3]


def neighbours(engine: Engine, postures: PosturesOf) -> list[tuple[int, float, Geometry]]:
    """Return (parameter, weight, geometry): weighted sums over them are derivatives."""
    found = []
    for i, step in enumerate(sizes_of(postures)):
        for share, weight in STENCIL:
            for sign in (1.0, -1.0):
                moved = postures.values.copy()
                moved[i] += sign * share * step
                scale = sign * weight / (STENCIL[0][0] * step)
                found.append((i, scale, engine.family.geometry(moved)))
    return found


def by_differences(values: Array, around: list[tuple[int, float, Geometry]], k: int) -> Array:
    """Return derivatives (k, N) from values (G, N) at neighbours."""
    slopes = np.zeros((k, values.shape[1]))
    for row, (i, weight, _) in zip(values, around, strict=True):
        slopes[i] += weight * row
    return slopes


def extreme(lower: Array, first: int, which: int) -> Array:
    """Return stiffnesses by LAPACK: the closed form is not good enough for small differences."""
    block = full_matrices(lower.reshape(21, -1))[first : first + 3, first : first + 3]
    values = 1.0 / np.linalg.eigvalsh(np.moveaxis(block, 2, 0))[:, which]
    return np.asarray(values.reshape(lower.shape[1:]))


def solved(
    engine: Engine, postures: PosturesOf, around: list[tuple[int, float, Geometry]], model: Model
) -> Array:
    """Return the compliances (21, G, P) of neighbours."""
    geometries = [geometry for _, _, geometry in around]
    near = np.zeros((1, len(geometries)), dtype=np.intp)
    closing = Closing(postures.group, geometries, engine.anchors, near)
    homes = closing.homes()
    assert not any(homes.reasons)
    q, reached = closing.postures(np.arange(len(geometries)), homes)
    own = next(m for m in postures.group.models if m.model == model)
    return compliances(postures.group, own, geometries, q, reached)[0]


@pytest.mark.parametrize("name", sorted(set(list_robots()) - FROM_CAD - ALIKE))
def test_compliances_and_deflections(name: str) -> None:
    engine = engine_of(name)
    postures = Gradients(engine).postures(engine.family.own_values())
    assert postures is not None
    at = inner_postures(postures)
    assert at.size
    lower, ok = postures.compliances("refined")
    assert ok[at].all()
    around = neighbours(engine, postures)
    moved = solved(engine, postures, around, "refined")[:, :, at]
    sizes = sizes_of(postures)[:, None]

    def check(quantity: str, load: str | None, values: Array, here: Array) -> None:
        expected = by_differences(values, around, postures.values.size)
        found = postures.quantity_slopes(quantity, load, "refined", at, lower[:, at])
        error = np.abs(found - expected) * sizes / here
        assert error.max() < 1e-6, (quantity, load)

    robot = engine.family.robot
    loads = list(robot.loads)
    for load, name in ((loads[0], "deflection_translation"), (loads[-1], "deflection_rotation")):
        read = QUANTITIES[name].of_compliance
        here = read(lower[:, at], robot.loads[load].wrench)
        wrenches = [g.robot.loads[load].wrench for _, _, g in around]
        values = [read(moved[:, i], w) for i, w in enumerate(wrenches)]
        if np.all(here > 1e-9 * np.abs(here).max()) and here.max() > 1e-15:
            check(name, load, np.array(values), here)
    for quantity, first in (("stiffness_translation_min", 0), ("stiffness_rotation_min", 3)):
        block = np.moveaxis(full_matrices(lower[:, at])[first : first + 3, first : first + 3], 2, 0)
        eigenvalues = np.linalg.eigvalsh(block)
        if np.all(eigenvalues[:, 2] > 1.001 * eigenvalues[:, 1]):
            check(quantity, None, extreme(moved, first, 2), extreme(lower[:, at], first, 2))


@pytest.mark.parametrize("name", ["biglide-scaled", "five-bar", "hexapod-cubic", "delta"])
def test_frequencies(name: str) -> None:
    engine = engine_of(name)
    postures = Gradients(engine).postures(engine.family.own_values())
    assert postures is not None
    at = inner_postures(postures)[:1]
    length, n = postures.geometry.length, postures.group.tree.n_coordinates
    around = neighbours(engine, postures)
    tangent = postures.unknowns_slopes(at)[:, :n]
    values = []
    for i, _, geometry in around:
        moved = geometry.robot.parameters[engine.family.spec.varied[i].name].value
        q = postures.q[:n, at] + (moved - postures.values[i]) * tangent[i]
        model = ModalModel(SpanningTree.of(geometry.robot), length, backend="numpy")
        values.append([next(model.at_each(q, 1)).frequencies_hz[0]])
    lowest, found = postures.frequency_slopes(at)
    expected = by_differences(np.array(values), around, postures.values.size)
    sizes = sizes_of(postures)[:, None]
    assert (np.abs(found - expected) * sizes / lowest).max() < 1e-6


@pytest.mark.parametrize("name", ["biglide", "delta"])
def test_postures_follow_their_parameters(name: str) -> None:
    """Unknowns moved along their derivatives close the loops of neighbours to the second order."""
    engine = engine_of(name)
    postures = Gradients(engine).postures(engine.family.own_values())
    assert postures is not None
    at = inner_postures(postures)
    tangent = postures.unknowns_slopes(at)
    residuals = GeometriesFunction(postures.group.closure.residuals(), "numpy")
    for i, step in enumerate(1e-4 * sizes_of(postures)):
        sizes = []
        for share in (1.0, 0.5):
            moved = postures.values.copy()
            moved[i] += share * step
            neighbour = Gradients(engine).postures(moved)
            assert neighbour is not None
            q = postures.q[:, at] + share * step * tangent[i]
            c = neighbour.geometry.constants[: postures.group.n_geometric]
            evaluate = residuals.at(c[:, None], np.zeros(at.size, dtype=np.intp))
            sizes.append(np.abs(evaluate(np.concatenate([q, neighbour.asked[:, at]]))).max())
        # Half the step leaves a quarter of what does not close, or rounding.
        assert sizes[1] < max(0.3 * sizes[0], 1e-12)
