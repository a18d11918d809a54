"""Advice on loads for a link that is known from a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stiffkit.errors import FieldError
from stiffkit.files import read_source, read_tree
from stiffkit.identify.advisor import ACCURACY, DeflectionNoise, LoadAdvice, advise
from stiffkit.identify.identified_link import IdentifiedLink, identify_link
from stiffkit.link.file import read_link_file

FEWEST = 8
"""Nodes of a cubic field."""


@dataclass(frozen=True)
class LinkAdvice:
    """How large the six pure loads on a link should be."""

    title: str
    basis: str
    """What the advice rests on, in words."""
    accuracy: float
    loads: tuple[LoadAdvice, ...]


def advise_link(
    path: Path | str,
    sigma: float | None = None,
    size: float | None = None,
    count: int | None = None,
    accuracy: float = ACCURACY,
) -> LinkAdvice:
    """Return advice for the link of a link file, or of a specification of an identification.

    ``sigma`` is the noise of a node's displacement in m, ``size`` the edge in m of a cubic field
    with ``count`` nodes. A specification has both in itself, so that there they only replace its
    own. Raises FileError where the file is wrong, FieldError where something is missing.
    """
    path = Path(path)
    root = read_tree(read_source(path), "identify: TITLE")
    link = identify_link(path) if root.child("identify") is not None else None
    if link is None:
        file = read_link_file(path)
        title, compliance = file.title, file.compliance
    else:
        title, compliance = link.spec.title, link.found.symmetrised
        sigma = link.sigma if sigma is None else sigma
    if sigma is None:
        raise FieldError(_MISSING, mend=_GIVE)
    field, noise = _field(link, sigma, size, count)
    basis = (
        f"{field}, noise of {1e6 * sigma:.3g} um: deflections are read to "
        f"{1e6 * noise.translation:.3g} um and {1e6 * noise.rotation:.3g} urad"
    )
    return LinkAdvice(title, basis, accuracy, advise(compliance, noise, accuracy))


_MISSING = "a link file does not say how its deflections will be read"
_GIVE = "give the noise, and the size and the number of nodes of the field"


def _field(
    link: IdentifiedLink | None, sigma: float, size: float | None, count: int | None
) -> tuple[str, DeflectionNoise]:
    """Return the field in words, and the noise of deflections that are read from it."""
    if size is not None and count is not None:
        if not size > 0.0 or count < FEWEST:
            raise FieldError(
                f"no cubic field has the size {1e3 * size:g} mm and {count} nodes",
                mend=f"give a size above zero and at least {FEWEST} nodes",
            )
        words = f"a cubic field of {1e3 * size:g} mm with {count} nodes"
        return words, DeflectionNoise.of_cube(size, count, sigma)
    if size is not None or count is not None or link is None:
        raise FieldError(_MISSING if link is None else "half a field is given", mend=_GIVE)
    noise = DeflectionNoise.of_field(link.chosen.field, link.found.reference, sigma)
    return link.chosen.words, noise
