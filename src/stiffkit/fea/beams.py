"""Approximations of a part by beams, beside what finite elements find."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffkit.errors import LinkError
from stiffkit.files import Entry, read_frame
from stiffkit.link import Material
from stiffkit.link.beam_chain import BeamPiece, chain_compliance, chain_end
from stiffkit.link.written import read_section
from stiffkit.spatial.rotation import Array
from stiffkit.units import LENGTH

_MEETS = 1e-6
"""m, a chain ends at the tip when it comes this near."""


@dataclass(frozen=True, eq=False)
class BeamApproximation:
    """A part as a chain of beams of the part's material, from its base to its tip."""

    name: str
    pieces: tuple[BeamPiece, ...]
    material: Material


@dataclass(frozen=True, eq=False)
class BeamComparison:
    """What a chain of beams gives for a link."""

    name: str
    compliance: Array
    """(6, 6), SI, of the tip with the base held, at the tip's point, link axes."""
    gap: float
    """m, from the chain's end to the tip's point; the way between counts as rigid."""

    @property
    def has_gap(self) -> bool:
        """Whether the chain ends elsewhere than at the tip."""
        return self.gap > _MEETS

    def ratios(self, compliance: Array) -> Array:
        """Return the diagonal (6,) over that of the link's ``compliance`` (6, 6)."""
        return np.asarray(np.diag(self.compliance) / np.diag(compliance))


def read_beams(entry: Entry | None, material: object) -> tuple[BeamApproximation, ...]:
    """Return the approximations of a specification; none if it has none.

    Raises FileError where no beam can be as it says, or the part is not of one isotropic material.
    """
    if entry is None:
        return ()
    if not isinstance(material, Material):
        raise entry.error(
            "beams have the part's material, and it is not isotropic", "leave 'beams' out"
        )
    return tuple(
        BeamApproximation(name, _pieces(given, material), material) for name, given in entry.items()
    )


def compare(beams: Sequence[BeamApproximation], tip: Array) -> tuple[BeamComparison, ...]:
    """Return what beams give at the tip's point (3,), m, in link axes."""
    return tuple(
        BeamComparison(
            one.name,
            chain_compliance(one.pieces, one.material, tip),
            float(np.linalg.norm(chain_end(one.pieces).position - tip)),
        )
        for one in beams
    )


def _pieces(entry: Entry, material: Material) -> tuple[BeamPiece, ...]:
    given = entry.elements() if isinstance(entry.node.value, list) else [entry]
    pieces = tuple(
        BeamPiece(
            one["length"].positive(LENGTH), read_section(one["section"]), read_frame(one).rotation
        )
        for one in given
    )
    try:
        chain_compliance(pieces, material, np.zeros(3))
    except LinkError as error:
        raise entry.blame(error) from None
    return pieces
