"""Scalars that remember what they were computed from, for derivatives without a compiler.

A kernel that is given them computes as it does with NumPy arrays, and leaves a tape behind; played
back, it gives the derivatives of one output with respect to all inputs, for a few times the cost of
the output (A. Griewank, A. Walther, Evaluating Derivatives, 2nd ed., SIAM 2008, chapter 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Tape:
    """The scalars of one computation, in the order in which they were made."""

    def __init__(self) -> None:
        """Begin with none."""
        self.scalars: list[Recorded] = []

    def variable(self, value: Array) -> Recorded:
        """Return an input, (N,)."""
        return Recorded(self, np.asarray(value, dtype=float), ())

    def gradient(self, seeded: Sequence[tuple[Any, Array]], inputs: Sequence[Recorded]) -> Array:
        """Return the derivatives (n, N) of the sum of outputs times seeds (N,).

        Outputs that are no scalars of the tape are constants.
        """
        shape = np.broadcast_shapes(*(np.shape(seed) for _, seed in seeded))
        adjoints: list[Array | None] = [None] * len(self.scalars)

        def add(scalar: Recorded, share: Array) -> None:
            known = adjoints[scalar.place]
            adjoints[scalar.place] = share if known is None else known + share

        for output, seed in seeded:
            if isinstance(output, Recorded):
                add(output, seed)
        with np.errstate(all="ignore"):
            for scalar in reversed(self.scalars):
                total = adjoints[scalar.place]
                if total is None:
                    continue
                for source, factor in scalar.sources:
                    # What a selection leaves out may be infinite, and still counts nothing.
                    add(source, np.where(total == 0.0, 0.0, total * factor))
                if scalar.sources:
                    adjoints[scalar.place] = None
        found = [adjoints[x.place] for x in inputs]
        nothing = np.zeros(shape)
        return np.array([np.broadcast_to(nothing if x is None else x, shape) for x in found])


class Recorded:
    """A scalar of a batch of postures, with the derivatives by what it was computed from."""

    __slots__ = ("place", "sources", "tape", "value")
    __array_ufunc__ = None  # so that an array on the left leaves the operation to this class

    def __init__(self, tape: Tape, value: Array, sources: tuple[tuple[Recorded, Any], ...]) -> None:
        """Append to the tape a value (N,), and each source with the derivative by it."""
        self.tape = tape
        self.value = value
        self.sources = sources
        self.place = len(tape.scalars)
        tape.scalars.append(self)

    def _made(self, value: Any, *sources: tuple[Any, Any]) -> Recorded:
        own = tuple((x, factor) for x, factor in sources if isinstance(x, Recorded))
        return Recorded(self.tape, np.asarray(value), own)

    def __neg__(self) -> Recorded:
        """Return ``-x``."""
        return self._made(-self.value, (self, -1.0))

    def __add__(self, other: Any) -> Recorded:
        """Return ``x + y``."""
        return self._made(self.value + value_of(other), (self, 1.0), (other, 1.0))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Recorded:
        """Return ``x - y``."""
        return self._made(self.value - value_of(other), (self, 1.0), (other, -1.0))

    def __rsub__(self, other: Any) -> Recorded:
        """Return ``y - x``."""
        return self._made(value_of(other) - self.value, (self, -1.0))

    def __mul__(self, other: Any) -> Recorded:
        """Return ``x y``."""
        y = value_of(other)
        return self._made(self.value * y, (self, y), (other, self.value))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Recorded:
        """Return ``x / y``."""
        inverse = 1.0 / np.asarray(value_of(other))
        value = self.value * inverse
        return self._made(value, (self, inverse), (other, -value * inverse))

    def __rtruediv__(self, other: Any) -> Recorded:
        """Return ``y / x``."""
        inverse = 1.0 / self.value
        value = value_of(other) * inverse
        return self._made(value, (self, -value * inverse))

    def apply(self, name: str) -> Recorded:
        """Return a function of one scalar by its name: sin, cos, sqrt or acos."""
        x = self.value
        match name:
            case "sin":
                return self._made(np.sin(x), (self, np.cos(x)))
            case "cos":
                return self._made(np.cos(x), (self, -np.sin(x)))
            case "sqrt":
                root = np.sqrt(x)
                return self._made(root, (self, 0.5 / root))
            case "acos":
                return self._made(np.arccos(x), (self, -1.0 / np.sqrt(1.0 - x * x)))
        raise ValueError(f"the derivative of '{name}' is not known")


def value_of(x: Any) -> Any:
    """Return the value of a scalar, recorded or not."""
    return x.value if isinstance(x, Recorded) else x


def recorded_where_less(a: Any, b: Any, then: Any, otherwise: Any) -> Any:
    """Return ``then`` where ``a < b`` and ``otherwise`` elsewhere, some of them recorded."""
    less = np.less(value_of(a), value_of(b))
    chosen = np.where(less, value_of(then), value_of(otherwise))
    for x in (then, otherwise):
        if isinstance(x, Recorded):
            weights = ((then, less.astype(float)), (otherwise, (~less).astype(float)))
            return x._made(chosen, *weights)
    return chosen
