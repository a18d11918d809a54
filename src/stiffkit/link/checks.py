"""What no elastic body can have: checks of compliances and inertias that somebody gives.

A check returns faults, in words; an empty list means that the data can be those of a body. A doubt
is a value that is possible but looks like a mistake of unit. Entries are counted from 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.spatial.rotation import Array

SYMMETRY_TOLERANCE = 1e-6
"""Largest difference of mirror entries, relative to the diagonal."""
DEFINITE_TOLERANCE = 1e-12
"""Smallest eigenvalue of a definite matrix scaled to unit diagonal."""
TRIANGLE_TOLERANCE = 2e-3
"""Share of the largest principal moment by which rounded data may miss the triangle inequality."""
LONGEST, SHORTEST = 10.0, 1e-4
"""Metres: levers and radii of gyration outside of these are doubted."""
SOFTEST_TRANSLATION, SOFTEST_ROTATION, STIFFEST = 1.0, 1e3, 1e-14
"""m/N, rad/(N m), and either: diagonal entries outside of these are doubted."""

LOADS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


def symmetrize(matrix: ArrayLike) -> Array:
    """Return the symmetric part of a square matrix: the mean of it and its transpose."""
    M = np.asarray(matrix, dtype=float)
    return np.asarray((M + M.T) / 2.0)


def check_compliance(matrix: ArrayLike, ports: Sequence[str] = ("tip",)) -> list[str]:
    """Return what keeps a matrix from being a compliance, in any unit.

    It has six rows and columns for each of the ``ports`` that are not held, translation first. It
    must be finite, symmetric to 1e-6 of the diagonal, and positive definite. The last is
    tested on the matrix scaled to unit diagonal, so the units do not matter; of a matrix that is
    not symmetric the symmetric part is tested.
    """
    shape_faults = _shape_faults(matrix, 6 * len(ports))
    if shape_faults:
        return shape_faults
    k = np.asarray(matrix, dtype=float)
    diagonal = np.diag(k)
    if diagonal.min() <= 0.0:
        return [
            f"not positive definite: entry {i + 1},{i + 1} = {diagonal[i]:.3g} must be positive"
            for i in np.flatnonzero(diagonal <= 0.0)
        ]
    scale = np.sqrt(np.outer(diagonal, diagonal))
    loads = LOADS if len(ports) == 1 else [f"{load} at {port}" for port in ports for load in LOADS]
    return _asymmetry(k, scale) + _indefiniteness(symmetrize(k), scale, loads)


def doubts_compliance(matrix: ArrayLike) -> list[str]:
    """Return what looks like a wrong unit in a compliance (6p, 6p), SI, free of faults."""
    diagonal = np.diag(np.asarray(matrix, dtype=float))
    doubts = _diagonal_doubts(diagonal)
    translations, rotations = diagonal.reshape(-1, 2, 3).swapaxes(0, 1)
    lever = float(np.sqrt(translations.sum() / rotations.sum()))
    if not SHORTEST <= lever <= LONGEST:
        doubts.append(
            f"translations of up to {translations.max():.3g} m/N beside rotations of up to "
            f"{rotations.max():.3g} rad/(N m) mean levers of about {lever:.3g} m; "
            "another unit, such as mm/N and rad/(N mm), was probably meant"
        )
    return doubts


def check_inertia(mass: float, inertia: ArrayLike) -> list[str]:
    """Return what keeps a mass (kg) and an inertia (3x3, kg m^2) from being those of a body.

    The inertia is about the centre of mass. It must be finite and symmetric, its principal moments
    not negative, and none of them larger than the sum of the other two. A point mass (zeros) and a
    slender rod are bodies.
    """
    faults = []
    if not (mass > 0.0 and np.isfinite(mass)):
        faults.append(f"the mass is {mass:.3g} kg and must be positive")
    shape_faults = _shape_faults(inertia, 3)
    if shape_faults:
        return faults + shape_faults
    J = np.asarray(inertia, dtype=float)
    faults += _asymmetry(J, np.full((3, 3), np.abs(J).max()))
    return faults + _impossible_moments(symmetrize(J))


def doubts_inertia(mass: float, inertia: ArrayLike) -> list[str]:
    """Return what looks like a wrong unit in a mass (kg) and inertia (3x3) free of faults."""
    largest = float(np.linalg.eigvalsh(symmetrize(inertia))[-1])
    radius = float(np.sqrt(max(largest, 0.0) / mass))
    if radius == 0.0 or SHORTEST <= radius <= LONGEST:
        return []
    return [
        f"an inertia of {largest:.3g} kg m^2 with a mass of {mass:.3g} kg means a radius of "
        f"gyration of {radius:.3g} m; another unit, such as kg mm^2, was probably meant"
    ]


def _shape_faults(matrix: ArrayLike, size: int) -> list[str]:
    try:
        M = np.asarray(matrix, dtype=float)
    except (TypeError, ValueError):
        return [f"not a {size}x{size} matrix of numbers"]
    if M.shape != (size, size):
        shape = "x".join(map(str, M.shape)) or "a single number"
        return [f"the matrix must be {size}x{size} and is {shape}"]
    return [
        f"entry {i + 1},{j + 1} is {M[i, j]} and must be a finite number"
        for i, j in np.argwhere(~np.isfinite(M))
    ]


def _asymmetry(M: Array, scale: Array) -> list[str]:
    """Name the pair of mirror entries that differ most, relative to ``scale`` (same shape)."""
    difference = np.abs(M - M.T)
    pairs = [
        (i, j)
        for i, j in combinations(range(len(M)), 2)
        if difference[i, j] > SYMMETRY_TOLERANCE * scale[i, j]
    ]
    if not pairs:
        return []
    i, j = max(pairs, key=lambda pair: float(difference[pair] / scale[pair]))
    upper, lower = M[i, j], M[j, i]
    others = f" (the worst of {len(pairs)} pairs)" if len(pairs) > 1 else ""
    fault = (
        f"not symmetric: entry {i + 1},{j + 1} = {upper:.6g} and entry {j + 1},{i + 1} = "
        f"{lower:.6g} do not agree{others}"
    )
    if upper == -lower:
        return [f"{fault}; one has the wrong sign: correct it (symmetrize would make both zero)"]
    return [f"{fault}; correct one, or symmetrize to take the mean"]


def _indefiniteness(k: Array, scale: Array, loads: Sequence[str]) -> list[str]:
    correlation = k / scale
    values, vectors = np.linalg.eigh(correlation)
    if values[0] > DEFINITE_TOLERANCE:
        return []
    broken = [(i, j) for i, j in combinations(range(len(k)), 2) if abs(correlation[i, j]) >= 1.0]
    if broken:
        return [_broken_minor(k, correlation, broken)]
    load = vectors[:, 0] / np.sqrt(np.diag(k))
    load = load / load[np.argmax(np.abs(load))]
    share = np.abs(vectors[:, 0])
    words = ", ".join(
        f"{name} = {x:.3g}"
        for name, x, part in zip(loads, load, share, strict=True)
        if part > 0.05 * share.max()
    )
    return [
        f"not positive definite: under the load {words} the energy is "
        f"{load @ k @ load / 2.0:.3g}, and it must be positive; at least one of the entries "
        "that join these directions is wrong"
    ]


def _broken_minor(k: Array, correlation: Array, broken: list[tuple[int, int]]) -> str:
    i, j = max(broken, key=lambda pair: abs(float(correlation[pair])))
    a, b, c = k[i, i], k[j, j], k[i, j]
    m, n = i + 1, j + 1
    others = [f"{p + 1},{q + 1}" for p, q in broken if (p, q) != (i, j)]
    also = f"; the same goes for {' and '.join(others)}" if others else ""
    return (
        f"not positive definite: entries {m},{m} = {a:.3g}, {n},{n} = {b:.3g} and "
        f"{m},{n} = {c:.3g} cannot stand together: |k{m}{n}| must stay below "
        f"sqrt(k{m}{m} k{n}{n}) = {np.sqrt(a * b):.3g}, or k{m}{m} above {c * c / b:.3g}, "
        f"or k{n}{n} above {c * c / a:.3g}{also}; correct the wrong entry"
    )


def _diagonal_doubts(diagonal: Array) -> list[str]:
    doubts = []
    for i, entry in enumerate(diagonal):
        moves = i % 6 < 3
        softest, unit = (SOFTEST_TRANSLATION, "m/N") if moves else (SOFTEST_ROTATION, "rad/(N m)")
        if not STIFFEST <= entry <= softest:
            doubts.append(
                f"entry {i + 1},{i + 1} = {entry:.3g} {unit} is hardly that of a link, which has "
                f"{STIFFEST:g} to {softest:g}; another unit was probably meant"
            )
    return doubts


def _impossible_moments(J: Array) -> list[str]:
    principal = np.linalg.eigvalsh(J)
    smallest, middle, largest = principal
    moments = f"principal moments {smallest:.3g}, {middle:.3g} and {largest:.3g} kg m^2"
    if smallest < -SYMMETRY_TOLERANCE * np.abs(principal).max():
        return [f"no body has the {moments}: none may be negative{_suspects(J)}"]
    excess = largest - middle - smallest
    if excess > TRIANGLE_TOLERANCE * largest:
        return [
            f"no body has the {moments}: the largest exceeds the sum of the others by "
            f"{excess:.3g}{_suspects(J)}"
        ]
    return []


def _suspects(J: Array) -> str:
    """Say which entries of an impossible inertia contradict the diagonal.

    The integrals of x^2, y^2, z^2 over the mass are combinations of the diagonal of J; none may be
    negative, and a product of inertia may not exceed the geometric mean of two of them.
    """
    second = np.trace(J) / 2.0 - np.diag(J)
    large = [f"{i + 1},{i + 1} = {J[i, i]:.3g}" for i in range(3) if second[i] < 0.0]
    if large:
        return f"; entry {large[0]} alone exceeds the sum of the other two on the diagonal"
    bounds = {(i, j): np.sqrt(second[i] * second[j]) for i, j in combinations(range(3), 2)}
    hints = [
        f"; entry {i + 1},{j + 1} = {J[i, j]:.3g} is too large for this diagonal, which allows "
        f"at most {bound:.3g}"
        for (i, j), bound in bounds.items()
        if abs(J[i, j]) > bound
    ]
    return "".join(hints)
