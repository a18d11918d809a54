"""What a posture kernel is: a plain function of scalars, and the constants it reads."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from stiffkit.smallmat import Matrix, Vector, from_lower_triangle

Array = NDArray[np.float64]


class Constants:
    """The numbers of a robot that are the same in all postures, as one vector with named blocks.

    They are inputs of a compiled kernel, so that a changed dimension does not compile again. Only
    entries in which the topology shows are compiled in: zeros, and ones in rotation matrices.
    """

    def __init__(self) -> None:
        """Start empty."""
        self._blocks: dict[str, tuple[slice, tuple[int, ...]]] = {}
        self._parts: list[Array] = []
        self._rotations: list[bool] = []
        self._size = 0

    def add(self, name: str, array: Array, *, rotation: bool = False) -> None:
        """Append a block; ``rotation`` says that its ones belong to the topology too."""
        flat = np.array(array, dtype=float).ravel()
        start, self._size = self._size, self._size + flat.size
        self._parts.append(flat)
        self._rotations.append(rotation)
        self._blocks[name] = (slice(start, self._size), np.shape(array))

    def add_symmetric(self, name: str, S: Array) -> None:
        """Append the lower triangle of a symmetric matrix."""
        self.add(name, S[_lower(S.shape[0])])

    def copy(self) -> Constants:
        """Return a copy, to which blocks can be added."""
        copy = Constants()
        copy._blocks = dict(self._blocks)
        copy._parts = list(self._parts)
        copy._rotations = list(self._rotations)
        copy._size = self._size
        return copy

    def extended(self, name: str, array: Array) -> Constants:
        """Return a copy with one more block."""
        copy = self.copy()
        copy.add(name, array)
        return copy

    @property
    def values(self) -> Array:
        """All numbers, (m,)."""
        return np.concatenate([np.empty(0), *self._parts])

    @property
    def compiled_in(self) -> NDArray[np.bool_]:
        """Which of the numbers are compiled in, (m,)."""
        values = self.values
        sizes = [part.size for part in self._parts]
        rotation = np.repeat(np.array(self._rotations, dtype=bool), sizes)
        return np.asarray((values == 0.0) | (rotation & (np.abs(values) == 1.0)))

    @property
    def pattern(self) -> tuple[float | None, ...]:
        """The value of each entry that is compiled in, None for those that are inputs."""
        return tuple(
            value if exact else None
            for value, exact in zip(self.values.tolist(), self.compiled_in.tolist(), strict=True)
        )

    @property
    def layout(self) -> tuple[tuple[str, int], ...]:
        """Name of each block, and where it starts."""
        return tuple((name, where.start) for name, (where, _) in self._blocks.items())

    def where(self, name: str) -> slice:
        """Return where a block stands among the numbers."""
        return self._blocks[name][0]

    def read(self, c: Vector, name: str) -> Matrix:
        """Return a block out of the vector ``c`` that a kernel was given."""
        where, shape = self._blocks[name]
        return c[where].reshape(shape)

    def read_symmetric(self, c: Vector, name: str) -> Matrix:
        """Return a block that `add_symmetric` appended."""
        return from_lower_triangle(self.read(c, name))


@cache
def _lower(n: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of a lower triangle, row by row."""
    return np.tril_indices(n)


@dataclass(frozen=True, eq=False)
class Kernel:
    """A computation for one posture, written once for floats, batches and traces."""

    name: str
    function: Callable[[Vector, Vector], Vector]
    """Maps inputs (n,) and constants (m,) to outputs, all of them scalars."""
    n_inputs: int
    constants: Constants
    topology: Hashable = field(repr=False)
    """Whatever decides the outcome besides inputs and constants; equal topologies share code."""
    large: bool = False
    """Whether to compile it in pieces: much sooner done, and somewhat slower to run."""
