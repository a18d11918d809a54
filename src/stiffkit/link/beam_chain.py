"""Beams one after another: the approximation of a part by a few straight pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stiffkit.link.beam import beam_compliance
from stiffkit.link.materials import Material
from stiffkit.link.sections import Section
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array
from stiffkit.spatial.twist import shift_compliance


@dataclass(frozen=True, eq=False)
class BeamPiece:
    """A straight beam in a chain; x along it, y and z the axes of its section."""

    length: float
    """m."""
    section: Section
    turn: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3), columns are its axes in those of the piece before, or of the link for the first."""


def chain_end(pieces: Sequence[BeamPiece]) -> Frame:
    """Return T_link_end, the end of a chain of beams that begins at the link's origin."""
    T_link_end = Frame()
    for piece in pieces:
        T_link_end = T_link_end @ Frame(piece.turn) @ Frame.at(piece.length)
    return T_link_end


def chain_compliance(pieces: Sequence[BeamPiece], material: Material, point: Array) -> Array:
    """Return the compliance (6, 6), SI, at a ``point`` (3,), m, with the chain's begin clamped.

    All in link axes. The point moves with the chain's end as one rigid body, wherever it lies.
    Raises `LinkError` if a length is not positive.
    """
    k = np.zeros((6, 6))
    for n, piece in enumerate(pieces):
        T_link_end = chain_end(pieces[: n + 1])
        T_point_end = Frame.at(*-np.asarray(point, dtype=float)) @ T_link_end
        own = beam_compliance(piece.length, piece.section, material)
        k += shift_compliance(own, T_point_end)
    return k
