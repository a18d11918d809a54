"""What Briot 2009 says of longer legs, beside what comes out here: figures 6, 12 and 13."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffkit.reproduce.briot_2009_family import (
    PLACES,
    Member,
    analyse,
    at_places,
    family_robot,
    read_deflection,
    study_member,
    twists_of,
    with_rigid_legs,
)
from stiffkit.reproduce.briot_2009_optimum import AIMS, LONGEST, SHORTEST, Aim, Family
from stiffkit.reproduce.briot_2009_words import PLANAR, UM, unknown
from stiffkit.reproduce.statements import Outcome, Statement
from stiffkit.reproduce.trend import Trend
from stiffkit.spatial.rotation import Array

_RANGE = "the range of alpha is not printed, and the text has no values of the curves"


@dataclass(frozen=True, eq=False)
class RigidLegs:
    """The same family when its feet and drives alone yield."""

    alphas: Array
    """(A,)."""
    deflections: dict[str, Array]
    """(A, 3), m, by the load, refined model."""


def study_rigid_legs(n: int = 8) -> RigidLegs:
    """Return the deflections in the plane of ``n`` members whose legs are rigid."""
    alphas = np.linspace(SHORTEST, LONGEST, n)
    found: dict[str, list[Array]] = {load: [] for load in PLANAR}
    for alpha in alphas:
        analysis = analyse(with_rigid_legs(family_robot(float(alpha))))
        twists = twists_of(analysis, at_places(analysis), "refined")
        for load, values in found.items():
            values.append(read_deflection(load, twists[load]))
    return RigidLegs(alphas, {load: np.array(values) for load, values in found.items()})


def family_statements(family: Family, rigid: RigidLegs, other: Family) -> list[Statement]:
    """Return sections 2.3 and 3.3. ``other`` is by the other reading of the equivalent beams."""
    return [
        *(
            unknown(
                figure, printed, f"alpha from {SHORTEST:g} to {LONGEST:g}, see the data", _RANGE
            )
            for figure, printed in (
                ("Fig. 6", "deflections over alpha"),
                ("Fig. 12", "the first natural frequency over alpha, simplified model"),
                ("Fig. 13", "the first and second natural frequency over alpha, refined model"),
            )
        ),
        _planar(family, rigid),
        _along_z(family),
        _beside_z(family),
        _simplified(family),
        _bending_along_z(family),
        _planar_mode(family),
        _others(family),
        *(_optimum(aim, family, other) for aim in AIMS),
    ]


def _trends(x: Array, curves: Array) -> list[Trend]:
    """Return the trends of curves (A, 3) at the three places."""
    return [Trend(x, curve, float(curves.max())) for curve in curves.T]


def _words(trends: list[Trend], factor: float, unit: str) -> str:
    found = zip(PLACES, trends, strict=True)
    return f"({unit}) " + "; ".join(f"{place} {trend.words(factor)}" for place, trend in found)


def _planar(family: Family, rigid: RigidLegs) -> Statement:
    trends = {load: _trends(family.alphas, family.deflection("refined", load)) for load in PLANAR}
    share = {
        alpha: 1.0
        - rigid.deflections["f_y"][k, 0] / study_member(alpha).deflections["refined"]["f_y"][0]
        for k, alpha in ((0, float(rigid.alphas[0])), (-1, float(rigid.alphas[-1])))
    }
    legs = " and ".join(f"{100.0 * part:.0f} % at alpha {alpha:g}" for alpha, part in share.items())
    stiff = {load: _trends(rigid.alphas, rigid.deflections[load]) for load in PLANAR}
    return Statement(
        "2.3, Fig. 6",
        "the longer the legs, the smaller the planar deformations",
        ". ".join(f"{load} {_words(found, UM, 'um')}" for load, found in trends.items()),
        Outcome.of(*(t.shape == "falls" for found in trends.values() for t in found)),
        "a beam of constant section yields along itself in proportion to its length, and longer"
        " legs, which lean more, take larger forces under f_y; the legs have"
        f" {legs} of the deflection under f_y at the centre. With rigid legs "
        + "; ".join(f"{load} {_words(found, UM, 'um')}" for load, found in stiff.items())
        + ". So it is what the simplified model says, and true of the refined one where the legs'"
        " own share is small",
    )


def _along_z(family: Family) -> Statement:
    trends = _trends(family.alphas, family.deflection("refined", "f_z"))
    return Statement(
        "2.3, Fig. 6",
        "with longer legs the deformations along z increase",
        f"f_z {_words(trends, UM, 'um')}",
        Outcome.of(*(trend.shape == "rises" for trend in trends)),
    )


def _beside_z(family: Family) -> Statement:
    largest = float(family.curve(lambda member: member.beside_z).max())
    return Statement(
        "2.3, Fig. 6",
        "under f_z the deformations along the other directions are null",
        f"they are at most {100.0 * largest:.2g} % of that along z",
        Outcome.of(largest < 0.01),
    )


def _simplified(family: Family) -> Statement:
    trends = _trends(family.alphas, family.curve(lambda member: member.simplified))
    return Statement(
        "3.3, Fig. 12",
        "simplified model: the longer the legs, the higher the natural frequency",
        _words(trends, 1.0, "Hz"),
        Outcome.of(*(trend.shape == "rises" for trend in trends)),
        "at the ends one leg lies across and holds the tool along x without its drive; along y the"
        " other drive alone is left, sqrt(K / m) / (2 pi), whatever the lengths",
    )


def _bending_along_z(family: Family) -> Statement:
    trends = _trends(family.alphas, family.curve(lambda member: member.along_z))
    return Statement(
        "3.3, Fig. 13",
        "refined model, bending of the robot along z: longer legs, smaller frequency",
        _words(trends, 1.0, "Hz"),
        Outcome.of(*(trend.shape == "falls" for trend in trends)),
    )


def _planar_mode(family: Family) -> Statement:
    trends = _trends(family.alphas, family.curve(lambda member: member.in_plane))
    return Statement(
        "3.3, Fig. 13",
        "refined model, planar mode (bending of leg 1): longer legs, smaller frequency",
        _words(trends, 1.0, "Hz"),
        Outcome.of(*(trend.shape == "falls" for trend in trends)),
        "where it rises the planar mode bends the feet, which short legs load with larger forces;"
        " it falls once the leg's own bending has the most of its energy",
    )


def _others(family: Family) -> Statement:
    def margin(member: Member) -> Array:
        return np.asarray(member.third - np.maximum(member.along_z, member.in_plane))

    least = float(family.curve(margin).min())
    return Statement(
        "3.3, Fig. 13",
        "no other natural frequency is inferior to these two",
        f"the third is at least {least:.2g} Hz above them",
        Outcome.of(least > 0.0),
    )


def _value(aim: Aim, alpha: float) -> str:
    value = aim.of(study_member(alpha), "refined")
    return f"{value:.3g} Hz" if aim.is_high else f"{UM * value:.3g} um"


def _optimum(aim: Aim, family: Family, other: Family) -> Statement:
    best = family.best[aim.name]
    simplified, refined = best["simplified"], best["refined"]
    reading = other.best[aim.name]["refined"].words
    costs = " and ".join(
        f"{_value(aim, alpha)} with alpha {alpha:.2f}"
        for alpha in (simplified.near[0], simplified.alpha)
    )
    return Statement(
        "3.3, Figs 12 and 13" if aim.is_high else "2.3, Fig. 6",
        "the best legs are shorter than the simplified model foresees",
        f"{aim.name}: simplified model {simplified.words}; refined model {refined.words}, with"
        f" {_value(aim, refined.alpha)}. What the simplified model prefers has {costs}",
        Outcome.of(refined.near[1] < simplified.near[0]),
        "here the legs' compliances and those of the beams have the diagonal in common; where their"
        f" stiffnesses have it, as section 2.3 may be read, the refined model says {reading}",
    )
