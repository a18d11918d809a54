"""What is done once, before any row of a study is computed: the anchors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import StiffkitError
from stiffkit.kinematics.jump import responses
from stiffkit.robot import DIRECTIONS
from stiffkit.study.sweep.anchors import Anchors
from stiffkit.study.sweep.closing import Closing
from stiffkit.study.sweep.engine import NEAREST
from stiffkit.study.sweep.family import Geometry
from stiffkit.study.sweep.group import Groups
from stiffkit.study.sweep.sampling import parameter_values

Array = NDArray[np.float64]

_CANDIDATES = 2000
"""Geometries among which anchors are chosen."""
_MOST_ANCHORS = 64
_MOST_IN_VAIN = 12
"""Candidates in a row that are not reached before no more anchors are looked for.

Each costs a good part of a second, whatever is asked of the study. Where so many far apart fail one
after the other, hardly any geometry can be assembled, and those that can begin at the anchors that
there are. It is a number of candidates and not a time, so that the anchors, and with them all rows,
are the same on any machine.
"""
_MOST_POSTURES = 200_000
"""Postures of all anchors together."""
_SMALLEST_PIECE = 1.0 / 8.0


def make_anchors(groups: Groups) -> Anchors:
    """Return the anchors of a study: the file's own geometry, and others far apart.

    Of a study whose geometries cannot be assembled the file's own is the only one.
    """
    family = groups.family
    anchors = own_anchor(groups)
    wanted = int(np.clip(_MOST_POSTURES // family.n_postures, 1, _MOST_ANCHORS))
    spec = family.spec
    numbers = np.unique(np.linspace(0, spec.n_geometries - 1, _CANDIDATES).astype(np.intp))
    candidates = parameter_values(spec, numbers)
    span = family.span
    apart = np.full(numbers.size, np.inf)
    newest = anchors.values[:, 0]
    in_vain = 0
    while anchors.number < wanted and in_vain < _MOST_IN_VAIN:
        difference = (candidates - newest[:, None]) / span[:, None]
        apart = np.minimum(apart, np.sum(difference**2, axis=0))
        if apart.max() == 0.0:
            break
        newest = candidates[:, int(np.argmax(apart))]
        found = _next(groups, anchors, newest)
        if found is None:
            in_vain += 1
        else:
            anchors, in_vain = anchors.with_one_more(found), 0
    return anchors


def own_anchor(groups: Groups) -> Anchors:
    """Return the file's own geometry, solved as a map solves it."""
    family = groups.family
    values = family.own_values()
    geometry = family.geometry(values)
    kinematics, closure = family.kinematics, family.kinematics.closure
    postures = family.reference_postures()
    extra = [DIRECTIONS.index(d) for d in closure.auxiliary]
    q = np.concatenate([postures.coordinates, postures.tool[extra]])
    home = kinematics.home_found.unknowns
    return anchor_of(groups, geometry, values, home, q, postures.tool)


def _next(groups: Groups, anchors: Anchors, values: Array) -> Anchors | None:
    """Return another anchor, reached from those that there are; None if it cannot be assembled.

    The way there is cut into pieces where it is too long for the assembly mode to be followed.
    """
    nearest = anchors.nearest(values[:, None], groups.family.span, 1)[0, 0]
    start = anchors.values[:, nearest]
    done, piece = 0.0, 1.0
    found: Anchors | None = None
    while done < 1.0:
        share = min(done + piece, 1.0)
        found, followed = _solved(groups, anchors, start + share * (values - start))
        if found is not None and (followed or piece <= _SMALLEST_PIECE):
            anchors, done = anchors.with_one_more(found), share
        elif piece > _SMALLEST_PIECE:
            piece *= 0.5
        else:
            return _solved(groups, anchors, values)[0]
    return found


def _solved(groups: Groups, anchors: Anchors, values: Array) -> tuple[Anchors | None, bool]:
    """Return a geometry as an anchor, and whether it goes on in the assembly mode of another."""
    family = groups.family
    try:
        geometry = family.geometry(values)
    except StiffkitError:
        return None, False
    near = anchors.nearest(values[:, None], family.span, NEAREST)
    closing = Closing(groups.of(geometry), [geometry], anchors, near)
    homes = closing.homes()
    if homes.reasons[0]:
        return None, False
    q, _ = closing.postures(np.zeros(1, dtype=np.intp), homes)
    tool = np.repeat(homes.tool, family.n_postures, axis=1)
    own = anchor_of(groups, geometry, values, homes.unknowns[:, 0], q[:, 0], tool)
    return own, bool(homes.continued[0])


def anchor_of(
    groups: Groups,
    geometry: Geometry,
    values: Array,
    home: Array,
    q: Array,
    tool: Array,
) -> Anchors:
    """Return one anchor from its home (n_home,), its postures (n, P) and tool poses (6, P)."""
    family, group = groups.family, groups.of(geometry)
    own = geometry.constants[: group.n_geometric, None]
    asked = [
        geometry.poses[family.swept.index(d)] if d in family.swept else tool[DIRECTIONS.index(d)]
        for d in family.asked
    ]
    poses = np.array(asked).reshape(len(asked), q.shape[1])
    step = group.step.at(own, np.zeros(q.shape[1], dtype=np.intp))
    return Anchors(
        values=values[:, None],
        home=home[:, None],
        home_response=responses(
            group.home_step.at(own, np.zeros(1, dtype=np.intp)),
            home[:, None],
            geometry.home[:, None],
        ),
        hints=geometry.hints[:, None],
        q=q[:, None],
        response=responses(step, q, poses)[:, None],
    )
