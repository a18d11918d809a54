"""The task that all programs get: a planar Biglide whose legs are slender steel beams.

Two sliders run along y at x = 0 and x = a, each held by a drive of finite stiffness. A leg hangs on
each by a hinge about z; the legs meet in a third hinge at the tool point P, whose mass moves with
leg 1. The sliders are massless and rigid. Beams do not deform in shear, so that no program has to
agree with another on shear coefficients. Asked for: the translational compliance of P (3, 3), and
the lowest four natural frequencies, in space, at given postures.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

A = 0.92
"""m, distance of the slides."""
LENGTHS = (0.85, 0.775)
"""m, of the legs."""
DRIVE = 1e8
"""N/m."""
TOOL_MASS = 46.0
"""kg."""
E_MODULUS, NU, DENSITY = 210e9, 0.3, 7850.0
G_MODULUS = E_MODULUS / (2.0 * (1.0 + NU))
AREA, I_Y, I_Z, TORSION = 2.4e-3, 2.0e-6, 2.0e-6, 4.0e-6
"""m^2 and m^4. A round tube: its torsion constant is the polar moment of its area, which frame
programs do not agree to take for the inertia of twisting."""
ELEMENTS = 8
"""Beam elements of each leg where frequencies are computed. Compliances are exact with one."""
N_MODES = 4


@dataclass(frozen=True)
class Posture:
    """A posture by the position of P and the two sliders, m."""

    x: float
    y: float
    sliders: tuple[tuple[float, float], tuple[float, float]]

    def nodes(self, leg: int, elements: int) -> list[tuple[float, float]]:
        """Return the ends of the elements of a leg, from its slider to P."""
        (x0, y0), n = self.sliders[leg], elements
        return [(x0 + i / n * (self.x - x0), y0 + i / n * (self.y - y0)) for i in range(n + 1)]


def posture(x: float, y: float) -> Posture:
    """Return the posture with P at (x, y), above both sliders."""
    down = (math.sqrt(LENGTHS[0] ** 2 - x**2), math.sqrt(LENGTHS[1] ** 2 - (A - x) ** 2))
    return Posture(x, y, ((0.0, y - down[0]), (A, y - down[1])))


def postures(n: int) -> list[Posture]:
    """Return n postures along a line through the workspace."""
    return [posture(0.25 + 0.5 * i / max(n - 1, 1), 0.0) for i in range(n)]


@dataclass(frozen=True)
class Answer:
    """What a program makes of the task, and how long it takes."""

    program: str
    version: str
    way: str
    """How the program was used."""
    compliance: list[list[list[float]]]
    """(N, 3, 3), m/N, of P at the postures."""
    frequencies: list[list[float]]
    """(N, 4), Hz."""
    first_static: float
    """s of a processor for the compliance of one posture, model built, libraries loaded before."""
    first_modes: float
    static_rate: float
    """Postures per second of a processor, one after another."""
    modes_rate: float


Matrix = list[list[float]]
_Result = TypeVar("_Result")


def answer(
    program: str,
    version: str,
    way: str,
    static: Callable[[Posture], Matrix],
    modes: Callable[[Posture], list[float]],
    n: int,
) -> Answer:
    """Return what a program says that computes one posture at a time."""
    some = postures(n)
    compliance, first_static, static_seconds = _timed(static, some)
    frequencies, first_modes, modes_seconds = _timed(modes, some)
    return Answer(
        *(program, version, way, compliance, frequencies, first_static, first_modes),
        *(n / static_seconds, n / modes_seconds),
    )


def _timed(
    work: Callable[[Posture], _Result], some: list[Posture]
) -> tuple[list[_Result], float, float]:
    """Return the results, the time of the first posture, and that of all of them once more."""
    start = time.process_time()
    work(some[0])
    first = time.process_time() - start
    start = time.process_time()
    results = [work(p) for p in some]
    return results, first, time.process_time() - start
