"""The same error bars by brute force: many robots drawn at random, each computed anew."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.design.uncertainty.first_order import FirstOrder
from stiffkit.design.uncertainty.links import covariance_of, root_of
from stiffkit.design.uncertainty.spec import UncertaintySpec
from stiffkit.errors import StiffkitError
from stiffkit.progress import Progress
from stiffkit.smallmat import from_lower_triangle
from stiffkit.study.sweep.closing import Closing
from stiffkit.study.sweep.engine import NEAREST, compliances
from stiffkit.study.sweep.family import Geometry

Array = NDArray[np.float64]

_TOGETHER = 250
"""Robots at a time."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """The quantities of n robots drawn at random, at P postures."""

    values: Array
    """(models, asked, n, P), SI; NaN where there is no answer."""
    refused: int
    """Robots that were drawn and cannot be: a length below zero, a compliance that is indefinite,
    loops that cannot be closed."""


def sample(spec: UncertaintySpec, first_order: FirstOrder, progress: Progress) -> Sampled:
    """Return the quantities of robots drawn at random, at the postures of ``first_order``.

    Raises StiffkitError where none of them can be.
    """
    found = []
    drawn = 0
    for geometries in _drawn(spec, first_order):
        drawn += len(geometries)
        progress("sampling", drawn / spec.samples)
        known = [g for g in geometries if g is not None]
        if known:
            found.append(_quantities(spec, first_order, known))
    values = np.concatenate(found, axis=2) if found else np.empty((0, 0, 0, 0))
    if not values.size:
        raise StiffkitError(
            f"none of the {spec.samples} robots that were drawn at random can be built",
            mend="give smaller errors, or 'samples: 0' for the first order alone",
        )
    return Sampled(values, spec.samples - values.shape[2])


def _quantities(
    spec: UncertaintySpec, first_order: FirstOrder, geometries: list[Geometry]
) -> Array:
    """Return the quantities (models, asked, n, P) of those of some robots that can be assembled."""
    family, anchors = first_order.family, first_order.engine.anchors
    centre = np.array([p.value for p in spec.parameters])
    values = np.repeat(centre[:, None], len(geometries), axis=1)
    near = anchors.nearest(values, family.span, NEAREST)
    closing = Closing(first_order.postures.group, geometries, anchors, near)
    homes = closing.homes()
    which = np.flatnonzero([not reason for reason in homes.reasons])
    q, reached = closing.postures(which, homes)
    own = [geometries[i] for i in which]
    rows = []
    for model in closing.group.models:
        lower, _ = compliances(closing.group, model, own, q, reached)
        rows.append([first_order.values(asked, lower) for asked in spec.asked])
    return np.array(rows)


def _drawn(spec: UncertaintySpec, first_order: FirstOrder) -> Iterator[list[Geometry | None]]:
    """Yield robots drawn at random, some at a time; None for those that cannot be."""
    family = first_order.family
    random = np.random.default_rng(spec.seed)
    centre = np.array([p.value for p in spec.parameters])
    sigma = np.array([p.sigma for p in spec.parameters])
    uniform = np.array([p.distribution == "uniform" for p in spec.parameters], dtype=bool)
    links = family.robot.links
    roots = [(u.name, root_of(covariance_of(links[u.name], u))) for u in spec.links]
    for start in range(0, spec.samples, _TOGETHER):
        n = min(_TOGETHER, spec.samples - start)
        normal = random.standard_normal((n, centre.size))
        even = np.sqrt(3.0) * random.uniform(-1.0, 1.0, (n, centre.size))
        values = centre + sigma * np.where(uniform, even, normal)
        errors = [(name, random.standard_normal((n, B.shape[1])) @ B.T) for name, B in roots]
        yield [
            _geometry(first_order, values[i], {name: e[i] for name, e in errors}) for i in range(n)
        ]


def _geometry(first_order: FirstOrder, values: Array, errors: dict[str, Array]) -> Geometry | None:
    """Return the robot with these parameters, and errors added to its links' compliances."""
    geometry = first_order.postures.geometry
    if values.size:
        try:
            geometry = first_order.family.geometry(values)
        except StiffkitError:
            return None
    constants = geometry.constants.copy()
    for name, error in errors.items():
        where = geometry.elasticity.where(f"compliance:{name}")
        constants[where] += error
        S = np.array(from_lower_triangle(constants[where].astype(object)), dtype=float)
        unit_free = np.diag(1.0 / np.sqrt(np.abs(np.diag(S))))
        if np.linalg.eigvalsh(unit_free @ S @ unit_free)[0] <= 0.0:
            return None
    return replace(geometry, constants=constants)
