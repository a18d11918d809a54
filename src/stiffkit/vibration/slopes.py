"""Derivatives of natural frequencies of a posture along a change of the robot.

With loops L x = 0, energy |E x|^2 / 2 and kinetic energy |B dx|^2 / 2, a mode of unit modal mass
and squared angular frequency w fulfils (E^T E - w B^T B) x + L^T y = 0, and along any change

    dw = d|E x|^2 - w d|B x|^2 + 2 y . (dL x),  x held

(R. B. Nelson, "Simplified calculation of eigenvector derivatives", AIAA J. 14(9), 1976, with the
constraints by their multipliers y). Modes themselves need no derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffkit.link import Superelement
from stiffkit.vibration.modes import Array, ModalModel, Modes

_EQUAL = 1e-6
"""Frequencies as near as this, over the frequency, are one: their mean has a derivative."""
_MODES = 6
"""Modes that are looked at for equal frequencies."""


@dataclass(frozen=True, eq=False)
class Change:
    """One change of a robot, as neighbours on both sides of it."""

    models: Sequence[ModalModel]
    """Of the robot changed a little, as far as `weights` say."""
    q: Sequence[Array]
    """(n_coordinates, N) each, of the same N postures in the changed robots."""
    weights: Sequence[float]
    """Of what is read off each of them, so that the sum is the derivative."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """The lowest frequency of N postures and its derivatives along k changes."""

    lowest: Array
    """(N,), Hz; NaN where nothing vibrates."""
    slopes: Array
    """(k, N), Hz for a unit of each change."""


def lowest_frequency_slopes(
    model: ModalModel, q: Array, changes: Sequence[Change], length: float
) -> Slopes:
    """Return the lowest frequency at coordinates (n, N) and its derivatives along changes.

    Where the lowest frequencies are equal the derivative is the mean of theirs, which is what a
    central difference shows of the lowest. ``length`` is the one all models are made with, m.
    """
    N = q.shape[1]
    lowest, slopes = np.full(N, np.nan), np.full((len(changes), N), np.nan)
    terms = [_Terms.of(modes, parts) for modes, parts in _solved(model, q)]
    for i, term in enumerate(terms):
        if term is not None:
            lowest[i], slopes[:, i] = term.frequency, 0.0
    for k, change in enumerate(changes):
        for near, moved, weight in zip(change.models, change.q, change.weights, strict=True):
            turned = _alignment(model, near, length)
            for i, parts in enumerate(_parts(near, moved)):
                term = terms[i]
                if term is not None:
                    slopes[k, i] += weight * term.changed(parts, turned)
    return Slopes(lowest, slopes)


@dataclass(frozen=True, eq=False)
class _Parts:
    """The matrices that a posture's modes come from."""

    loops: Array
    energy: Array
    mass_root: Array
    names: list[str]


def _parts(model: ModalModel, q: Array) -> list[_Parts]:
    return [_Parts(at.loops, at.energy, root, at.names) for at, root in model.assembled(q)]


def _solved(model: ModalModel, q: Array) -> list[tuple[Modes, _Parts]]:
    return list(zip(model.at_each(q, _MODES), _parts(model, q), strict=True))


@dataclass(frozen=True, eq=False)
class _Terms:
    """What the derivative of a posture's lowest frequency is made of."""

    frequency: float
    modes: Array
    """(n, r), all of the lowest frequency."""
    multipliers: Array
    w: float

    @staticmethod
    def of(modes: Modes, parts: _Parts) -> _Terms | None:
        if not modes.frequencies_hz.size:
            return None
        lowest = float(modes.frequencies_hz[0])
        X = modes.shapes[:, modes.frequencies_hz <= lowest * (1.0 + _EQUAL)]
        w = (2.0 * np.pi * lowest) ** 2
        rest = parts.energy.T @ (parts.energy @ X) - w * parts.mass_root.T @ (parts.mass_root @ X)
        multipliers = -np.asarray(np.linalg.lstsq(parts.loops.T, rest, rcond=None)[0], dtype=float)
        return _Terms(lowest, X, multipliers, w)

    def changed(self, parts: _Parts, turned: dict[str, Array]) -> float:
        """Return what `parts` of a changed robot add to the derivative of the frequency, Hz."""
        X = _in_own_modes(self.modes, parts.names, turned)
        # Roots of a mass are many; only their squares change smoothly.
        energy, mass = (np.sum((root @ X) ** 2) for root in (parts.energy, parts.mass_root))
        dw = energy - self.w * mass + 2.0 * np.sum(self.multipliers * (parts.loops @ X))
        return float(self.frequency * dw / (2.0 * self.w * X.shape[1]))


def _in_own_modes(X: Array, names: list[str], turned: dict[str, Array]) -> Array:
    """Return coordinates (n, r) with links' internal modes expressed by those of changed links."""
    X = X.copy()
    for link, Q in turned.items():
        rows = [i for i, name in enumerate(names) if name == f"{link}.mode"]
        X[rows] = Q @ X[rows]
    return X


def _alignment(model: ModalModel, near: ModalModel, length: float) -> dict[str, Array]:
    """Return, for each link, how its own modes are made of those of the changed link.

    Signs of modes, and modes of equal frequency, are any; an orthogonal matrix that makes them most
    alike changes smoothly with the link.
    """
    found = {}
    for name, element in model.bodies.elastic.items():
        other = near.bodies.elastic[name]
        if other is not element and element.mode_stiffness.size:
            overlap = _seen(other, length).T @ _seen(element, length)
            U, _, Vt = np.linalg.svd(overlap)
            found[name] = U @ Vt
    return found


def _seen(element: Superelement, length: float) -> Array:
    """Return what tells a link's modes apart (k, n): their shapes, or how they pull at ports."""
    p = element.n_of_ports
    if element.shapes.size:
        unit_free = np.tile([1.0] * 3 + [length] * 3, len(element.shapes) // 6)
        return np.asarray(unit_free[:, None] * element.shapes[:, p:])
    return np.asarray(element.mass[:p, p:])
