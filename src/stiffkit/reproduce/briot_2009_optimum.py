"""Briot 2009, figures 6, 12 and 13 over alpha, and the alpha that each model finds best.

The range of alpha is not printed; here it goes from 0.6 to 2. Legs of 0.455 just reach the ends of
the stroke, and near there the machine is close to a singular posture at its centre.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from stiffkit.progress import Progress
from stiffkit.reproduce.briot_2009_family import MODELS, PLACES, Member, Reading, study_member
from stiffkit.spatial.rotation import Array
from stiffkit.stiffness import Model

SHORTEST, LONGEST = 0.6, 2.0
"""The range of alpha."""
NEAR = 0.01
"""How far from the best value, relative to it, a design is as good."""
STEPS = 29
"""Values of alpha in the figures."""


@dataclass(frozen=True)
class Aim:
    """What the legs are chosen for."""

    name: str
    of: Callable[[Member, Model], float]
    is_high: bool
    """Whether it is to be high."""

    def cost(self, member: Member, model: Model) -> float:
        """Return what is to be low."""
        value = self.of(member, model)
        return 1.0 / value if self.is_high else value


AIMS = (
    Aim("least deflection, centre", lambda member, m: float(member.largest(m)[0]), False),
    Aim("least deflection, worst place", lambda member, m: float(member.largest(m).max()), False),
    Aim("highest first frequency, centre", lambda member, m: float(member.first(m)[0]), True),
    Aim(
        "highest first frequency, worst place",
        lambda member, m: float(member.first(m).min()),
        True,
    ),
)
"""The paper's "global deformations" are taken as the largest of the deflections under the forces
along x, y and z, and "the poorest natural frequency" as the lowest of all modes."""


@dataclass(frozen=True)
class Optimum:
    """The alpha that one model finds best for one aim."""

    alpha: float
    value: float
    """m or Hz."""
    near: tuple[float, float]
    """The shortest and the longest legs whose value is within `NEAR` of the best."""

    @property
    def is_longest(self) -> bool:
        """Whether no legs are found better than the longest, within `NEAR`."""
        return self.near[1] >= LONGEST

    @property
    def words(self) -> str:
        """What the model says."""
        shortest, longest = self.near
        if shortest <= SHORTEST and self.is_longest:
            return "all alike"
        if self.is_longest:
            return f"the longest, from {shortest:.2f} on within {100.0 * NEAR:g} %"
        return f"{self.alpha:.2f}, {shortest:.2f} to {longest:.2f} within {100.0 * NEAR:g} %"


@dataclass(frozen=True, eq=False)
class Family:
    """The members in order of alpha, and the best by each aim and model."""

    members: tuple[Member, ...]
    best: Mapping[str, Mapping[Model, Optimum]]
    """By the name of the aim."""

    @property
    def alphas(self) -> Array:
        """(A,)."""
        return np.array([member.alpha for member in self.members])

    def curve(self, take: Callable[[Member], Array]) -> Array:
        """Return a quantity (A, 3) over alpha, at the three places."""
        return np.array([take(member) for member in self.members])

    def deflection(self, model: Model, load: str) -> Array:
        """Return the deflection (A, 3) under a load, m."""
        return self.curve(lambda member: member.deflections[model][load])

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON, SI."""
        loads = self.members[0].deflections["refined"]
        return {
            "alpha": self.alphas.tolist(),
            "places": list(PLACES),
            "deflection": {
                model: {load: self.deflection(model, load).tolist() for load in loads}
                for model in MODELS
            },
            "frequency": {
                "simplified": self.curve(lambda member: member.simplified).tolist(),
                "refined_along_z": self.curve(lambda member: member.along_z).tolist(),
                "refined_in_plane": self.curve(lambda member: member.in_plane).tolist(),
            },
            "best_alpha": {
                aim: {
                    model: {"alpha": one.alpha, "value": one.value, "near": list(one.near)}
                    for model, one in found.items()
                }
                for aim, found in self.best.items()
            },
        }


def study_family(
    n: int = STEPS, progress: Progress | None = None, reading: Reading = "compliance"
) -> Family:
    """Return figures 6, 12 and 13 at ``n`` values of alpha, and what each model finds best."""
    members = []
    for k, alpha in enumerate(np.linspace(SHORTEST, LONGEST, n)):
        if progress is not None:
            progress("legs of other lengths", k / n)
        members.append(study_member(float(alpha), reading))
    best = {
        aim.name: {model: _best(tuple(members), aim, model, reading) for model in MODELS}
        for aim in AIMS
    }
    return Family(tuple(members), best)


def _best(members: tuple[Member, ...], aim: Aim, model: Model, reading: Reading) -> Optimum:
    costs = [aim.cost(member, model) for member in members]
    k = int(np.argmin(costs))
    best = members[k]
    if 0 < k < len(members) - 1:
        found = minimize_scalar(
            lambda alpha: aim.cost(study_member(float(alpha), reading), model),
            bounds=(members[k - 1].alpha, members[k + 1].alpha),
            method="bounded",
            options={"xatol": 2e-3},
        )
        best = min(
            (best, study_member(float(found.x), reading)), key=lambda one: aim.cost(one, model)
        )
    around = sorted({*members, best}, key=lambda one: one.alpha)
    alphas = np.array([member.alpha for member in around])
    excess = np.array([aim.cost(member, model) for member in around])
    excess = excess / aim.cost(best, model) - 1.0 - NEAR
    at = around.index(best)
    near = (_edge(alphas[at::-1], excess[at::-1]), _edge(alphas[at:], excess[at:]))
    return Optimum(best.alpha, aim.of(best, model), near)


def _edge(alphas: Array, excess: Array) -> float:
    """Return how far it is good from the first of the alphas (n,): up to where excess (n,) is 0."""
    beyond = np.flatnonzero(excess > 0.0)
    if beyond.size == 0:
        return float(alphas[-1])
    around = slice(beyond[0] - 1, beyond[0] + 1)
    return float(np.interp(0.0, excess[around], alphas[around]))
