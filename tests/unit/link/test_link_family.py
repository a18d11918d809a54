"""Links between links, against beams whose every length and section is known."""

from __future__ import annotations

import numpy as np
import pytest

from stiffkit.errors import LinkError
from stiffkit.link import MATERIALS, beam_compliance, beam_line
from stiffkit.link.beam import beam_inertia
from stiffkit.link.family import LinkFamily, Range, described, link_family
from stiffkit.link.file import LinkFile
from stiffkit.link.sections import tube
from stiffkit.link.superelement import consistent_superelement
from stiffkit.spatial import Frame

LENGTH = Range("length", 0.25, 0.4)
WALL = Range("wall", 0.002, 0.004)


def beam(place: tuple[float, ...]) -> LinkFile:
    """Return a steel tube of a length and a wall."""
    length, wall = place
    section, steel = tube(0.04, wall), MATERIALS["steel"]
    mass, center, inertia = beam_inertia(length, section, steel)
    line = beam_line(length, section, steel, mass)
    return LinkFile(
        "tube",
        {"tip": Frame.at(length)},
        beam_compliance(length, section, steel),
        mass=mass,
        center_of_mass=center,
        inertia=inertia,
        superelement=consistent_superelement(line, 8, 6),
    )


@pytest.fixture(scope="module")
def family() -> LinkFamily:
    return link_family([LENGTH, WALL], beam, 1e-3)


def error(found: LinkFile, exact: LinkFile) -> float:
    """Return the largest difference of an element, over its diagonal ones."""
    size = np.sqrt(np.diag(exact.compliance))
    return float(np.abs((found.compliance - exact.compliance) / np.outer(size, size)).max())


@pytest.mark.parametrize("place", [(0.25, 0.002), (0.287, 0.0031), (0.39, 0.0022), (0.4, 0.004)])
def test_a_tube_between_tubes(family: LinkFamily, place: tuple[float, float]) -> None:
    found, exact = family.at(place), beam(place)
    assert error(found, exact) < family.error
    np.testing.assert_allclose(found.ports["tip"].position, exact.ports["tip"].position)
    assert found.mass == pytest.approx(exact.mass, rel=1e-9)
    assert found.center_of_mass == pytest.approx(exact.center_of_mass)
    assert found.inertia is not None
    assert exact.inertia is not None
    np.testing.assert_allclose(found.inertia, exact.inertia, rtol=1e-4, atol=1e-12)
    assert found.superelement is not None
    assert exact.superelement is not None
    # The last mode is another one at the ends of the range.
    squares = found.superelement.mode_stiffness
    assert squares.size >= 5
    expected = exact.superelement.mode_stiffness[: squares.size]
    np.testing.assert_allclose(squares, expected, rtol=5e-3)
    assert np.linalg.eigvalsh(found.superelement.mass)[0] > -1e-9


def test_the_error_is_found_and_reached(family: LinkFamily) -> None:
    assert 0.0 < family.error < 1e-3
    assert family.n > 3


def test_a_loose_tolerance_takes_fewer_solutions() -> None:
    solved: list[tuple[float, ...]] = []

    def solve(place: tuple[float, ...]) -> LinkFile:
        solved.append(place)
        return beam(place)

    rough = link_family([LENGTH, WALL], solve, 0.5)
    assert rough.n == 5
    assert len(solved) == 25  # those of the coarser set are among the finer one's
    assert "%" in described(rough, {"length": 0.3})
    limited = link_family([LENGTH, WALL], beam, 1e-12, most=3)
    assert np.isinf(limited.error)
    assert "unknown" in described(limited, {})


def test_beyond_the_range(family: LinkFamily) -> None:
    assert error(family.at((0.401, 0.003)), beam((0.401, 0.003))) < 1e-3
    with pytest.raises(LinkError, match=r"length is 0.5 \(SI\)"):
        family.at((0.5, 0.003))
